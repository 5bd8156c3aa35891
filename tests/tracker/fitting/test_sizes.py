"""A body of wrong proportions, posed on pictures of a person, comes out as the person is."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from bench.sequences import video_of
from keypose.tracker.body.body import Body, preset
from keypose.tracker.body.modify import resized
from keypose.tracker.body.pose import Pose, joint_positions, pose_transforms
from keypose.tracker.body.raster import BodyMesh
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import SessionError
from keypose.tracker.fitting.sizes import Proposal, SizesFitted, fit_sizes
from keypose.tracker.fitting.sizes.contours import contour_of, learn_colours, offsets
from keypose.tracker.fitting.sizes.proportions import Proportions
from keypose.tracker.fitting.sizes.proposals import FLOATING_M, _floating
from keypose.tracker.fitting.sizes.residuals import Pictures
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import log_rotation
from keypose.tracker.session.settings import IgnoreMask
from keypose.tracker.solver.fit_joints import fit_picture
from keypose.tracker.solver.posed import BodyPoint
from keypose.tracker.video import Video
from keypose.tracker.video.clip_loader import WorkingSize
from tests.rendering.motions import stride, throw
from tests.rendering.render import render
from tests.rendering.scenes import camera

GIVEN = preset("adult_male")
CAMERA = camera()
KEYS = (8, 30, 55, 85)
OTHERS = (0, 70, 118)


@dataclass(frozen=True, eq=False)
class Case:
    """Pictures of a person, and the given body posed on some of them by the person's joints."""

    person: Body
    truth: Trajectory
    pictures: NDArray[np.uint8]
    keyposes: dict[int, Pose]

    @property
    def video(self) -> Video:
        return video_of(len(self.pictures), lambda number: self.pictures[number])

    def joints(self, frame: int) -> NDArray[np.float64]:
        """Pixels of the person's joints and landmarks."""
        return _joints(self.person, self.truth.pose(frame))


def _joints(body: Body, pose: Pose, zoom: float = 1.0) -> NDArray[np.float64]:
    skeleton = Skeleton.of(body)
    return CAMERA.zoomed(zoom).project(joint_positions(skeleton, pose_transforms(skeleton, pose)))


def _places(body: Body) -> list[BodyPoint]:
    own: list[BodyPoint] = [((i, (0.0, 0.0, 0.0)),) for i in range(len(body.parts))]
    marks: list[BodyPoint] = [
        ((i, p),) for i, part in enumerate(body.parts) for p in part.landmarks.values()
    ]
    return own + marks


def _person(kind: str) -> Body:
    changes = {
        "as given": {},
        "long": {name: {"length_factor": 1.08} for name in ("left_forearm", "left_shin")},
        "thick": {name: {"thickness_factor": 1.15} for name in ("left_shin", "left_thigh")},
        "boots": {"left_shin": {"thickness_factor": 1.6}, "left_thigh": {"thickness_factor": 1.15}},
    }
    body = GIVEN
    for name, factors in changes[kind].items():
        body = resized(body, name, **factors)
    return body


@cache
def _case(kind: str, zoom: tuple[float, ...] = (1.0,) * len((*KEYS, *OTHERS))) -> Case:
    person = _person(kind)
    skeleton = Skeleton.of(person)
    whole, frames = stride(skeleton), sorted((*KEYS, *OTHERS))
    truth = Trajectory(0, whole.Rs_parent_part[frames], whole.ps_camera_root[frames])
    keyposes = {}
    for key in KEYS:
        row = frames.index(key)
        pose = truth.pose(row)
        uv = _joints(person, pose, zoom[row])
        keyposes[row] = fit_picture(
            GIVEN, CAMERA.zoomed(zoom[row]), _places(GIVEN), uv, np.ones(len(uv)), [pose], pose
        ).pose
    shown = [
        render(
            skeleton,
            Trajectory(0, truth.Rs_parent_part[k : k + 1], truth.ps_camera_root[k : k + 1]),
            CAMERA.zoomed(zoom[k]),
        )[0]
        for k in range(len(frames))
    ]
    return Case(person, truth, np.stack(shown), keyposes)


@cache
def _found(kind: str) -> SizesFitted:
    case = _case(kind)
    return fit_sizes(case.video, CAMERA, GIVEN, case.keyposes)


def _fitted(kind: str) -> Proposal:
    """With other poses."""
    proposal = _found(kind).with_poses
    assert proposal is not None
    return proposal


def _ratios(body: Body) -> dict[str, tuple[float, float]]:
    """How much longer and thicker than the given body, by kind of part."""
    ours, given = Proportions.of(body), Proportions.of(GIVEN)
    ratios = (ours.metres() / given.metres()).reshape(-1, 2).tolist()
    return {name: tuple(pair) for name, pair in zip(given.names, ratios, strict=True)}


def _unchanged(found: SizesFitted) -> None:
    assert found.alone is None
    assert found.with_poses is None


def test_thicker_legs_are_found_to_a_quarter_and_nothing_else_changes() -> None:
    ratios = _ratios(_fitted("thick").body)
    for name, (length, thickness) in ratios.items():
        assert length == pytest.approx(1.0)
        expected = 1.15 if name in ("thigh", "shin") else 1.0
        assert thickness == pytest.approx(expected, abs=0.035 if expected > 1 else 1e-9)


def test_sizes_are_the_same_where_the_camera_zooms() -> None:
    zoom = (1.0, 1.2, 0.9, 1.1, 1.15, 0.95, 1.05)
    case = _case("thick", zoom)
    path = CameraPath(CameraPath.standing_still(len(zoom)).Ts_camera_world, np.array(zoom))
    found = fit_sizes(case.video, CAMERA, GIVEN, case.keyposes, path=path).with_poses
    assert found is not None
    for name, (length, thickness) in _ratios(found.body).items():
        assert length == pytest.approx(1.0, abs=0.02)
        expected = 1.15 if name in ("thigh", "shin") else 1.0
        assert thickness == pytest.approx(expected, abs=0.05)


def test_longer_forearms_and_shins_are_found_by_half_or_more() -> None:
    found = _fitted("long")
    ratios = _ratios(found.body)
    for name in ("forearm", "shin"):
        assert 1.04 < ratios[name][0] < 1.10
    others = [pair for name, pair in ratios.items() if name not in ("forearm", "shin")]
    assert np.abs(np.array(others) - 1).max() < 0.02


def test_a_size_that_differs_by_more_than_can_be_believed_is_named_and_left() -> None:
    found, given = _fitted("boots"), dict.fromkeys(Proportions.of(GIVEN).names, (1.0, 1.0))
    assert _ratios(found.body)["shin"] == pytest.approx(given["shin"])
    message = _found("boots").message
    assert "The best fit of the" in message
    assert "shin's width was unrealistic" in message
    assert 1.05 < _ratios(found.body)["thigh"][1] < 1.25


@pytest.mark.parametrize("kind", ["long", "thick"])
def test_joints_stay_where_the_pictures_show_them(kind: str) -> None:
    case, found = _case(kind), _fitted(kind)
    away = [_joints(found.body, found.keyposes[k]) - case.joints(k) for k in case.keyposes]
    assert np.linalg.norm(away, axis=-1).mean() < 2.0


def test_keyframes_that_are_not_looked_at_are_posed_anew_as_well(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    case = _case("thick")
    monkeypatch.setattr("keypose.tracker.fitting.sizes.sizes.MOST_LOOKED", 3)
    found = fit_sizes(case.video, CAMERA, GIVEN, case.keyposes).with_poses
    assert found is not None
    assert _ratios(found.body)["thigh"][1] > 1.1
    away = [_joints(found.body, found.keyposes[k]) - case.joints(k) for k in case.keyposes]
    assert np.linalg.norm(away, axis=-1).mean(axis=1).max() < 3.0


def test_both_sides_change_together() -> None:
    parts = {part.name: part for part in _fitted("thick").body.parts}
    for name in ("thigh", "shin"):
        assert parts[f"left_{name}"].shape == parts[f"right_{name}"].shape


def test_sizes_alone_leave_every_pose_as_it_was_set() -> None:
    case, found = _case("thick"), _found("thick").alone
    assert found is not None
    assert found.keyposes.keys() == case.keyposes.keys()
    for frame, pose in found.keyposes.items():
        np.testing.assert_array_equal(pose.Rs_parent_part, case.keyposes[frame].Rs_parent_part)
        np.testing.assert_array_equal(pose.p_camera_root, case.keyposes[frame].p_camera_root)
    assert not found.turns
    assert found.error_px < _found("thick").error_px
    assert 1.1 < _ratios(found.body)["thigh"][1] < 1.2


def test_proposed_poses_turn_limbs_only_and_say_by_how_much() -> None:
    case, found = _case("long"), _fitted("long")
    trunk = [GIVEN.index(name) for name in ("waist", "chest", "neck", "head")]
    for frame, pose in found.keyposes.items():
        was, now = (p.Rs_parent_part for p in (case.keyposes[frame], pose))
        np.testing.assert_array_equal(now[trunk], was[trunk])
        turn = np.degrees(np.linalg.norm(log_rotation(np.swapaxes(was, -1, -2) @ now), axis=-1))
        for part, deg in found.turns.get(frame, ()):
            assert deg == pytest.approx(turn[GIVEN.index(part)])
    assert found.turns


@pytest.mark.parametrize("kind", ["long", "thick"])
def test_feet_float_no_more_with_proposed_poses_than_before(kind: str) -> None:
    case, found = _case(kind), _fitted(kind)
    still = CameraPath.standing_still(len(KEYS)).Ts_world_camera
    before, after = (
        _floating(body, list(poses.values()), still, (0.0, -1.0, 0.0))
        for body, poses in ((GIVEN, case.keyposes), (found.body, found.keyposes))
    )
    assert after <= before + FLOATING_M


def test_right_sizes_stay_and_so_do_the_poses() -> None:
    found = _found("as given")
    _unchanged(found)
    assert found.message.startswith("No better sizes found. Unchanged.")


def test_what_was_found_is_reported_in_words_and_centimetres() -> None:
    found = _fitted("thick")
    assert _found("thick").message.startswith("2 sizes fit better.")
    changes = {(part, what): (before, after) for part, what, before, after in found.changes}
    before, after = changes["thigh", "width"]
    shape: Any = GIVEN.parts[GIVEN.index("left_thigh")].shape
    assert before == pytest.approx(50 * sum((*shape.start_radii_m, *shape.end_radii_m)))
    assert 1.1 < after / before < 1.2


def test_the_same_pictures_give_the_same_sizes() -> None:
    case = _case("thick")
    again = fit_sizes(case.video, CAMERA, GIVEN, case.keyposes).with_poses
    assert again is not None
    assert again.body == _fitted("thick").body


@pytest.mark.parametrize("count", [0, 1])
def test_fewer_than_two_keyframes_are_refused(count: int) -> None:
    case = _case("as given")
    with pytest.raises(SessionError, match="two keyframes or more"):
        fit_sizes(case.video, CAMERA, GIVEN, dict(list(case.keyposes.items())[:count]))


def test_featureless_pictures_change_nothing_and_say_so() -> None:
    case = _case("thick")
    grey = replace(case, pictures=np.full_like(case.pictures, 120))
    found = fit_sizes(grey.video, CAMERA, GIVEN, case.keyposes)
    _unchanged(found)
    assert "Sizes unchanged" in found.message


def test_what_is_masked_decides_nothing() -> None:
    case = _case("thick")
    corners = ((-1.0, -1.0), (640.0, -1.0), (640.0, 360.0), (-1.0, 360.0))
    mask = IgnoreMask(polygon=corners, first_frame=0, last_frame=len(case.pictures) - 1)
    _unchanged(fit_sizes(case.video, CAMERA, GIVEN, case.keyposes, masks=[mask]))


def test_a_fit_that_is_cancelled_changes_nothing() -> None:
    case, asked = _case("thick"), []

    def cancelled() -> bool:
        asked.append(True)
        return len(asked) > 2

    _unchanged(fit_sizes(case.video, CAMERA, GIVEN, case.keyposes, cancelled=cancelled))
    assert len(asked) == 3


def test_a_telephoto_camera_keeps_its_focal_length() -> None:
    case = _case("as given")
    update = {"projection": "telephoto", "telephoto_distance_m": 5.0}
    lens: Camera = CAMERA.model_copy(update=update)
    found = fit_sizes(case.video, lens, GIVEN, case.keyposes, focal=True)
    proposals = [some for some in (found.alone, found.with_poses) if some is not None]
    assert all(some.camera == lens for some in proposals)
    assert "telephoto" in found.message


def test_a_lens_taken_too_long_is_mended_where_the_person_stands_near() -> None:
    skeleton, frames = Skeleton.of(GIVEN), [5, 35, 60, 80, 110]
    whole = throw(skeleton)
    near = whole.ps_camera_root[frames] - np.array([0.0, 0.0, 3.2])
    truth = Trajectory(0, whole.Rs_parent_part[frames], near)
    lens = CAMERA.model_copy(update={"fx": 330.0, "fy": 330.0})
    pictures = render(skeleton, truth, lens)
    longer = lens.model_copy(update={"fx": 380.0, "fy": 380.0})
    keyposes = {}
    for k in range(len(frames)):
        pose = truth.pose(k)
        uv = lens.project(joint_positions(skeleton, pose_transforms(skeleton, pose)))
        start = Pose(pose.Rs_parent_part, pose.p_camera_root * (1.0, 1.0, 380 / 330))
        keyposes[k] = fit_picture(
            GIVEN, longer, _places(GIVEN), uv, np.ones(len(uv)), [start], start
        ).pose
    video = video_of(len(pictures), lambda number: pictures[number])
    whole_found = fit_sizes(video, longer, GIVEN, keyposes, focal=True)
    found = whole_found.with_poses
    assert found is not None
    assert 320 < found.camera.fx == found.camera.fy < 360
    assert "focal length is" in whole_found.message
    ratio = found.keyposes[0].p_camera_root[2] / keyposes[0].p_camera_root[2]
    assert ratio == pytest.approx(found.camera.fx / 380, abs=0.06)  # the person stands nearer


def test_a_contour_is_seen_to_a_share_of_a_pixel() -> None:
    case = _case("thick")
    skeleton = Skeleton.of(GIVEN)
    Ts = [pose_transforms(skeleton, case.truth.pose(k)) for k in case.keyposes]
    pictures = Pictures.of(case.video, CAMERA, WorkingSize(0), sorted(case.keyposes), ())
    seen = [contour_of(BodyMesh.of(skeleton), T, CAMERA) for T in Ts]
    colour_models = learn_colours(
        pictures.rgb, pictures.usable, pictures.cells, [contour.shown for contour in seen],
        np.arange(skeleton.part_count), pictures.plates,
    )  # fmt: skip
    for name, wider in (("thigh", 0.15), ("chest", 0.0)):
        shape: Any = GIVEN.parts[next(i for i, n in enumerate(GIVEN.names) if name in n)].shape
        radius = np.mean([*shape.start_radii_m, *shape.end_radii_m])
        parts = [i for i, n in enumerate(GIVEN.names) if name in n]
        away, expected = [], []
        for k, contour in enumerate(seen):
            own = np.isin(contour.parts, parts)
            away.append(offsets(contour, colour_models, k, 6.0)[own])
            expected.append(wider * radius * CAMERA.fx / Ts[k][0, 2, 3])
        found = np.concatenate(away)
        assert np.isfinite(found).mean() > 0.3
        assert np.nanmedian(found) == pytest.approx(np.mean(expected), abs=0.25)


def test_solved_sizes_and_the_body_made_of_them_agree() -> None:
    proportions = Proportions.of(GIVEN)
    sizes = np.random.default_rng(2).normal(0, 0.1, proportions.count)
    body = proportions.body_at(sizes)
    np.testing.assert_allclose(Skeleton.of(body).joints, proportions.skeleton_at(sizes).joints)
    ratios = Proportions.of(body).metres() / proportions.metres()
    np.testing.assert_allclose(np.log(ratios), sizes)


def test_sides_are_known_by_their_names_where_no_pairs_are_given() -> None:
    plain = GIVEN.model_copy(update={"mirror_pairs": ()})
    assert Proportions.of(plain).names == Proportions.of(GIVEN).names
    assert "forearm" in Proportions.of(plain).names
