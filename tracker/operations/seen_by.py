"""Which film of a motion sees each joint at a moment, and how far from the body it shows it: what
the page says of films, and what files and reports do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Body
from keypose.tracker.body.modify import height
from keypose.tracker.body.pose import part_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.films.errors import FilmErrors
from keypose.tracker.films.sightings import SURE
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.film_clock import sampled
from keypose.tracker.geometry.rotations import Array, apply_transform
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints, joints_in
from keypose.tracker.keypoints.on_body import points_on_body
from keypose.tracker.operations.films import keypoints_of_films
from keypose.tracker.session.schema import Session
from keypose.tracker.session.views import View
from keypose.tracker.storage.tracks import Tracks

DISAGREE = 0.06
"""Share of the body's height: films disagree of a joint that two of them see surely and that lies
farther from the body than this in one of them. A detector's own place of a joint is 1 to 4 %."""


@dataclass(frozen=True, eq=False)
class SeenBy:
    """How V films see K joints of a body at N moments.

    views: ids of the films, in the order of the session.
    frames (N,): of the first film, ascending.
    ends (K, 2): the parts of the body that end and that begin at each joint.
    joints (K,): which of `JOINTS` they are.
    visibility (V, N, K): 0 where a film does not see a joint.
    px, aside_m (V, N, K): from where the body has a joint, in the film's picture, and in space from
        the ray of its camera; NaN where not seen.
    height_px (V, N): of the body in the film's picture.
    """

    views: tuple[str, ...]
    frames: NDArray[np.int64]
    ends: NDArray[np.int64]
    joints: NDArray[np.int64]
    visibility: Array
    px: Array
    aside_m: Array
    height_px: Array

    @property
    def off(self) -> Array:
        """(V, N, K) of joints in the picture, a share of the body's height."""
        return np.asarray(self.px / self.height_px[..., None])

    def errors(self, names: Mapping[str, str]) -> tuple[FilmErrors, ...]:
        """What every film shows of all `JOINTS`, at frames that follow one another.  names: of the
        films, by their ids."""
        px, aside_m = (
            np.full((*each.shape[:2], len(JOINTS)), np.nan) for each in (self.px, self.aside_m)
        )
        sure = self.visibility >= SURE
        px[..., self.joints] = np.where(sure, self.px, np.nan)
        aside_m[..., self.joints] = np.where(sure, self.aside_m, np.nan)
        return tuple(
            FilmErrors(names[view], int(self.frames[0]), px[v], aside_m[v])
            for v, view in enumerate(self.views)
        )

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
    visibility, px, aside_m = np.zeros(shape), np.full(shape, np.nan), np.full(shape, np.nan)
    height_px = np.full(shape[:2], np.nan)
    for number, view in enumerate(session.views):
        over = keypoints.get(view.id)
        if over is None:
            continue
        uv, visible = (each[:, indices] for each in _shown(view, over, frames))
        lenses, p = _before(session, view, frames, p_world)
        with np.errstate(invalid="ignore"):
            ahead = p[..., 2] > 0
        for row, lens in enumerate(lenses):
            px[number, row] = np.linalg.norm(lens.project(p[row]) - uv[row], axis=-1)
            aside_m[number, row] = _aside(p[row], lens.back_project(uv[row], 1.0))
            height_px[number, row] = height(body) * lens.fy / np.median(lens.depth(p[row]))
        is_seen = np.isfinite(px[number]) & (visible > 0) & ahead
        visibility[number] = np.where(is_seen, visible, 0.0)
        px[number] = np.where(is_seen, px[number], np.nan)
        aside_m[number] = np.where(is_seen, aside_m[number], np.nan)
    begins = [
        _beginning_at(body, int(part), point) for part, point in zip(parts, points, strict=True)
    ]
    ends = np.stack([parts, np.array(begins, np.int64)], axis=1)
    views = tuple(view.id for view in session.views)
    return SeenBy(views, frames, ends, indices, visibility, px, aside_m, height_px)


def errors_in_films(session: Session, tracks: Tracks, folder: Path) -> tuple[FilmErrors, ...]:
    """By how much a tracked motion misses what each film shows; nothing of one film alone.

    folder: of the session's file.  KeyposeError where keypoints cannot be read.
    """
    if not session.views[1:]:
        return ()
    skeleton, count = Skeleton.of(session.subject.body), len(tracks.ps_camera_root)
    frames = np.arange(tracks.first_frame, tracks.first_frame + count)
    Ts = part_transforms(skeleton, tracks.Rs_parent_part, tracks.ps_camera_root)
    Ts_world_part = session.film_camera.parts_to_world(Ts, frames)
    by_films = seen_by(session, keypoints_of_films(session, folder), frames, Ts_world_part)
    return by_films.errors({view.id: Path(view.video.path).name for view in session.views})


def _shown(view: View, keypoints: Keypoints, frames: NDArray[np.int64]) -> tuple[Array, Array]:
    """Where a film shows `JOINTS` (N, J, 2), and how surely (N, J), at frames of the first film;
    where it does not reach NaN and 0."""
    over, own = keypoints.over(0, view.video.frame_count - 1), view.film_clock.frames_at(frames)
    uv = sampled(joints_in(over, over.uv), own)
    return uv, np.nan_to_num(sampled(joints_in(over, over.visibility), own))


def _before(
    session: Session, view: View, frames: NDArray[np.int64], p_world: Array
) -> tuple[list[Camera], Array]:
    """The lens of a film at frames of the first, with its distortion, and points (N, K, 3) before
    it."""
    alone, last = session.alone(view.id), view.video.frame_count - 1
    own = np.clip(view.film_clock.frames_at(frames), 0, last)
    path, lens = alone.camera_path, alone.film_camera.lens
    if path is None:
        return [lens] * len(frames), apply_transform(view.T_camera_world, p_world)
    there = path.sampled(np.clip(own, 0, len(path) - 1))
    zoomed = {zoom: lens.zoomed(zoom) for zoom in set(there.zoom.tolist())}
    p = apply_transform(there.Ts_camera_world @ view.T_camera_world, p_world)
    return [zoomed[zoom] for zoom in there.zoom.tolist()], p


def _aside(p: Array, ray: Array) -> Array:
    """(K,) metres of points (K, 3) from rays (K, 3) of a camera."""
    along = ray / np.linalg.norm(ray, axis=-1, keepdims=True)
    return np.asarray(np.linalg.norm(np.cross(p, along), axis=-1))


def _beginning_at(body: Body, part: int, point: Array) -> int:
    """The part that begins at a point of another one; that one itself where none does."""
    for index, each in enumerate(body.parts):
        if each.parent == body.names[part] and np.allclose(each.joint_m, point):
            return index
    return part
