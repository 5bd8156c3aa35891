"""What is lifted of films of a person with markers, against these."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bench.clips import person_reference
from bench.markers import LATE_S
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.lifting import LIFTED, turns
from keypose.tracker.storage.files import load_session
from keypose.tracker.storage.sidecars import keypoints_of_session

OF_MARKERS = {
    "femur": "hip",
    "tibia": "knee",
    "talus": "ankle",
    "humerus": "shoulder",
    "ulna": "elbow",
    "hand": "wrist",
}
NAMES = [f"{side}_{joint}" for joint in OF_MARKERS.values() for side in ("right", "left")]
"""The twelve joints that are compared."""


@dataclass(frozen=True, eq=False)
class Film:
    """A film of the keypoints that were found, with the markers' joints (N, 12, 3) about the
    middle of the hips in camera axes, m, frames without them left out; what is up, (3,)."""

    keypoints: Keypoints
    camera: Camera
    times_s: Array
    kept: Array
    truth: Array
    up: Array

    @classmethod
    def read(cls, session: Path, clip: Path) -> Film:
        """Of a session with keypoints of the clip's film, and the folder with its markers."""
        read = load_session(session / "session.json")
        keypoints = keypoints_of_session(read, session)
        assert keypoints is not None
        times = (np.arange(len(keypoints)) + keypoints.first_frame) / 60
        solved = json.loads((clip / "camera_solved.json").read_text())
        R = np.array(solved["R_camera_ground"])
        markers = json.loads((clip / "mocap.json").read_text())
        t = np.array(markers["time"])
        bodies = [f"{name}_{side}" for name in OF_MARKERS for side in "rl"]
        p = np.stack([np.array(markers["bodies"][name]["translation"]) for name in bodies], 1)
        at = times - LATE_S
        kept = (at >= t[0]) & (at <= t[-1])
        p = np.array([[np.interp(at[kept], t, p[:, j, a]) for a in range(3)] for j in range(12)])
        p = p.transpose(2, 0, 1) @ R.T
        return cls(keypoints, read.view.camera, times, kept, p - _hips(p), R[:, 1])

    @classmethod
    def of_person(cls, session: Path, folder: Path) -> Film:
        """Of the man on the beam, whose joints four cameras saw, through his own camera."""
        keypoints = keypoints_of_session(load_session(session / "session.json"), session)
        assert keypoints is not None
        _, camera, names, joints = person_reference(folder)
        order = [names.index(f"{name[0].upper()}{name.split('_')[1].title()}") for name in NAMES]
        frames = np.arange(len(keypoints)) + keypoints.first_frame
        p = joints[frames][:, order]
        R = json.loads((folder / "meta.json").read_text())["camera"]["R_world_to_cam"]
        kept = np.ones(len(frames), np.bool_)
        return cls(keypoints, camera, frames / 60, kept, p - _hips(p), np.array(R)[:, 2])

    def size_m(self) -> float:
        """Leg and trunk of the person."""
        return float(sizes(self.truth).mean())

    def of_network(self) -> Array:
        """BlazePose's own joints (N, 12, 3) in camera axes, to the person's size, m."""
        at = [self.keypoints.names.index(name) for name in NAMES]
        assert self.keypoints.p_hips is not None
        hips = self.keypoints.uv[:, at[:2]].mean(axis=1)
        rays = self.camera.back_project(hips, 1.0)
        p = self.keypoints.p_hips[:, at] @ turns(rays[:, :2])
        return np.asarray((p * self.size_m() / np.nanmean(sizes(p)))[self.kept])


def taken(p: Array) -> Array:
    """Of `LIFTED`, the joints that are compared."""
    return np.asarray(p[:, [LIFTED.index(name) for name in NAMES]])


def sizes(p: Array) -> Array:
    """Leg and trunk of joints (N, 12, 3)."""

    def way(a: int, b: int) -> Array:
        return np.asarray(np.linalg.norm(p[:, a] - p[:, b], axis=-1))

    legs = (way(0, 2) + way(2, 4) + way(1, 3) + way(3, 5)) / 2
    trunk = (p[:, 6] + p[:, 7] - p[:, 0] - p[:, 1]) / 2
    return np.asarray(legs + np.linalg.norm(trunk, axis=-1))


def _hips(p: Array) -> Array:
    return np.asarray(p[:, :2].mean(axis=1, keepdims=True))


def rigid(p: Array, onto: Array) -> Array:
    """Points (..., 3) turned and moved as one onto others."""
    a, b = p.reshape(-1, 3), onto.reshape(-1, 3)
    middle, there = a.mean(0), b.mean(0)
    u, _, v = np.linalg.svd((a - middle).T @ (b - there))
    turn = u @ np.diag([1, 1, np.sign(np.linalg.det(u @ v))]) @ v
    return np.asarray(((a - middle) @ turn + there).reshape(p.shape))


def _bend(p: Array, a: int, b: int, c: int) -> Array:
    u, v = p[:, a] - p[:, b], p[:, c] - p[:, b]
    cosine = (u * v).sum(1) / np.linalg.norm(u, axis=1) / np.linalg.norm(v, axis=1)
    return np.asarray(180 - np.degrees(np.arccos(np.clip(cosine, -1, 1))))


def _line(p: Array, right: int, left: int) -> float:
    way = (p[:, left] - p[:, right]).mean(0)
    return float(np.degrees(np.arctan2(way[2], way[0])))


def compared(name: str, p: Array, truth: Array, sigma: Array | None = None) -> str:
    """One row: joints (N, 12, 3) and their deviation (N, 12, 2) against those of markers, m."""
    good = np.isfinite(p).all(axis=(1, 2))
    p, truth = p[good], truth[good]
    p = p - _hips(p)
    turned = np.linalg.norm(rigid(p, truth) - truth, axis=2).mean() * 1e3
    off = p - truth
    fixed = np.linalg.norm(off, axis=2).mean() * 1e3
    across = np.sqrt((off[:, 2:, :2] ** 2).sum(-1).mean()) * 1e3
    along = np.sqrt((off[:, 2:, 2] ** 2).mean()) * 1e3
    knees = [np.abs(_bend(p, *k) - _bend(truth, *k)).mean() for k in ((0, 2, 4), (1, 3, 5))]
    row = (
        f"{name:34} {turned:5.1f} {fixed:6.1f} {across:7.1f} {along:6.1f}"
        f"  {_line(p, 0, 1):+6.1f} ({_line(truth, 0, 1):+.0f})"
        f" {_line(p, 6, 7):+6.1f} ({_line(truth, 6, 7):+.0f})  {knees[0]:4.1f} {knees[1]:4.1f}"
    )
    if sigma is not None:
        share = off / sigma[good][..., [0, 0, 1]]
        inside = np.abs(share[:, 2:]) < 1
        row += (
            f"  {np.sqrt((share[:, 2:, :2] ** 2).mean()):5.2f}"
            f" {np.sqrt((share[:, 2:, 2] ** 2).mean()):5.2f}"
            f"  {inside[..., :2].mean():4.0%} {inside[..., 2].mean():4.0%}"
        )
    return row


HEAD = (
    f"{'':34}   mm  camera  across  along  hip line (true) shoulders   knees °"
    "    error/σ    inside 1 σ"
)
