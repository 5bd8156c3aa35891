"""The usual names of joint markers, and where on the body they are."""

from __future__ import annotations

from collections.abc import Sequence

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError
from keypose.tracker.solver.body_points import BodyPoint

_LIMBS = {
    "Shoulder": "upper_arm",
    "Elbow": "forearm",
    "Wrist": "hand",
    "Hip": "thigh",
    "Knee": "shin",
    "Ankle": "foot",
}

JOINT_MARKERS = {
    **{f"L{joint}": (f"left_{part}",) for joint, part in _LIMBS.items()},
    **{f"R{joint}": (f"right_{part}",) for joint, part in _LIMBS.items()},
    "Neck": ("neck",),
    "hip": ("left_thigh", "right_thigh"),
    "Hip": ("left_thigh", "right_thigh"),
}
"""Markers with the parts at whose joint they are, or in the middle of whose joints."""

CENTRE_MARKERS = {"Head": "head"}
"""Markers with the part in the middle of whose shape they are."""

_ORIGIN = (0.0, 0.0, 0.0)


def places_of(skeleton: Skeleton, names: Sequence[str], file: str) -> tuple[BodyPoint, ...]:
    """Where on the body each named joint is; FormatError names the first one it does not have."""
    return tuple(_place(skeleton, name, file) for name in names)


def _place(skeleton: Skeleton, name: str, file: str) -> BodyPoint:
    """A part's joint, a landmark, or a marker of the usual names, in this order."""
    body = skeleton.body
    if name in body.names:
        return ((body.index(name), _ORIGIN),)
    for i, part in enumerate(body.parts):
        if name in part.landmarks:
            return ((i, part.landmarks[name]),)
    centred = CENTRE_MARKERS.get(name)
    if centred in body.names:
        i = body.index(centred)
        return ((i, body.parts[i].shape.centre),)
    parts = JOINT_MARKERS.get(name, ())
    if parts and set(parts) <= set(body.names):
        return tuple((body.index(part), _ORIGIN) for part in parts)
    raise FormatError(
        f"{file} names {name!r}, which is no joint of the body and no marker of it; its joints are "
        f"{', '.join(body.names)}."
    )
