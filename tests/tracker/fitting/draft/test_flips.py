"""Limbs whose keypoints jump to something else for some frames."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TypeAlias

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.fitting.draft import ClipDraft, draft_from_keypoints
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.lifted_depth import DepthLifter
from tests.tracker.fitting.draft.clips import CAMERA, joints_of, place, walk

Places: TypeAlias = NDArray[np.float64]

FRAMES = 70
MOST_DEG = 35.0
"""What a draft of a limb may be off where its keypoints were not believed for some frames."""
LEG = ("knee", "ankle", "heel", "foot_index")
ARM = ("elbow", "wrist")
BONES = (
    ("shoulder", "elbow"),
    ("elbow", "wrist"),
    ("hip", "knee"),
    ("knee", "ankle"),
)


def drafted(keypoints: Keypoints, *, lifted: bool = False) -> ClipDraft:
    times_s = np.arange(len(keypoints)) / 30.0
    lifter = DepthLifter(CAMERA, times_s) if lifted else None
    return draft_from_keypoints(
        keypoints, CAMERA, walk(1).body, proportions=False, lifter=lifter
    )  # fmt: skip


def moved(
    keypoints: Keypoints,
    frames: range,
    joints: tuple[str, ...],
    to: Callable[[Places], Places],
    side: str = "left",
) -> Keypoints:
    """The keypoints with some of them elsewhere, as sure as ever."""
    uv, rows = keypoints.uv.copy(), slice(frames.start, frames.stop)
    for joint in joints:
        if f"{side}_{joint}" in keypoints.names:
            column = keypoints.names.index(f"{side}_{joint}")
            uv[rows, column] = to(uv[rows, column])
    return replace(keypoints, uv=uv)


def turns_deg(draft: ClipDraft, other: ClipDraft) -> NDArray[np.float64]:
    """(N, 8) by which the bones of two drafts of all frames differ."""
    along = []
    for each in (draft, other):
        p = joints_of(each.body, [each.poses[n] for n in sorted(each.poses)])
        bones = [
            p[:, place(f"{side}_{far}")] - p[:, place(f"{side}_{near}")]
            for side in ("left", "right")
            for near, far in BONES
        ]
        stacked = np.stack(bones, axis=1)
        along.append(stacked / np.linalg.norm(stacked, axis=-1, keepdims=True))
    cosine = (along[0] * along[1]).sum(-1)
    return np.asarray(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))


def by(u: float, v: float) -> Callable[[Places], Places]:
    return lambda uv: uv + np.array([u, v])


@pytest.mark.parametrize("lifted", [False, True], ids=["depth as found", "depth lifted"])
@pytest.mark.parametrize(
    ("frames", "joints", "to"),
    [
        (range(30, 33), LEG, by(-260, -180)),
        (range(30, 36), ("knee",), by(40, -300)),
        (range(30, 42), LEG, by(-220, -250)),
        (range(30, 40), ("knee",), by(200, -220)),
        (range(26, 38), ARM, by(240, 160)),
    ],
    ids=["leg, 3 frames", "knee, 6", "leg, 12", "knee, 10", "arm, 12"],
)
def test_a_limb_whose_sure_keypoints_are_on_something_else_stays_on_its_way(
    frames: range, joints: tuple[str, ...], to: Callable[[Places], Places], lifted: bool
) -> None:
    keypoints = walk(FRAMES, facing_deg=60).keypoints
    undisturbed = drafted(keypoints, lifted=lifted)
    found = drafted(moved(keypoints, frames, joints, to), lifted=lifted)
    assert turns_deg(found, undisturbed).max() < MOST_DEG
    assert found.flipped == ()


@pytest.mark.parametrize("facing_deg", [0.0, 60.0, 150.0])
def test_a_walk_that_is_seen_right_has_no_wrong_drafts(facing_deg: float) -> None:
    assert drafted(walk(FRAMES, facing_deg=facing_deg).keypoints).flipped == ()


def test_what_cannot_be_bridged_is_said_and_not_proposed_as_it_is() -> None:
    """Nobody knows what a leg did that is elsewhere when the film begins."""
    keypoints = walk(FRAMES, facing_deg=60).keypoints
    found = drafted(moved(keypoints, range(10), LEG, by(-220, -250)))
    (run,) = found.flipped
    assert (run.first_frame, run.parts) == (0, ("left_thigh",))
    assert 8 <= run.last_frame <= 13
    wrong = [p for p in found.proposals if p.frame <= run.last_frame]
    assert [(p.reason, p.parts) for p in wrong] == [("wrong", ("left_thigh",))]
    first = next(p for p in found.proposals if p.reason == "start")
    assert first.frame == run.last_frame + 1, "the first that is right"


@pytest.mark.parametrize("count", [14, 20])
def test_a_limb_that_is_elsewhere_in_all_of_a_short_film_is_said_to_be_wrong(count: int) -> None:
    keypoints = walk(count, facing_deg=60).keypoints
    found = drafted(moved(keypoints, range(count), LEG, by(-260, -180)))
    assert len(found.poses) == count
    assert found.flipped
    assert {proposal.reason for proposal in found.proposals} == {"wrong"}


@pytest.mark.parametrize("frames", [range(3), range(FRAMES - 6, FRAMES)], ids=["first", "last"])
def test_a_limb_that_is_elsewhere_at_an_end_of_the_film_is_said_to_be_wrong(frames: range) -> None:
    keypoints = walk(FRAMES, facing_deg=60).keypoints
    found = drafted(moved(keypoints, frames, LEG, by(-220, -250)), lifted=True)
    wrong = {f for run in found.flipped for f in range(run.first_frame, run.last_frame + 1)}
    assert wrong >= set(frames)
    assert len(wrong) < len(frames) + 6
    ends = [p.frame for p in found.proposals if p.reason in ("start", "end")]
    assert not wrong & set(ends)
