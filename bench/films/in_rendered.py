"""Two rendered films of one motion, with exact truth."""

from __future__ import annotations

from typing import Final

import cv2
import numpy as np

from bench.films.man import about_hips
from bench.keeping import ROOT, digest, place_for
from bench.sequences import Sequence, sequence
from bench.table import Expected, Report
from keypose.tracker.body.resampling import resampled
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.films.cameras import at_scale_of, joints_of_pose, lengths_of
from keypose.tracker.films.offset import OffsetSearch, find_offsets
from keypose.tracker.films.sightings import Sightings
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.film_clock import FilmClock
from keypose.tracker.geometry.rotations import (
    Array,
    log_rotation,
    rotation_from_euler,
    transform,
)
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.tracking.cues.sources import GivenKeypoints
from keypose.tracker.tracking.film_beside import FilmBeside
from keypose.tracker.tracking.tracker import Tracker
from tests.rendering.render import render
from tests.rendering.settings import RenderSettings

RENDERED: Final = ("throw", "wash")
ASIDE_DEG: Final = 60.0
LATE: Final = 3.4
APART: Final = 48
BESIDE_SHARE: Final = 0.004
SHAKES_SHARE: Final = 0.004
"""Of the rendered films; by how much a detector puts a joint aside for good, and from frame to
frame, shares of the body's height."""
MOST_OFF_RENDERED: Final = 0.1
MOST_TURNED_DEG: Final = 0.5
MOST_JOINTS_CM: Final = 1.0


def rendered(report: Report) -> None:
    """Two rendered films, one of which began later, as a detector sees them that shakes."""
    columns = ("offset", "turn °", "place cm", "1 film cm", "2 films cm", "exact cm")
    table = report.table(
        f"rendered, {ASIDE_DEG:.0f}° aside and {LATE:g} frames later, keyframes every {APART}",
        *columns,
    )
    for name in RENDERED:
        shown = sequence(name)
        T, clock = _aside(shown.truth), FilmClock(LATE)
        film = _later(name, shown, T, clock)
        keypoints = [
            _shaken(each.skeleton, each.truth, each.camera, seed)
            for seed, each in enumerate((shown, film))
        ]
        sightings = [
            Sightings.of(each, shown.camera, len(pictures.truth))
            for each, pictures in zip(keypoints, (shown, film), strict=True)
        ]
        lengths_m = lengths_of(shown.skeleton.body)
        frames = list(range(0, len(shown.truth), APART))
        keyed = {frame: joints_of_pose(shown.skeleton, shown.truth.pose(frame)) for frame in frames}
        best, *_ = find_offsets(OffsetSearch(*sightings, 30.0, lengths_m, keyed=keyed), 1.0)
        count = np.arange(len(shown.truth))
        camera = at_scale_of(best.camera, sightings[1].at(best.clock, count), keyed)
        found_T = camera.T_camera_first
        turn = np.degrees(np.linalg.norm(log_rotation(found_T[:3, :3] @ T[:3, :3].T)))
        there, here = (-each[:3, :3].T @ each[:3, 3] for each in (found_T, T))
        off = abs(best.clock.begins - LATE)
        errors = [
            _off_cm(shown, film, keypoints, frames, beside)
            for beside in (None, (best.clock, found_T), (clock, T))
        ]
        table.row(
            name,
            float(off),
            float(turn),
            float(100 * np.linalg.norm(there - here)),
            *errors,
            expected=[
                Expected("offset", float(off), MOST_OFF_RENDERED, "frames"),
                Expected("turn", float(turn), MOST_TURNED_DEG, "°"),
                Expected("joints", errors[1], MOST_JOINTS_CM, "cm"),
            ],
        )


def _aside(truth: Trajectory) -> Array:
    """(4, 4) from the first camera's frame to that of one beside it."""
    middle = truth.ps_camera_root.mean(axis=0)
    R = rotation_from_euler(0.05, np.radians(ASIDE_DEG), 0.08)
    return transform(R, middle - R @ middle + np.array([0.2, 0.1, 0.3]))


def _later(name: str, shown: Sequence, T: Array, clock: FilmClock) -> Sequence:
    """The same motion as the other camera films it, at its own moments."""
    times = np.arange(len(shown.truth), dtype=float)
    moments = clock.moments_of(np.arange(int(len(shown.truth) - 1 - clock.begins)))
    Rs, ps = resampled(shown.truth.Rs_parent_part, shown.truth.ps_camera_root, times, moments)
    truth = Trajectory(0, Rs, ps).carried(np.broadcast_to(T, (len(moments), 4, 4)))
    place = place_for(
        f"beside-{name}", digest(truth.Rs_parent_part.tobytes(), ROOT / "tests/rendering"), ".npy"
    )
    if not place.is_file():
        pictures = render(shown.skeleton, truth, shown.camera, RenderSettings(seed=3))
        np.save(place, np.stack([cv2.cvtColor(each, cv2.COLOR_RGB2GRAY) for each in pictures]))
    return Sequence(shown.skeleton, shown.camera, truth, np.load(place))


def _shaken(skeleton: Skeleton, truth: Trajectory, camera: Camera, seed: int) -> Keypoints:
    """What a detector says that puts each joint beside where it is, and shakes."""
    rng = np.random.default_rng(seed)
    frames = range(truth.first_frame, truth.last_frame + 1)
    joints = np.stack([joints_of_pose(skeleton, truth.pose(frame)) for frame in frames])
    tall = camera.fy * 1.7 / float(np.median(joints[..., 2]))
    uv = camera.project(joints) + rng.normal(0.0, BESIDE_SHARE * tall, (1, len(JOINTS), 2))
    uv = uv + rng.normal(0.0, SHAKES_SHARE * tall, uv.shape)
    hips = about_hips(joints) + rng.normal(0.0, 0.05, joints.shape)
    return Keypoints(0, JOINTS, uv, np.ones(uv.shape[:2]), hips)


def _off_cm(
    shown: Sequence,
    film: Sequence,
    keypoints: list[Keypoints],
    frames: list[int],
    beside: tuple[FilmClock, Array] | None,
) -> float:
    """Mean distance of joints in space between keyframes, by one film or with another beside it."""
    films: list[FilmBeside] = []
    keyposes = shown.keyposes(frames)
    if beside is not None:
        clock, T = beside
        prepared = Tracker(film.video(), film.camera, film.skeleton, keyposes).prepared
        Ts = [np.broadcast_to(T, (len(each.truth), 4, 4)) for each in (film, shown)]
        films = [FilmBeside(prepared, clock, *Ts, keypoints[1])]
    tracker = Tracker(
        shown.video(),
        shown.camera,
        shown.skeleton,
        keyposes,
        keypoints=GivenKeypoints(keypoints[0]),
        films=films,
    )
    settings = TrackSettings(cues=("brightness", "keypoints"))
    off = []
    for span in tracker.spans:
        motion = tracker.run_segment(span, settings, lambda *_: None).trajectory
        truth = shown.truth.joints(shown.skeleton)[span[0] : span[1] + 1]
        away = np.linalg.norm(motion.joints(shown.skeleton) - truth, axis=-1)
        off.append(away[1:-1].mean())
    return 100 * float(np.mean(off))
