"""How a body that is tracked before a moving camera lies on its picture and stands in the world."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from bench.camera_films import FEET, CameraFilm, camera_film, warped_turns
from bench.clips import clip
from bench.keyed import keyed
from bench.measures import Over, figures
from bench.real import WAYS, Posed
from bench.table import Expected, Table
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, joined
from keypose.tracker.geometry.rotations import Array, transpose
from keypose.tracker.geometry.steady import SteadyCamera
from keypose.tracker.operations.find_camera import find_camera, known_poses, with_scale
from keypose.tracker.operations.solve_space import solved
from keypose.tracker.operations.stand import stand
from keypose.tracker.operations.track import track_session
from keypose.tracker.session import Keyframe, Session, TrackSettings, VideoReference
from keypose.tracker.storage.fingerprints import Span
from keypose.tracker.storage.stretches import stretches
from keypose.tracker.tracking.pool import SegmentFinished
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.video import Video

EVERY = 15
FRAMES = 150
"""Frames from one keyframe to the next, and of a film that are tracked."""
STOOD = ("still hand", "walk-around", "dolly", "pan and zoom")
MOST_STRAY_MM = 8.0
MOST_PINNED_MM = 3.0
MOST_MORE_PX = 0.3
KEYS = (30, 50, 70)
FIRST = 30
SEEDS = 4
"""Keyframes of the real walk, the frame its turned film begins with, and disturbances of them."""


def standing(table: Table) -> None:
    """Feet that stand, of a person who is tracked from exact keyframes: mm off their mean."""
    for name in STOOD:
        film = camera_film(name)
        session, fitting = _tracked(film)
        whole = joined([fitting[span].trajectory for span in sorted(fitting)])
        (run,) = stretches(session, fitting)
        plain = solved(session, run).motion
        stood = stand(session, fitting).session
        (run,) = stretches(stood, fitting)
        pinned = solved(stood, run).motion
        off = [_stray_mm(session, whole), _stray_mm(session, plain), _stray_mm(stood, pinned)]
        seen = [_px(film, motion) for motion in (whole, pinned)]
        expected = [
            Expected("without pins", off[1], MOST_STRAY_MM, "mm"),
            Expected("pinned", off[2], MOST_PINNED_MM, "mm"),
        ]
        table.row(name, *off, *seen, expected=expected)


def _tracked(film: CameraFilm) -> tuple[Session, Mapping[Span, SegmentResult]]:
    """The session of a film with its camera found, and what was tracked."""
    assert film.skeleton is not None
    assert film.motion is not None
    skeleton, motion = film.skeleton, film.motion
    video = VideoReference(
        path=str(film.video),
        fingerprint="",
        frame_count=len(film),
        width=film.camera.width,
        height=film.camera.height,
        stands_still=False,
    )
    keyframes = tuple(
        Keyframe.of(skeleton, motion.pose(frame), frame, frame / 30)
        for frame in range(0, min(FRAMES, len(film)), EVERY)
    )
    session = Session.begin(
        video=video,
        camera=film.camera,
        body=skeleton.body,
        keyframes=keyframes,
        settings=TrackSettings(smooth=True),
    )
    with Video.open(film.video) as opened:
        session = find_camera(session, opened, known_poses(session, {})).applied(session)
        events = track_session(session, opened)
        found = [event.result for event in events if isinstance(event, SegmentFinished)]
    fitting = {result.span: result for result in found}
    return with_scale(session, fitting), fitting


def _stray_mm(session: Session, motion: Trajectory) -> float:
    """How far a standing foot's joint is from its mean in the world, at most."""
    body = session.subject.body
    Ts = session.film_camera.motion_to_world(motion).transforms(Skeleton.of(body))
    places = Ts[:, [body.index(name) for name in FEET]][..., :3, 3]
    return float(1000 * np.linalg.norm(places - places.mean(axis=0), axis=-1).max())


def _px(film: CameraFilm, motion: Trajectory) -> float:
    """Mean distance of joints in the picture from where they truly are."""
    assert film.skeleton is not None
    assert film.motion is not None
    rows = slice(motion.first_frame, motion.last_frame + 1)
    true = Trajectory(
        motion.first_frame, film.motion.Rs_parent_part[rows], film.motion.ps_camera_root[rows]
    )
    seen = [film.camera.project(one.joints(film.skeleton)) for one in (motion, true)]
    return float(np.linalg.norm(seen[0] - seen[1], axis=-1).mean())


def marks(table: Table) -> None:
    """The real walk between keyframes posed on its marks, from its own camera and from one that
    pans and shakes, as before and with its motion known: px at marks, over disturbed keyframes."""
    shown, film = clip("walk"), camera_film("warped walk")
    hand = keyed(shown, KEYS)
    Rs = warped_turns()
    turned = {f - FIRST: _carried(pose, Rs[f - FIRST]) for f, pose in hand.poses.items()}
    for way in ("brightness", "keypoints"):
        means: dict[str, list[float]] = {"still": [], "panned": [], "steady": []}
        with Video.open(shown.video) as still, Video.open(film.video) as panned:
            plain = Posed(shown, still, hand.skeleton, hand.poses)
            other = Posed(shown, panned, hand.skeleton, turned)
            steady = replace(other, prepared={}, steady=SteadyCamera.along(shown.camera, film.path))
            for seed in range(SEEDS):
                found = joined(WAYS[way](plain.disturbed(seed)).trajectories)
                means["still"].append(figures(shown, hand.skeleton, found, KEYS)["mean"])
                for name, before in (("panned", other), ("steady", steady)):
                    seen = joined(WAYS[way](before.disturbed(seed)).trajectories)
                    back = _back(seen, Rs)
                    means[name].append(figures(shown, hand.skeleton, back, KEYS)["mean"])
        over = {name: Over(tuple(values)) for name, values in means.items()}
        more = over["steady"].median - over["still"].median
        expected = [Expected("more", more, MOST_MORE_PX, "px")]
        table.row(way, *over.values(), expected=expected)


def _carried(pose: Pose, R: Array) -> Pose:
    own = pose.Rs_parent_part.copy()
    own[0] = R @ own[0]
    return replace(pose, Rs_parent_part=own, p_camera_root=R @ pose.p_camera_root)


def _back(seen: Trajectory, Rs: Array) -> Trajectory:
    """A motion before the panning camera as the still one sees it, by the film's own numbers."""
    Ts = np.tile(np.eye(4), (len(seen), 1, 1))
    Ts[:, :3, :3] = transpose(Rs[seen.first_frame : seen.last_frame + 1])
    moved = seen.carried(Ts)
    return Trajectory(seen.first_frame + FIRST, moved.Rs_parent_part, moved.ps_camera_root)
