"""A limb set right between keyframes: it is exact there, better around, and the rest as tracked."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.trajectory import Pass, Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.film_clock import FilmClock
from keypose.tracker.geometry.rotations import exp_rotation, rotation_from_euler, transform
from keypose.tracker.session.settings import ALL_CUES, TrackSettings
from keypose.tracker.tracking.cues.sources import GivenKeypoints
from keypose.tracker.tracking.film_beside import FilmBeside
from keypose.tracker.tracking.parts.limb_keyframes import KeyedParts
from keypose.tracker.tracking.prepared_film import PreparedFilm
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.tracking.tracker import Tracker
from keypose.tracker.video.clip_loader import AGAIN, ClipLoader
from tests.tracker.tracking.cues.people import CAMERA, SKELETON, Filmed, moving
from tests.tracker.tracking.test_tracker import same
from tests.tracker.tracking_cases import Case, case

ARM = ("right_upper_arm", "right_forearm", "right_hand")
LEG = ("left_thigh", "left_shin", "left_foot")
SPAN = (0, 12)
AT = 5
FILM = Filmed(moving())
WAYS: dict[str, TrackSettings] = {
    "full": TrackSettings(),
    "preview": TrackSettings(quality="preview"),
    "printed": TrackSettings(method="paper", passes=2),
}


@pytest.fixture(scope="module")
def person() -> Case:
    return case("stride", 30, 42)


def swung(pose: Pose, names: tuple[str, ...]) -> Pose:
    """A pose whose right arm is swung aside."""
    R, t = pose.writable()
    R[names.index(ARM[0])] @= exp_rotation(np.array([0.2, 0.0, 0.15]))
    return Pose(R, t)


def run(tracker: Tracker, settings: TrackSettings, span: tuple[int, int] = SPAN) -> SegmentResult:
    return tracker.run_segment(span, settings, lambda *_: None)


def hands(motion: Trajectory, shown: Any) -> np.ndarray:
    """(N, 2, 3) where elbow and wrist are."""
    parts = [shown.body.index(name) for name in ARM[1:]]
    return np.asarray(motion.transforms(shown)[:, parts][..., :3, 3])


def require_exact_there_and_as_tracked_elsewhere(
    found: Trajectory, base: Trajectory, key: KeyedParts, skeleton: Any, camera: Camera
) -> None:
    rest = [i for i in range(skeleton.part_count) if i not in key.parts]
    np.testing.assert_array_equal(found.Rs_parent_part[:, rest], base.Rs_parent_part[:, rest])
    np.testing.assert_array_equal(found.ps_camera_root, base.ps_camera_root)
    for end in (0, -1):
        np.testing.assert_array_equal(found.Rs_parent_part[end], base.Rs_parent_part[end])
    one = Trajectory(0, key.pose.Rs_parent_part[None], key.pose.p_camera_root[None])
    row = key.frame - found.first_frame
    there, set_there = hands(found, skeleton)[row, -1], hands(one, skeleton)[0, -1]
    assert np.linalg.norm(camera.project(there) - camera.project(set_there)) < 0.1
    off_root = there[2] - found.ps_camera_root[row, 2]
    assert off_root == pytest.approx(set_there[2] - key.pose.p_camera_root[2], abs=1e-3)


@pytest.mark.parametrize("way", WAYS)
def test_the_limb_is_exact_where_it_was_set_and_the_rest_to_the_byte_as_tracked(
    person: Case, way: str
) -> None:
    base = run(person.tracker(*SPAN), WAYS[way])
    pose = swung(base.trajectory.pose(AT), person.skeleton.body.names)
    key = KeyedParts.of(person.skeleton, AT, ARM, pose)
    found = run(person.tracker(*SPAN, keyed_parts=(key,)), WAYS[way])
    require_exact_there_and_as_tracked_elsewhere(
        found.trajectory, base.trajectory, key, person.skeleton, person.camera
    )
    assert found.steps[found.best_pass] == "limbs"


def test_of_what_was_tracked_before_only_the_limb_is_tracked_anew_to_the_same_motion(
    person: Case,
) -> None:
    settings, keys = TrackSettings(), {SPAN: "the segment without parts"}
    plain = person.tracker(*SPAN, keys=keys)
    base = run(plain, settings)
    pose = swung(base.trajectory.pose(AT), person.skeleton.body.names)
    key = KeyedParts.of(person.skeleton, AT, ARM, pose)
    steps: list[Pass] = []
    later = plain.renewed(person.skeleton, plain.keyposes, keyed_parts=(key,), keys=keys)
    expected = later.expected_steps(SPAN, settings)
    found = later.run_segment(SPAN, settings, lambda step, _: steps.append(step))
    assert {step.what for step in steps} == {"limbs"}
    assert len(steps) <= expected
    assert same(found, run(person.tracker(*SPAN, keyed_parts=(key,)), settings))
    assert same(run(plain.renewed(person.skeleton, plain.keyposes, keys=keys), settings), base)


def test_a_preview_of_a_limb_leaves_the_rest_as_it_was_tracked_with_more_care(
    person: Case,
) -> None:
    keys = {SPAN: "the segment without parts"}
    plain = person.tracker(*SPAN, keys=keys)
    base = run(plain, TrackSettings())
    pose = swung(base.trajectory.pose(AT), person.skeleton.body.names)
    key = KeyedParts.of(person.skeleton, AT, ARM, pose)
    later = plain.renewed(person.skeleton, plain.keyposes, keyed_parts=(key,), keys=keys)
    found = run(later, TrackSettings(quality="preview"))
    require_exact_there_and_as_tracked_elsewhere(
        found.trajectory, base.trajectory, key, person.skeleton, person.camera
    )


def test_a_limb_set_in_one_segment_changes_no_other(person: Case) -> None:
    key = KeyedParts.of(person.skeleton, 3, ARM, person.truth.pose(3))
    settings = TrackSettings()
    with_parts = run(person.tracker(0, 6, 12, keyed_parts=(key,)), settings, (6, 12))
    assert same(with_parts, run(person.tracker(0, 6, 12), settings, (6, 12)))


def test_an_arm_set_right_changes_nothing_of_a_leg_that_was_set_right_before(person: Case) -> None:
    skeleton, settings = person.skeleton, TrackSettings()
    wrong = person.truth.pose(AT).writable()[0]
    for name, turn in ((ARM[0], [0.2, 0.0, 0.15]), (LEG[0], [0.1, 0.0, 0.1])):
        wrong[skeleton.body.index(name)] @= exp_rotation(np.array(turn))
    pose = Pose(wrong, person.truth.pose(AT).p_camera_root)
    leg = KeyedParts.of(skeleton, AT, LEG, pose)
    arm = KeyedParts.of(skeleton, AT + 3, ARM, pose)
    alone, both = (
        run(person.tracker(*SPAN, keyed_parts=keyed), settings).trajectory.Rs_parent_part
        for keyed in ((leg,), (leg, arm))
    )
    np.testing.assert_array_equal(both[:, leg.parts], alone[:, leg.parts])
    assert np.abs(both[:, arm.parts] - alone[:, arm.parts]).max() > 0.05


# --- pictures that tell nothing, and keypoints


@pytest.fixture
def grey(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ClipLoader, "load", lambda *_: FILM.segment.clip)


def grey_tracker(keypoints: bool, *keyed: KeyedParts) -> Tracker:
    segment = FILM.segment
    poses = {segment.first_frame: segment.start, segment.last_frame: segment.end}
    source = GivenKeypoints(FILM.keypoints) if keypoints else None
    film: Any = type("Film", (), {"clip": segment.clip})()
    return Tracker(film, CAMERA, SKELETON, poses, keypoints=source, keyed_parts=keyed)


R_SIDE = rotation_from_euler(0.0, np.radians(80.0), 0.0)
MIDDLE = FILM.truth.ps_camera_root.mean(axis=0)
T_SIDE = transform(R_SIDE, MIDDLE - R_SIDE @ MIDDLE)


def from_the_side() -> FilmBeside:
    """The same motion as a camera aside films it, whose pictures are as grey."""
    count = FILM.truth.last_frame + 1
    Ts = np.broadcast_to(T_SIDE, (count, 4, 4))
    shown = Filmed(FILM.truth.carried(Ts[FILM.truth.first_frame :]))
    video: Any = type("Film", (), {"info": type("Info", (), {"frame_count": count})()})()
    film = PreparedFilm(video, CAMERA, (), False, AGAIN, None, None)
    return FilmBeside(film, FilmClock(), Ts, Ts, shown.keypoints)


@pytest.mark.usefixtures("grey")
def test_a_limb_that_is_set_right_is_held_by_the_other_film_as_well() -> None:
    segment = FILM.segment
    span, middle = (segment.first_frame, segment.last_frame), segment.first_frame + 6
    key = KeyedParts.of(SKELETON, middle, ARM, FILM.truth.pose(middle))
    flat = GivenKeypoints(replace(FILM.keypoints, p_hips=None))
    poses = {segment.first_frame: segment.start, segment.last_frame: segment.end}
    errors = []
    for films in ([], [from_the_side()]):
        video: Any = type("Film", (), {"clip": segment.clip})()
        tracker = Tracker(
            *(video, CAMERA, SKELETON, poses), keypoints=flat, keyed_parts=(key,), films=films
        )
        errors.append(error_m(run(tracker, TrackSettings(cues=("keypoints",)), span).trajectory))
    assert errors[1] < 0.6 * errors[0]


def error_m(motion: Trajectory) -> float:
    return float(
        np.linalg.norm(hands(motion, SKELETON) - hands(FILM.truth, SKELETON), axis=-1).mean()
    )


@pytest.mark.usefixtures("grey")
@pytest.mark.parametrize("cues", [("brightness",), ALL_CUES, ("keypoints",)])
def test_a_limb_set_right_where_it_is_lost_comes_right_around_there(cues: Any) -> None:
    segment, keypoints_on = FILM.segment, "keypoints" in cues
    span, middle = (segment.first_frame, segment.last_frame), segment.first_frame + 6
    settings = TrackSettings(cues=cues)
    key = KeyedParts.of(SKELETON, middle, ARM, FILM.truth.pose(middle))
    base = run(grey_tracker(keypoints_on), settings, span)
    found = run(grey_tracker(keypoints_on, key), settings, span)
    require_exact_there_and_as_tracked_elsewhere(
        found.trajectory, base.trajectory, key, SKELETON, CAMERA
    )
    most = 0.5 if not keypoints_on else 1.0
    assert error_m(found.trajectory) < most * error_m(base.trajectory)


@pytest.mark.usefixtures("grey")
def test_where_a_limb_was_set_right_nothing_of_it_is_in_doubt_any_more() -> None:
    segment = FILM.segment
    span, middle = (segment.first_frame, segment.last_frame), segment.first_frame + 6
    settings = TrackSettings(cues=ALL_CUES)
    key = KeyedParts.of(SKELETON, middle, ARM, FILM.truth.pose(middle))
    before, after = (
        run(tracker, settings, span).diagnostics.expected_error
        for tracker in (grey_tracker(True), grey_tracker(True, key))
    )
    assert before is not None
    assert after is not None
    hand = SKELETON.body.index("right_forearm")
    assert after[6, hand] <= before[6, hand]
    others = [i for i in range(SKELETON.part_count) if i not in key.parts]
    np.testing.assert_array_equal(after[:, others], before[:, others])
