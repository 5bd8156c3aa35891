"""What OpenCV's own pieces make of a moving camera, chained as its tutorials do."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array, nearest_rotation, rotation_between, transform

Grey = NDArray[np.uint8]
Masks = Callable[[int], NDArray[np.bool_] | None]

MOST = 600
QUALITY = 0.01
APART_PX = 7
FEWEST = 200
WINDOW = (21, 21)
EVERY = 8
"""Frames between those of which the essential matrix is asked."""
FAR = 1e4
"""Baselines beyond which a point is none: 50 by default, and most are farther than that here."""


@dataclass(eq=False)
class _Tracks:
    """Corners followed from one picture to the next; picked anew where few are left."""

    masks: Masks
    uv: Array = field(default_factory=lambda: np.zeros((0, 2), np.float32))
    ids: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    next_id: int = 0

    def over(self, pictures: Iterator[Grey]) -> Iterator[tuple[NDArray[np.int64], Array]]:
        """Ids and places of every frame, before new ones are picked."""
        before: Grey | None = None
        for frame, now in enumerate(pictures):
            if before is not None and len(self.uv):
                self._follow(before, now)
            hidden = self.masks(frame)
            if hidden is not None and len(self.uv):
                u, v = np.clip(np.rint(self.uv), 0, (now.shape[1] - 1, now.shape[0] - 1)).T
                open_ = ~hidden[v.astype(int), u.astype(int)]
                self.uv, self.ids = self.uv[open_], self.ids[open_]
            if len(self.uv) < FEWEST or frame % EVERY == 0:
                self._pick(now, hidden)
            yield self.ids, self.uv.astype(float)
            before = now

    def _follow(self, before: Grey, now: Grey) -> None:
        p = np.ascontiguousarray(self.uv[:, None], np.float32)
        q, there, _ = cv2.calcOpticalFlowPyrLK(before, now, p, None, winSize=WINDOW)
        back, again, _ = cv2.calcOpticalFlowPyrLK(now, before, q, None, winSize=WINDOW)
        close = np.linalg.norm(back - p, axis=-1)[:, 0] < 0.5
        good = (there[:, 0] > 0) & (again[:, 0] > 0) & close
        self.uv, self.ids = q[good, 0], self.ids[good]

    def _pick(self, now: Grey, hidden: NDArray[np.bool_] | None) -> None:
        where = (
            np.full(now.shape, 255, np.uint8) if hidden is None else 255 * (~hidden).astype("u1")
        )
        for u, v in np.rint(self.uv).astype(int):
            cv2.circle(where, (int(u), int(v)), APART_PX, 0, -1)
        most = MOST - len(self.uv)
        new = (
            cv2.goodFeaturesToTrack(now, most, QUALITY, APART_PX, mask=where) if most > 0 else None
        )
        if new is not None:
            self.uv = np.concatenate([self.uv.reshape(-1, 2), new[:, 0]])
            self.ids = np.concatenate([self.ids, self.next_id + np.arange(len(new))])
            self.next_id += len(new)


def turning(pictures: Iterator[Grey], camera: Camera, masks: Masks) -> CameraPath:
    """Homographies from picture to picture (RANSAC), each taken apart into turn and zoom."""
    Rs, zooms = [np.eye(3)], [1.0]
    frames = _Tracks(masks).over(pictures)
    for (ids, uv), (ids_now, uv_now) in pairwise(frames):
        _, one, other = np.intersect1d(ids, ids_now, return_indices=True)
        R, change = np.eye(3), 1.0
        if len(one) >= 8:
            H, _ = cv2.findHomography(uv[one], uv_now[other], cv2.RANSAC, 1.0)
            K = camera.K * np.array([[zooms[-1], 1, 1], [1, zooms[-1], 1], [1, 1, 1]])
            if H is not None:
                M = np.linalg.inv(K) @ H @ K
                M = M * np.sign(np.linalg.det(M))
                lengths = np.linalg.norm(M, axis=1)
                change = float(np.sqrt(lengths[0] * lengths[1]) / lengths[2])
                R = nearest_rotation(np.diag([1 / change, 1 / change, 1]) @ M)
        Rs.append(R @ Rs[-1])
        zooms.append(zooms[-1] * change)
    return CameraPath(transform(np.stack(Rs), np.zeros((len(Rs), 3))), np.array(zooms))


def moving(pictures: Iterator[Grey], camera: Camera, masks: Masks) -> CameraPath:
    """Essential matrices (RANSAC) of every eighth frame with the one before; how far each step is
    beside the last by the depths of points that both see. Between them evenly."""
    frames = [(ids, uv) for ids, uv in _Tracks(masks).over(pictures)]
    keys = [*range(0, len(frames) - 1, EVERY), len(frames) - 1]
    Ts, depths = [np.eye(4)], dict[int, float]()
    for a, b in pairwise(keys):
        T, depths = _step(frames[a], frames[b], camera, depths)
        Ts.append(T @ Ts[-1])
    return CameraPath(_filled(np.stack(Ts), keys), np.ones(len(frames)))


def _step(
    one: tuple[NDArray[np.int64], Array],
    other: tuple[NDArray[np.int64], Array],
    camera: Camera,
    depths: dict[int, float],
) -> tuple[Array, dict[int, float]]:
    """T of the second camera in the first, and depths of points in the second."""
    ids, i, j = np.intersect1d(one[0], other[0], return_indices=True)
    a, b = one[1][i], other[1][j]
    if len(ids) < 8:
        return np.eye(4), depths
    E, inside = cv2.findEssentialMat(a, b, camera.K, cv2.RANSAC, 0.999, 1.0)
    if E is None or E.shape != (3, 3):
        return np.eye(4), depths
    _, R, t, inside, _ = cv2.recoverPose(E, a, b, camera.K, distanceThresh=FAR, mask=inside)
    P = [camera.K @ np.hstack(Rt) for Rt in ((np.eye(3), np.zeros((3, 1))), (R, t))]
    X = cv2.triangulatePoints(*P, a.T, b.T)
    X = (X[:3] / X[3]).T
    ahead = (inside[:, 0] > 0) & (X[:, 2] > 0) & (X[:, 2] < 1e3)
    known = [
        depths[k] / x
        for k, x, ok in zip(ids.tolist(), X[:, 2], ahead, strict=True)
        if ok and k in depths
    ]
    scale = float(np.median(known)) if known else 1.0
    z = scale * ((X @ R.T)[:, 2] + t[2, 0])
    found = {k: float(d) for k, d, ok in zip(ids.tolist(), z, ahead, strict=True) if ok and d > 0}
    return transform(R, scale * t[:, 0]), found


def _filled(Ts: Array, keys: list[int]) -> Array:
    """All frames' (N, 4, 4) from those of the keys, evenly between."""
    filled = [Ts[:1]]
    for k, (a, b) in enumerate(pairwise(keys)):
        shares = np.arange(1, b - a + 1) / (b - a)
        R = rotation_between(Ts[k, :3, :3], Ts[k + 1, :3, :3], shares)
        p = Ts[k, :3, 3] + shares[:, None] * (Ts[k + 1, :3, 3] - Ts[k, :3, 3])
        filled.append(transform(R, p))
    return np.concatenate(filled)
