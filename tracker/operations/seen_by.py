"""Which film of a motion sees each joint at a moment, and how far from the body it shows it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Body
from keypose.tracker.body.modify import height
from keypose.tracker.films.sightings import SURE
from keypose.tracker.geometry.film_clock import sampled
from keypose.tracker.geometry.rotations import Array, apply_transform
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints, joints_in
from keypose.tracker.keypoints.on_body import points_on_body
from keypose.tracker.session.schema import Session
from keypose.tracker.session.views import View

DISAGREE = 0.06
"""Share of the body's height: films disagree of a joint that two of them see surely and that lies
farther from the body than this in one of them. A detector's own place of a joint is 1 to 4 %."""


@dataclass(frozen=True, eq=False)
class SeenBy:
    """How V films see K joints of a body at N moments.

    views: ids of the films, in the order of the session.
    frames (N,): of the first film, ascending.
    ends (K, 2): the parts of the body that end and that begin at each joint.
    visibility (V, N, K): 0 where a film does not see a joint.
    off (V, N, K): from where the body has a joint, a share of its height; NaN where not seen.
    """

    views: tuple[str, ...]
    frames: NDArray[np.int64]
    ends: NDArray[np.int64]
    visibility: Array
    off: Array

    def of_part(self, part: int | None) -> NDArray[np.bool_]:
        """(K,) the joints at which a part begins or ends; of the whole body all."""
        if part is None:
            return np.ones(len(self.ends), dtype=np.bool_)
        return np.asarray((self.ends == part).any(axis=1))

    def sees(self, joints: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """(V, N) whether a film sees any of some joints, of more than two half of them."""
        sure = self.visibility[:, :, joints] > SURE
        count = int(joints.sum())
        return np.asarray(sure.sum(axis=-1) >= max(1, count // 2 if count > 2 else 1))

    def disagree(self, joints: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """(N,) whether two films see one of some joints and cannot both be right of it."""
        sure = self.visibility[:, :, joints] > SURE
        off = np.where(sure, self.off[:, :, joints], 0.0)
        both = sure.sum(axis=0) > 1
        return np.asarray((both & (off.max(axis=0) > DISAGREE)).any(axis=-1))

    def best_at(self, frame: int, part: int | None) -> str | None:
        """The film in which a place is to be looked at: of those that see it, where the body lies
        farthest from what is seen; None where no film sees it."""
        row, joints = int(np.abs(self.frames - frame).argmin()), self.of_part(part)
        sees = self.sees(joints)[:, row]
        if not sees.any():
            return None
        sure = self.visibility[:, row, joints] > SURE
        off = np.where(sure, np.nan_to_num(self.off[:, row, joints]), 0.0).max(axis=-1)
        return self.views[int(np.where(sees, off, -1.0).argmax())]


def seen_by(
    session: Session,
    keypoints: Mapping[str, Keypoints],
    frames: NDArray[np.int64],
    Ts_world_part: Array,
) -> SeenBy:
    """How the films of a session see its motion.

    keypoints: by the view's id; a film without any sees nothing.  frames (N,): of the first film.
    Ts_world_part (N, P, 4, 4): the body there.
    """
    body = session.subject.body
    indices, parts, points = points_on_body(body, JOINTS)
    p_world = apply_transform(Ts_world_part[:, parts], points[:, None])[..., 0, :]
    shape = len(session.views), len(frames), len(indices)
    visibility, off = np.zeros(shape), np.full(shape, np.nan)
    for number, view in enumerate(session.views):
        over = keypoints.get(view.id)
        if over is None:
            continue
        uv, visible = _shown(view, over, frames)
        at, px_per_m = _projected(session, view, frames, p_world)
        away = np.linalg.norm(uv[:, indices] - at, axis=-1) / (px_per_m * height(body))
        is_seen = np.isfinite(away) & (visible[:, indices] > 0)
        visibility[number] = np.where(is_seen, visible[:, indices], 0.0)
        off[number] = np.where(is_seen, away, np.nan)
    begins = [
        _beginning_at(body, int(part), point) for part, point in zip(parts, points, strict=True)
    ]
    ends = np.stack([parts, np.array(begins, np.int64)], axis=1)
    return SeenBy(tuple(view.id for view in session.views), frames, ends, visibility, off)


def _shown(view: View, keypoints: Keypoints, frames: NDArray[np.int64]) -> tuple[Array, Array]:
    """Where a film shows `JOINTS` (N, J, 2), and how surely (N, J), at frames of the first film;
    where it does not reach NaN and 0."""
    over, own = keypoints.over(0, view.video.frame_count - 1), view.film_clock.frames_at(frames)
    uv = sampled(joints_in(over, over.uv), own)
    return uv, np.nan_to_num(sampled(joints_in(over, over.visibility), own))


def _projected(
    session: Session, view: View, frames: NDArray[np.int64], p_world: Array
) -> tuple[Array, Array]:
    """Pixels (N, K, 2) of a film's own picture at which points (N, K, 3) lie, and how many of them
    a metre there takes (N, 1)."""
    alone, last = session.alone(view.id), view.video.frame_count - 1
    own = np.clip(view.film_clock.frames_at(frames), 0, last)
    T = np.broadcast_to(view.T_camera_world, (len(frames), 4, 4))
    path, lens = alone.camera_path, alone.film_camera.lens
    zoom = np.ones(len(frames))
    if path is not None:
        there = path.sampled(np.clip(own, 0, len(path) - 1))
        T, zoom = there.Ts_camera_world @ T, there.zoom
    p = apply_transform(T, p_world)
    uv = np.full((*p.shape[:2], 2), np.nan)
    for each in np.unique(zoom):
        rows = zoom == each
        zoomed = lens.model_copy(update={"fx": lens.fx * each, "fy": lens.fy * each})
        uv[rows] = zoomed.project(p[rows])
    return uv, (zoom * lens.fy / np.median(lens.depth(p), axis=1))[:, None]


def _beginning_at(body: Body, part: int, point: Array) -> int:
    """The part that begins at a point of another one; that one itself where none does."""
    for index, each in enumerate(body.parts):
        if each.parent == body.names[part] and np.allclose(each.joint_m, point):
            return index
    return part
