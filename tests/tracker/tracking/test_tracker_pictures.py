"""Tracking pictures that are missing, bent, large or foreign, and bodies partly tracked."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from keypose.tracker.body.body import Body, Part
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import interpolate
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.session.verdict import Verdict
from keypose.tracker.video.pyramid import LEVELS
from tests.tracker.tracking_cases import Case, case, tracked

KEYS = (0, 6, 12, 18)


@pytest.fixture(scope="module")
def person() -> Case:
    return case("stride", 30, 48)


@pytest.fixture(scope="module")
def box() -> Case:
    return case("tumbling_box", 20, 38)


@pytest.mark.parametrize("method", ["keypose", "paper"])
@pytest.mark.parametrize("missing", [(3,), (0, 6), (1, 2, 3, 4, 5)])
def test_missing_frames_cost_little_and_break_nothing(
    person: Case, method: str, missing: tuple[int, ...]
) -> None:
    whole, holed = (
        tracked(person.tracker(0, 6, missing=m), method=method)[0] for m in ((), missing)
    )
    assert np.isfinite(holed.trajectory.joints(person.skeleton)).all()
    assert holed.closing_error <= 1e-9
    straight = interpolate(person.truth.pose(0), person.truth.pose(6), 0, 6)
    if len(missing) == 1 and method == "keypose":
        assert person.error_cm(holed.trajectory) < 0.6 * person.error_cm(straight)
        assert person.error_cm(holed.trajectory) < 4 * person.error_cm(whole.trajectory)
    for pair in range(6):
        if pair in missing or pair + 1 in missing:
            assert holed.diagnostics.rank[pair] == 0


def test_a_missing_frame_reaches_the_loops_as_ignored_everywhere(person: Case) -> None:
    tracker = person.tracker(0, 6, missing=(3,))
    clip = tracker.loader((0, 6)).load(0, 6)
    for level in range(LEVELS):
        assert not clip.levels[level][3, ..., 3].any()


def test_the_verdict_names_the_frames_that_are_damaged(person: Case) -> None:
    result = tracked(person.tracker(0, 6, missing=(2, 3)))[0]
    assert result.verdict.kind != "good"
    if result.verdict.kind == "check":
        assert result.verdict == Verdict.check("damaged", (2, 3))


@pytest.mark.parametrize("quality", ["full", "preview"])
def test_neighbouring_keyframes_are_segments_too(person: Case, quality: str) -> None:
    results = tracked(person.tracker(0, 1, 2, 8), quality=quality)
    assert [len(r.trajectory) for r in results] == [2, 2, 7]
    for result in results[:2]:
        first = result.trajectory.first_frame
        for frame in (first, first + 1):
            found = result.trajectory.pose(frame)
            np.testing.assert_allclose(
                found.Rs_parent_part, person.truth.pose(frame).Rs_parent_part, atol=1e-12
            )


def test_a_static_camera_helps_and_never_hurts_much(box: Case) -> None:
    plain, static = (tracked(box.tracker(0, 18, static_camera=s))[0] for s in (False, True))
    assert box.error_cm(static.trajectory) < 1.5 * box.error_cm(plain.trajectory)


def test_a_camera_with_distortion_is_tracked_on_rectified_pictures(box: Case) -> None:
    bent = box.camera.model_copy(update={"distortion": (-0.25, 0.05, 0.0, 0.0, 0.0)})
    rows, columns = np.mgrid[0 : bent.height, 0 : bent.width]
    ideal = bent.back_project(np.stack([columns, rows], axis=-1).astype(float), 1.0)
    at = box.camera.project(ideal).astype(np.float32)
    shown = np.stack(
        [cv2.remap(p, at[..., 0], at[..., 1], cv2.INTER_CUBIC, borderMode=cv2.BORDER_REPLICATE)
         for p in box.pictures]
    ).astype(np.uint8)  # fmt: skip
    distorted = Case(box.skeleton, bent, box.truth, shown)
    (found,) = tracked(distorted.tracker(0, 18))
    (straight,) = tracked(box.tracker(0, 18))
    assert box.error_cm(found.trajectory) < 2.5 * box.error_cm(straight.trajectory)


def test_large_pictures_are_tracked_at_half_their_size(box: Case) -> None:
    large = np.stack([cv2.resize(p, None, fx=4, fy=4) for p in box.pictures[:9]]).astype(np.uint8)
    camera = Camera(
        width=1280, height=720, fx=box.camera.fx * 4, fy=box.camera.fy * 4,
        cx=box.camera.cx * 4 + 1.5, cy=box.camera.cy * 4 + 1.5,
    )  # fmt: skip
    shown = Case(box.skeleton, camera, box.truth, large)
    tracker = shown.tracker(0, 8)
    halved = tracker.scene((0, 8), 1.0).camera
    assert (halved.width, halved.height) == (640, 360)
    (found,) = tracked(tracker)
    straight = interpolate(box.truth.pose(0), box.truth.pose(8), 0, 8)
    assert box.error_cm(found.trajectory) < 0.4 * box.error_cm(straight)


def test_parts_that_are_not_tracked_follow_interpolation(person: Case) -> None:
    parts = [
        p.model_copy(update={"tracked": () if "shin" in p.name else p.tracked})
        for p in person.skeleton.body.parts
    ]
    skeleton = Skeleton.of(person.skeleton.body.replaced(parts))
    shown = Case(skeleton, person.camera, person.truth, person.pictures)
    (found,) = tracked(shown.tracker(0, 6))
    straight = interpolate(person.truth.pose(0), person.truth.pose(6), 0, 6)
    shin = skeleton.body.index("left_shin")
    np.testing.assert_allclose(
        found.trajectory.Rs_parent_part[:, shin], straight.Rs_parent_part[:, shin], atol=1e-6
    )
    assert np.isnan(found.diagnostics.observability[:, shin]).all()


def test_a_root_that_only_turns_stays_on_its_line() -> None:
    shown = case("tumbling_box", 20, 26)
    part = shown.skeleton.body.parts[0]
    turning = Part(**(dict(part) | {"tracked": ("rx", "ry", "rz")}))
    skeleton = Skeleton.of(Body(name="box", parts=(turning,)))
    here = Case(skeleton, shown.camera, shown.truth, shown.pictures)
    (found,) = tracked(here.tracker(0, 6))
    ps = shown.truth.ps_camera_root
    straight = np.linspace(ps[0], ps[6], 7)
    np.testing.assert_allclose(found.trajectory.ps_camera_root, straight, atol=5e-4)
