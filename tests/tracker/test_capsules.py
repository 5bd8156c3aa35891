"""What is done with a body, done with one of capsules: tracked and fitted as one of cylinders."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from bench.sequences import video_of
from keypose.tracker.body.body import Body, preset
from keypose.tracker.body.modify import resized
from keypose.tracker.body.pose import joint_positions, moved, pose_transforms
from keypose.tracker.body.shapes import KINDS
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, interpolate
from keypose.tracker.fitting.pose import fit_pose_to_picture
from keypose.tracker.fitting.sizes import fit_sizes
from keypose.tracker.fitting.sizes.proportions import Proportions
from tests.rendering import scenes
from tests.rendering.motions import stride
from tests.rendering.render import render
from tests.tracker.tracking_cases import SMALL, Case, MemoryVideo, tracked

SEGMENTS = {"stride": (30, 48), "throw": (20, 38)}
KEYS = (8, 30, 55, 85)


def all_of(kind: str, body: Body) -> Body:
    """The body with parts of one shape only."""
    shapes = (KINDS[kind].like(part.shape) for part in body.parts)
    parts = zip(body.parts, shapes, strict=True)
    return body.replaced(tuple(part.model_copy(update={"shape": own}) for part, own in parts))


@cache
def rendered(name: str, kind: str) -> Case:
    """A motion of a person of this shape."""
    made = scenes.scene(name, size=SMALL).cut(*SEGMENTS[name])
    made = replace(made, skeleton=Skeleton.of(all_of(kind, made.skeleton.body)))
    return Case(made.skeleton, made.camera, made.truth, made.frames())


def error_cm(name: str, kind: str) -> float:
    shown = rendered(name, kind)
    (found,) = tracked(shown.tracker(0, len(shown.truth) - 1))
    return shown.error_cm(found.trajectory)


def test_a_body_of_capsules_is_tracked_as_exactly_as_one_of_cylinders() -> None:
    errors = {kind: [error_cm(name, kind) for name in SEGMENTS] for kind in ("capsule", "cylinder")}
    assert np.mean(errors["capsule"]) < 1.1 * np.mean(errors["cylinder"])
    for name, found in zip(SEGMENTS, errors["capsule"], strict=True):
        shown = rendered(name, "capsule")
        last = len(shown.truth) - 1
        straight = interpolate(shown.truth.pose(0), shown.truth.pose(last), 0, last)
        assert found < 0.2 * shown.error_cm(straight)


def test_a_rough_pose_of_capsules_is_brought_to_the_truth() -> None:
    shown = rendered("stride", "capsule")
    skeleton, here = shown.skeleton, 8
    sigma = np.where(skeleton.dof_turns == 1, np.radians(3.0), 0.015)
    off = sigma * np.random.default_rng(1).normal(size=len(sigma))
    rough = moved(skeleton, shown.truth.pose(here), off)
    video: Any = MemoryVideo(shown.pictures)
    keys = {key: shown.truth.pose(key) for key in (0, 16)}
    found = fit_pose_to_picture(video, shown.camera, skeleton, here, rough, keys, {})

    def away_px(pose: Any) -> float:
        poses = (pose, shown.truth.pose(here))
        at = [joint_positions(skeleton, pose_transforms(skeleton, p)) for p in poses]
        found, true = (shown.camera.project(p) for p in at)
        return float(np.linalg.norm(found - true, axis=-1).mean())

    assert found.way == "neighbours"
    assert away_px(found.pose) < 0.25 * away_px(rough)


def test_a_thickness_of_capsules_is_found_from_the_pictures() -> None:
    given = all_of("capsule", preset("adult_male"))
    person = resized(given, "left_thigh", thickness_factor=1.15)
    skeleton = Skeleton.of(person)
    whole = stride(skeleton)
    truth = Trajectory(0, whole.Rs_parent_part[list(KEYS)], whole.ps_camera_root[list(KEYS)])
    pictures = render(skeleton, truth, scenes.camera())
    video = video_of(len(pictures), lambda number: pictures[number])
    keyposes = {k: truth.pose(k) for k in range(len(KEYS))}
    found = fit_sizes(video, scenes.camera(), given, keyposes).alone
    assert found is not None
    ratios = Proportions.of(found.body).metres() / Proportions.of(given).metres()
    names = Proportions.of(given).names
    thigh = names.index("thigh")
    assert ratios[2 * thigh + 1] == pytest.approx(1.15, abs=0.05)
    assert ratios[2 * thigh] == pytest.approx(1.0, abs=0.03)
