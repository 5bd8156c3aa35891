"""The orders in which detectors list a body's keypoints, under one set of names.

COCO_17, and COCO_WHOLEBODY_133 after it: COCO and COCO-WholeBody, `keypoints` of their category.
OPENPOSE_18, BODY_25, BODY_25B: OpenPose, the maps POSE_…_BODY_PARTS in `poseParameters`.
HALPE_26: Halpe-FullBody, the 26 keypoints of the body, as AlphaPose writes them.
MEDIAPIPE_33: MediaPipe Pose, the enumeration `PoseLandmark`.

AP_10K: AP-10K, animals on four legs, `keypoints` of its categories; no file of a person has it.
"""

from __future__ import annotations

import re
from typing import Final

_FACE: Final = ("nose", "left_eye", "right_eye", "left_ear", "right_ear")
_TOES: Final = ("big_toe", "small_toe", "heel")


def _pairs(*joints: str) -> tuple[str, ...]:
    """The names of joints on both sides, each left, then right."""
    return tuple(f"{side}_{joint}" for joint in joints for side in ("left", "right"))


def _sides(first: str, second: str, joints: tuple[str, ...]) -> tuple[str, ...]:
    """All joints of one side, then all of the other."""
    return tuple(f"{side}_{joint}" for side in (first, second) for joint in joints)


_ARMS: Final = ("nose", "neck", *_sides("right", "left", ("shoulder", "elbow", "wrist")))
_LEGS: Final = _sides("right", "left", ("hip", "knee", "ankle"))
_EYES: Final = _pairs("eye", "ear")
_COCO_17: Final = (*_FACE, *_pairs("shoulder", "elbow", "wrist", "hip", "knee", "ankle"))
_FEET: Final = _sides("left", "right", _TOES)
_HAND: Final = (
    "hand_root",
    *(
        f"{finger}{joint}"
        for finger in ("thumb", "forefinger", "middle_finger", "ring_finger", "pinky_finger")
        for joint in range(1, 5)
    ),
)
_RIGHT_FIRST: Final = tuple(
    name.replace("left", "right") if name.startswith("left") else name.replace("right", "left")
    for name in _EYES
)

LAYOUTS: Final[dict[str, tuple[str, ...]]] = {
    "COCO_17": _COCO_17,
    "COCO_WHOLEBODY_133": (
        *_COCO_17,
        *_FEET,
        *(f"face_{i}" for i in range(68)),
        *_sides("left", "right", _HAND),
    ),
    "OPENPOSE_18": (*_ARMS, *_LEGS, *_RIGHT_FIRST),
    "BODY_25": (*_ARMS, "mid_hip", *_LEGS, *_RIGHT_FIRST, *_FEET),
    "BODY_25B": (*_COCO_17, "upper_neck", "head_top", *_FEET),
    "HALPE_26": (*_COCO_17, "head_top", "neck", "mid_hip", *_pairs(*_TOES)),
    "MEDIAPIPE_33": (
        "nose",
        *_sides("left", "right", ("eye_inner", "eye", "eye_outer")),
        *_pairs("ear", "mouth", "shoulder", "elbow", "wrist", "pinky", "index", "thumb"),
        *_pairs("hip", "knee", "ankle", "heel", "foot_index"),
    ),
}
"""By the layout's name its keypoints in order."""

AP_10K: Final = (
    *("left_eye", "right_eye", "nose", "neck", "tail_root"),
    *_sides("left", "right", ("shoulder", "elbow", "front_paw")),
    *_sides("left", "right", ("hip", "knee", "back_paw")),
)
NETWORK_LAYOUTS: Final = {**LAYOUTS, "AP_10K": AP_10K}
"""The same with that of networks of animals, which has as many keypoints as COCO's."""


def layouts_of(count: int) -> tuple[str, ...]:
    """The names of the layouts with so many keypoints."""
    return tuple(layout for layout, names in LAYOUTS.items() if len(names) == count)


def keypoint_name(name_in_file: str) -> str:
    """A name as a file writes it, LKnee or "Left Knee", in lower snake case: left_knee.

    What stands before a colon, as in `mixamorig:`, goes.
    """
    name_in_file = name_in_file.rsplit(":", 1)[-1]
    return _KNOWN.get(_plain(name_in_file)) or snake(name_in_file) or name_in_file


def _plain(name: str) -> str:
    return re.sub(r"[\W_]", "", name).lower()


def snake(name: str) -> str:
    """Words apart by underscores, in lower case: LKnee is l_knee."""
    apart = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name)
    return re.sub(r"[\W_]+", "_", apart).strip("_").lower()


def _spellings(name: str) -> tuple[str, ...]:
    """A name without underscores, and with the side as a letter before it or a word after it."""
    side, _, joint = name.partition("_")
    if side not in ("left", "right"):
        return (_plain(name),)
    joint = _plain(joint)
    return side + joint, side[0] + joint, joint + side


_KNOWN: Final = {
    spelling: name for names in LAYOUTS.values() for name in names for spelling in _spellings(name)
}
