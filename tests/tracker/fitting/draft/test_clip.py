"""From a box on one frame to drafts of the clip: what is looked at, and what is said of boxes."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import KeypointError
from keypose.tracker.fitting.draft import DraftProgress, draft_clip, draft_from_keypoints
from keypose.tracker.fitting.draft.observed import Joints
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.keypoints.blazepose import NAMES, BlazePose, Seen
from keypose.tracker.keypoints.joint_network import SeenJoints
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.layouts import LAYOUTS
from keypose.tracker.keypoints.paired import PairedNetwork
from keypose.tracker.keypoints.region import Region
from tests.tracker.fitting.draft.clips import CAMERA, place, walk
from tests.tracker.keypoints.keypoint_cases import BOX, NO_MASK, balance, marks

CLIP = walk(12)


class Knowing:
    """A network that knows the clip; a picture holds nothing but its number."""

    fingerprint = "knowing"

    def __init__(self, presence: float = 1.0) -> None:
        self.presence = presence
        self.looked: list[int] = []

    def infer(self, picture: NDArray[np.uint8], region: Region) -> Seen:
        number = int(picture[0, 0, 0])
        self.looked.append(number)
        known = CLIP.keypoints
        assert known.p_hips is not None
        uv, p_hips = np.zeros((len(NAMES), 2)), np.zeros((len(NAMES), 3))
        for k, name in enumerate(NAMES):
            if name in known.names:
                uv[k], p_hips[k] = known.uv[number, place(name)], known.p_hips[number, place(name)]
        return Seen(uv, np.ones(len(NAMES)), p_hips, self.presence, region, NO_MASK)


def picture(number: int) -> NDArray[np.uint8]:
    return np.full((CAMERA.height, CAMERA.width, 3), number, np.uint8)


AROUND = (500.0, 60.0, 900.0, 680.0)


def test_every_frame_that_is_asked_for_is_looked_at_and_drafted() -> None:
    network = Knowing()
    reported: list[DraftProgress] = []
    draft = draft_clip(
        picture, (2, 9), 5, AROUND, CAMERA, CLIP.body, network, report=reported.append
    )
    assert sorted(draft.poses) == list(range(2, 10)) == sorted(set(network.looked))
    assert (draft.keypoints.first_frame, draft.keypoints.last_frame) == (2, 9)
    stages = [progress.stage for progress in reported]
    assert stages == sorted(stages)
    assert set(stages) == {"keypoints", "poses"}


class BlindToFeet(Knowing):
    """Puts heels and toes far beside where they are."""

    def infer(self, picture: NDArray[np.uint8], region: Region) -> Seen:
        seen = super().infer(picture, region)
        feet = [k for k, name in enumerate(NAMES) if name.endswith(("heel", "foot_index"))]
        seen.uv[feet] += 60.0
        return seen


class KnowingFeet(Knowing):
    """A network of 26 joints that knows the clip."""

    names = LAYOUTS["HALPE_26"]
    doubted = (0.0, 0.0)

    def infer(self, picture: NDArray[np.uint8], region: Region) -> SeenJoints:
        seen = super().infer(picture, region)
        uv = np.zeros((len(self.names), 2))
        for k, name in enumerate(self.names):
            its = name.replace("big_toe", "foot_index")
            uv[k] = seen.uv[NAMES.index(its)] if its in NAMES else 0.0
        return SeenJoints(uv, np.full(len(uv), 0.8))


def test_feet_are_drafted_from_a_network_that_sees_them() -> None:
    skeleton, off = Skeleton.of(CLIP.body), []
    for network in (BlindToFeet(), PairedNetwork(BlindToFeet(), KnowingFeet())):
        draft = draft_clip(picture, (0, 11), 5, AROUND, CAMERA, CLIP.body, network)
        foot = CLIP.body.index("left_foot")
        turned = [
            pose_transforms(skeleton, draft.poses[n])[foot, :3, :3].T
            @ pose_transforms(skeleton, CLIP.poses[n])[foot, :3, :3]
            for n in draft.poses
        ]
        off.append(np.median([np.arccos(np.clip((np.trace(R) - 1) / 2, -1, 1)) for R in turned]))
    assert off[1] < 0.25 * off[0]


def test_other_people_on_the_way_are_looked_for_by_what_is_given_for_that() -> None:
    alone, network, again = Knowing(), Knowing(), Knowing()
    given = (picture, (2, 9), 5, AROUND, CAMERA, CLIP.body)
    draft_clip(*given, alone)
    draft_clip(*given, network, again=again)
    assert again.looked
    assert network.looked + again.looked == alone.looked


@pytest.mark.parametrize(
    ("box", "words"),
    [
        ((2000.0, 10.0, 2100.0, 90.0), "outside the picture"),
        ((10.0, 10.0, 10.0, 10.0), "has no size"),
        ((float("nan"), 10.0, 90.0, 90.0), "no number"),
    ],
)
def test_a_box_that_is_none_is_refused_before_a_look(
    box: tuple[float, float, float, float], words: str
) -> None:
    network = Knowing()
    with pytest.raises(KeypointError, match=words):
        draft_clip(picture, (0, 11), 0, box, CAMERA, CLIP.body, network)
    assert not network.looked


def test_a_box_without_a_person_is_reported_with_its_frame() -> None:
    with pytest.raises(KeypointError, match="No person was found at frame 3"):
        draft_clip(picture, (0, 11), 3, AROUND, CAMERA, CLIP.body, Knowing(presence=0.1))


def test_what_the_report_raises_ends_the_looking() -> None:
    def leave(progress: DraftProgress) -> None:
        if progress.done == 4:
            raise KeyboardInterrupt

    network = Knowing()
    with pytest.raises(KeyboardInterrupt):
        draft_clip(picture, (0, 11), 0, AROUND, CAMERA, CLIP.body, network, report=leave)
    assert len(network.looked) < 12


def test_a_filmed_man_is_drafted_onto_his_marked_joints() -> None:
    body = preset("adult_male")
    with balance() as video:
        camera = Camera.guess(video.info.width, video.info.height)
        draft = draft_clip(video.frame, (0, 15), 0, BOX, camera, body, BlazePose.open())
    skeleton, away = Skeleton.of(draft.body), []
    points = Joints.of(skeleton).points
    for frame in sorted(set(marks()) & set(draft.poses)):
        found = camera.project(points.at(pose_transforms(skeleton, draft.poses[frame])))
        for name, uv in marks()[frame].items():
            if name in JOINTS:
                away.append(np.linalg.norm(found[place(name)] - uv))
    assert len(away) >= 10
    assert np.median(away) < 12  # of a man who is 400 px tall


def test_a_draft_names_where_the_person_may_change_and_goes_on_with_both() -> None:
    draft = draft_from_keypoints(CLIP.keypoints, CAMERA, CLIP.body, changes=[6])
    assert [p.frame for p in draft.proposals if p.reason == "person"] == [6]
    assert sorted(draft.poses) == list(range(12))
