"""Two networks together: the mean of what they see, sides and outliers settled between them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.keypoints.blazepose import NAMES, BlazePose, Seen
from keypose.tracker.keypoints.detectors import detector_fingerprint, open_detector
from keypose.tracker.keypoints.joint_network import JointNetwork, SeenJoints
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.layouts import LAYOUTS
from keypose.tracker.keypoints.model_files import MODELS, THUNDER
from keypose.tracker.keypoints.paired import BLAZEPOSE_SHARE, DOWN_TRUNK, PairedNetwork
from keypose.tracker.keypoints.region import Region
from tests.tracker.keypoints import keypoint_cases as cases

REGION = Region(160.0, 120.0, 100.0)
PICTURE = np.zeros((240, 320, 3), np.uint8)
AT = [NAMES.index(joint) for joint in JOINTS]
LIMBS = [k for k, joint in enumerate(JOINTS) if joint.split("_")[1] not in DOWN_TRUNK]


def somebody() -> Seen:
    """Upright, and seen from behind: the left side is at the left."""
    uv = np.full((len(NAMES), 2), (160.0, 80.0))
    for k, name in enumerate(NAMES):
        joint = name.split("_")[-1]
        down = {"shoulder": 20, "elbow": 35, "wrist": 50, "hip": 55, "knee": 75, "ankle": 95}
        uv[k] += -10 * ("left" in name) + 10 * ("right" in name), down.get(joint, 0)
    p = np.arange(3.0 * len(NAMES)).reshape(-1, 3)
    visibility, around = np.linspace(0.5, 1.0, len(NAMES)), Region(150.0, 110.0, 90.0)
    return Seen(uv, visibility, p, 0.95, around, cases.disc(REGION))


@dataclass
class Fake:
    """A network that sees what it is told to."""

    seen: Seen
    looked: list[Region] = field(default_factory=list)
    fingerprint: str = "fake"

    def infer(self, picture: NDArray[np.uint8], region: Region) -> Seen:
        self.looked.append(region)
        return self.seen


@dataclass
class FakeJoints:
    """A network of joints that sees them where they are told to be."""

    uv: NDArray[np.float64]
    names: tuple[str, ...] = JOINTS
    fingerprint: str = "joints"
    sure: float = 0.9
    doubted: tuple[float, float] = (0.0, 0.0)

    def infer(self, picture: NDArray[np.uint8], region: Region) -> SeenJoints:
        return SeenJoints(self.uv, np.full(len(self.uv), self.sure))


def together(seen: Seen, uv: NDArray[np.float64]) -> Seen:
    return PairedNetwork(Fake(seen), FakeJoints(uv)).infer(PICTURE, REGION)


def together_doubted(seen: Seen, uv: NDArray[np.float64], sure: float) -> Seen:
    joints = FakeJoints(uv, sure=sure, doubted=(0.4, 0.6))
    return PairedNetwork(Fake(seen), joints).infer(PICTURE, REGION)


def test_a_joint_lies_between_where_both_see_it() -> None:
    seen = somebody()
    found = together(seen, seen.uv[AT] + (2.0, 0.0))
    shift = (found.uv - seen.uv)[AT][LIMBS]
    assert shift[:, 0] == pytest.approx(2.0 * (1 - BLAZEPOSE_SHARE), abs=0.05)
    assert shift[:, 1] == pytest.approx(0.0, abs=1e-9)
    others = np.delete(np.arange(len(NAMES)), AT)
    assert np.array_equal(found.uv[others], seen.uv[others])


def test_joints_are_moved_to_where_blazepose_has_them_on_the_body() -> None:
    seen = somebody()
    trunk = 35.0
    higher = seen.uv[AT].copy()
    for k, joint in enumerate(JOINTS):
        higher[k, 1] -= DOWN_TRUNK.get(joint.split("_")[1], 0.0) * trunk
    assert together(seen, higher).uv == pytest.approx(seen.uv, abs=1e-9)


def test_a_look_that_exchanges_left_and_right_is_exchanged_back() -> None:
    seen = somebody()
    found = together(seen.exchanged(), seen.uv[AT])
    assert found.uv[AT][LIMBS] == pytest.approx(seen.uv[AT][LIMBS])
    assert np.array_equal(found.visibility, seen.visibility)
    assert np.array_equal(found.p_hips, seen.p_hips)


def test_where_they_are_far_apart_the_network_of_joints_is_believed() -> None:
    seen = somebody()
    uv = seen.uv[AT].copy()
    wrist = JOINTS.index("left_wrist")
    uv[wrist] -= (40.0, 20.0)
    found = together(seen, uv)
    assert found.uv[AT[wrist]] == pytest.approx(uv[wrist], abs=0.5)


@pytest.mark.parametrize(("sure", "share"), [(0.3, 0.0), (0.5, 0.5), (0.7, 1.0)])
def test_joints_of_a_figure_that_is_hardly_known_as_a_person_count_little(
    sure: float, share: float
) -> None:
    seen = somebody()
    found = together_doubted(seen, seen.uv[AT] + (2.0, 0.0), sure)
    shift = (found.uv - seen.uv)[AT][LIMBS, 0]
    assert shift == pytest.approx(share * 2.0 * (1 - BLAZEPOSE_SHARE), abs=0.05)


def test_sides_are_not_exchanged_for_joints_that_are_not_believed() -> None:
    exchanged = somebody().exchanged()
    found = together_doubted(exchanged, somebody().uv[AT], 0.3)
    assert np.array_equal(found.p_hips, exchanged.p_hips)


def test_depth_sight_presence_mask_and_where_to_look_next_are_blazeposes() -> None:
    seen = somebody()
    found = together(seen, seen.uv[AT] + 1.0)
    assert np.array_equal(found.p_hips, seen.p_hips)
    assert np.array_equal(found.visibility, seen.visibility)
    assert (found.presence, found.next, found.mask) == (seen.presence, seen.next, seen.mask)


@pytest.mark.parametrize("what", ["nobody", "no numbers", "no joints"])
def test_what_one_of_them_does_not_see_is_as_blazepose_says(what: str) -> None:
    seen, uv = somebody(), somebody().uv[AT] + 3.0
    if what == "nobody":
        seen = replace(seen, presence=0.1)
    elif what == "no numbers":
        seen.uv[5] = np.nan
    else:
        uv[3] = np.nan
    assert together(seen, uv) is seen


FEET = {f"{side}_{end}" for side in ("left", "right") for end in ("heel", "foot_index")}
HANDS = {f"{side}_{end}" for side in ("left", "right") for end in ("pinky", "index", "thumb")}


@pytest.mark.parametrize(
    ("layout", "sure", "taken"),
    [
        ("COCO_17", 0.9, set()),
        ("HALPE_26", 0.9, FEET),
        ("COCO_WHOLEBODY_133", 0.9, FEET | HANDS),
        ("COCO_WHOLEBODY_133", 0.2, set()),
    ],
)
@pytest.mark.parametrize("exchanges", [False, True])
def test_feet_and_hands_are_taken_from_a_network_that_has_them_and_sees_them(
    layout: str, sure: float, taken: set[str], exchanges: bool
) -> None:
    seen, names = somebody(), LAYOUTS[layout]
    uv = np.full((len(names), 2), -1.0)
    uv[[names.index(joint) for joint in JOINTS]] = seen.uv[AT]
    others = {"heel": "heel", "foot_index": "big_toe", "thumb": "thumb2"}
    others |= {"pinky": "pinky_finger1", "index": "forefinger1"}
    place = {}
    for k, end in enumerate(sorted(taken)):
        side, _, point = end.partition("_")
        place[end] = uv[names.index(f"{side}_{others[point]}")] = 200.0 + k, 300.0
    blazepose = Fake(seen.exchanged() if exchanges else seen)
    found = PairedNetwork(blazepose, FakeJoints(uv, names, sure=sure)).infer(PICTURE, REGION)
    for k, name in enumerate(NAMES):
        if name not in JOINTS:
            assert found.uv[k].tolist() == list(place.get(name, seen.uv[k]))


@pytest.mark.parametrize("model", [m for m in MODELS if m.is_here], ids=lambda m: m.name)
def test_the_fingerprint_is_known_without_the_networks(model: object) -> None:
    assert open_detector(model).fingerprint == detector_fingerprint(model)  # type: ignore[arg-type]


def test_each_choice_is_told_from_the_others() -> None:
    assert len({detector_fingerprint(model) for model in MODELS}) == len(MODELS)


def test_a_real_man_is_found_nearer_than_by_blazepose_alone() -> None:
    blazepose, movenet = BlazePose.open(fast=False), JointNetwork.open(THUNDER, fast=False)
    both, errors = PairedNetwork(blazepose, movenet), np.zeros(2)
    with cases.balance() as video:
        for frame, marked in cases.marks().items():
            picture = video.frame(frame)
            region = Region.of_box(cases.around(marked), picture.shape[1], picture.shape[0])
            for _ in range(3):
                region = blazepose.infer(picture, region).next
            for k, network in enumerate((blazepose, both)):
                uv = network.infer(picture, region).uv
                off = [uv[NAMES.index(j)] - marked[j] for j in JOINTS if j in marked]
                errors[k] += np.mean(np.hypot(*np.transpose(off)))
    assert errors[1] < 0.9 * errors[0]
