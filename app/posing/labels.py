"""What parts, their axes and their joints are called."""

from __future__ import annotations

from keypose.tracker.body.body import Body
from keypose.tracker.body.limb_groups import SIDES, kind_of

_AXES = {"x": "Bend", "y": "Twist", "z": "Side"}
_ROOT_AXES = {"x": "Lean", "y": "Turn", "z": "Tilt"}
_AXES_OF_KIND = {
    "head": {"x": "Nod", "y": "Turn", "z": "Tilt"},
    "neck": {"x": "Nod", "y": "Turn", "z": "Tilt"},
    "clavicle": {"x": "Twist", "y": "Forward", "z": "Raise"},
    "hand": {"x": "Side", "y": "Twist", "z": "Bend"},
    "foot": {"x": "Bend", "y": "Turn", "z": "Roll"},
}
_JOINTS = {
    "upper_arm": "shoulder",
    "forearm": "elbow",
    "hand": "wrist",
    "thigh": "hip",
    "shin": "knee",
    "foot": "ankle",
}


def part_label(name: str) -> str:
    """Such as "Right forearm"."""
    words = name.replace("_", " ").strip()
    return words[:1].upper() + words[1:]


def short_label(name: str) -> str:
    """Without its side: "Forearm"."""
    return part_label(kind_of(name))


def axis_labels(body: Body, name: str) -> dict[str, str]:
    """What turning the part about its x, y and z is called."""
    part = body.parts[body.index(name)]
    if part.parent is None:
        return dict(_ROOT_AXES)
    return dict(_AXES_OF_KIND.get(kind_of(name), _AXES))


def joint_label(name: str) -> str:
    """The joint at which a part hangs: "Left elbow"."""
    kind = kind_of(name)
    if kind not in _JOINTS:
        return f"{part_label(name)} joint"
    side = [word for word in name.split("_") if word in SIDES]
    return part_label(" ".join([*side, _JOINTS[kind]]))


def degrees_text(value_deg: float, sign: bool = False) -> str:
    """Write degrees to a tenth, with a true minus: "−8.0"."""
    return number_text(value_deg, 1, sign)


def number_text(value: float, digits: int, sign: bool = False) -> str:
    """Write a number with so many digits behind the point and a true minus; `sign` shows the plus,
    too.
    """
    rounded = round(value, digits) + 0.0
    text = f"{abs(rounded):.{digits}f}"
    if rounded < 0:
        return f"−{text}"
    return f"+{text}" if sign else text
