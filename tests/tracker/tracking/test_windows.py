"""Pictures around the body alone: a motion is the same as in whole ones, and nothing is cut off."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any
from unittest.mock import patch

import numpy as np
import pytest

from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.preset_names import PRESETS
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import exp_rotation, transform
from keypose.tracker.geometry.steady import SteadyCamera
from keypose.tracker.tracking.frame_pair import capped_score
from keypose.tracker.tracking.initial.chains import follow
from keypose.tracker.tracking.method import FULL
from keypose.tracker.tracking.tracker import Tracker
from keypose.tracker.tracking.windows import body_windows, window_around
from keypose.tracker.video.clip_loader import ClipLoader, WorkingSize
from keypose.tracker.video.pyramid import Clip, Window
from tests.rendering.render import render
from tests.rendering.settings import RenderSettings
from tests.tracker.tracking_cases import (
    CAMERAS,
    Case,
    MemoryVideo,
    case,
    random_body,
    random_pose,
    scene_of,
    tracked,
)

BOX = case("tumbling_box", 20, 32)
PERSON = case("stride", 30, 42)


@contextmanager
def whole_pictures() -> Iterator[None]:
    """All pictures are prepared as wide as they are."""
    load = ClipLoader.load
    with patch.object(ClipLoader, "load", lambda self, first, last, *_: load(self, first, last)):
        yield


def area(clip: Clip) -> int:
    return clip.levels[0].shape[1] * clip.levels[0].shape[2]


def clip_of(tracker: Tracker) -> Clip:
    (span,) = tracker.spans
    return tracker.pictures(span)


def same(one: Trajectory, other: Trajectory) -> bool:
    rotations = np.array_equal(one.Rs_parent_part, other.Rs_parent_part)
    return rotations and np.array_equal(one.ps_camera_root, other.ps_camera_root)


def aside(film: Case, frame: int, uv: tuple[float, float]) -> Pose:
    """The pose of a frame moved by pixels across the picture."""
    pose, lens = film.truth.pose(frame), film.camera
    z = pose.p_camera_root[2]
    step = np.array([uv[0] * z / lens.fx, uv[1] * z / lens.fy, 0.0])
    return Pose(pose.Rs_parent_part, pose.p_camera_root + step)


def panned() -> tuple[Case, dict[str, Any]]:
    """The box before a camera that pans after it, and what a tracker is told of it."""
    frames = len(BOX.truth)
    turn = np.zeros((frames, 3))
    turn[:, 1] = np.linspace(0, 0.12, frames)
    path = CameraPath.of(exp_rotation(turn), np.zeros((frames, 3)), np.ones(frames))
    Ts = transform(path.Ts_camera_world[:, :3, :3], np.zeros((frames, 3)))
    truth = BOX.truth.carried(Ts)
    film = Case(
        BOX.skeleton, BOX.camera, truth, render(BOX.skeleton, truth, BOX.camera, RenderSettings())
    )
    return film, {"steady": SteadyCamera.along(BOX.camera, path)}


def cases() -> Iterator[Any]:
    for method in ("keypose", "paper"):
        for quality in ("full", "preview"):
            yield pytest.param(
                lambda: (PERSON, {}),
                {"method": method, "quality": quality},
                id=f"{method}, {quality}",
            )
    yield pytest.param(lambda: (PERSON, {"static_camera": True}), {}, id="static camera")
    yield pytest.param(lambda: (BOX, {"missing": (3,)}), {}, id="damaged")
    yield pytest.param(panned, {}, id="panned")
    yield pytest.param(lambda: (BOX, {}), {"initial": "templates"}, id="templates")


@pytest.mark.parametrize(("film", "settings"), list(cases()))
def test_a_motion_is_the_same_to_the_last_digit_as_in_whole_pictures(
    film: Callable[[], tuple[Case, dict[str, Any]]], settings: dict[str, Any]
) -> None:
    shown, more = film()
    last = len(shown.truth) - 1
    begun = area(clip_of(shown.tracker(0, last, **more)))
    (around,) = tracked(shown.tracker(0, last, **more), **settings)
    with whole_pictures():
        (everywhere,) = tracked(shown.tracker(0, last, **more), **settings)
    assert begun < 0.9 * shown.camera.width * shown.camera.height
    assert same(around.trajectory, everywhere.trajectory)
    assert around.verdict == everywhere.verdict


def test_a_chain_that_leaves_its_window_is_followed_in_a_wider_one() -> None:
    scene, start = BOX.scene(), BOX.truth.pose(0)
    video: Any = MemoryVideo(BOX.pictures)
    how = (FULL.stride, FULL.chain_inner, FULL.stop, FULL.finest)
    found, areas = [], []
    for window in (
        Window(0, 0, 320, 180),
        window_around(body_windows(scene.skeleton, scene.lens, *_one(start))),
    ):
        clip = ClipLoader(video, BOX.camera, WorkingSize(0)).load(0, 12, window)
        areas.append(area(clip))
        found.append(follow(scene, clip, start, 0, 12, *how))
        areas.append(area(clip))
    assert same(*found)
    assert areas[2] < areas[3] <= areas[0]


def _one(pose: Pose) -> tuple[Any, Any]:
    """A pose as an array of poses."""
    return pose.Rs_parent_part[None].copy(), pose.p_camera_root[None].copy()


def test_a_pose_that_lies_beside_the_window_is_scored_as_in_the_whole_picture() -> None:
    video: Any = MemoryVideo(BOX.pictures)
    clip = ClipLoader(video, BOX.camera, WorkingSize(0)).load(0, 12, Window(0, 0, 80, 80))
    scene = BOX.scene()
    expected = capped_score(scene, BOX.clip(), BOX.truth, 1)
    assert capped_score(scene, clip, BOX.truth, 1) == expected


def test_a_keyframe_that_is_dragged_out_of_the_window_is_tracked_as_by_a_fresh_tracker() -> None:
    tracker, last = BOX.tracker(0, 12), 12
    tracked(tracker)
    begun = area(clip_of(tracker))
    for uv in ((6.0, 0.0), (60.0, -20.0), (-70.0, 10.0)):
        moved = aside(BOX, last, uv)
        tracker.move_keyframe(last, moved)
        fresh = BOX.tracker(0, 12)
        fresh.move_keyframe(last, moved)
        (mine,), (other,) = tracked(tracker), tracked(fresh)
        assert same(mine.trajectory, other.trajectory)
        assert mine.verdict == other.verdict
    assert area(clip_of(tracker)) > 1.2 * begun


def test_a_keyframe_that_is_dragged_a_little_needs_no_other_pictures() -> None:
    tracker = BOX.tracker(0, 12)
    before = clip_of(tracker).shown
    for step in range(1, 5):
        tracker.move_keyframe(12, aside(BOX, 12, (1.0 * step, 0.5 * step)))
        assert clip_of(tracker).shown is before


@pytest.mark.parametrize("name", sorted(PRESETS))
@pytest.mark.parametrize("camera", CAMERAS.values(), ids=CAMERAS)
def test_the_window_holds_every_point_of_the_body(name: str, camera: Any) -> None:
    for seed in range(3):
        skeleton = Skeleton.of(preset(name)) if seed else random_body(seed)
        pose = random_pose(skeleton, seed, 0.7, 9.0)
        scene = scene_of(skeleton, camera, [pose])
        (found,) = body_windows(scene.skeleton, scene.lens, *_one(pose))
        Ts, points = pose_transforms(skeleton, pose), scene.points
        part = np.repeat(np.arange(skeleton.part_count), np.diff(points.starts))
        p = np.einsum("sab,sb->sa", Ts[part, :3, :3], points.points) + Ts[part, :3, 3]
        uv = camera.project(p)
        assert (uv >= found[:2] - 1e-6).all()
        assert (uv <= found[2:] + 1e-6).all()


def test_a_body_that_comes_too_near_is_looked_for_everywhere() -> None:
    pose = replace(PERSON.truth.pose(0), p_camera_root=np.array([0.0, 0.0, 0.1]))
    assert window_around(body_windows(PERSON.skeleton, PERSON.scene().lens, *_one(pose))) is None
