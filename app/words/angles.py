"""Word the angles of joints by their clinical names."""

from __future__ import annotations

from keypose.tracker.body.joint_angles import Angle


def angle_words(angle: Angle) -> tuple[str, str]:
    """What is positive and what is negative, such as "internal rotation"."""
    return _WORDS.get(angle.name, angle.name.replace("_", " ")), _WORDS.get(
        angle.other, angle.other.replace("_", " ")
    )


_WORDS = {
    "bending": "bending to the right",
    "bending_left": "to the left",
    "rotation": "rotation to the left",
    "rotation_right": "to the right",
    "obliquity": "obliquity, right up",
    "obliquity_left": "left up",
}
