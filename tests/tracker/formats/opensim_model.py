"""A small full-body model of OpenSim, written for tests: bodies and joints, nothing else.

Its places are round numbers, about as large as a man's; x forward, y up, z right.
"""

from __future__ import annotations

PLACES: dict[str, tuple[str, tuple[float, float, float]]] = {
    "pelvis": ("/ground", (0.0, 0.0, 0.0)),
    "torso": ("pelvis", (-0.10, 0.08, 0.0)),
    "head": ("torso", (0.0, 0.54, 0.0)),
    "femur_r": ("pelvis", (-0.07, -0.07, 0.08)),
    "tibia_r": ("femur_r", (-0.01, -0.40, 0.0)),
    "talus_r": ("tibia_r", (0.0, -0.42, 0.0)),
    "calcn_r": ("talus_r", (-0.05, -0.04, 0.01)),
    "toes_r": ("calcn_r", (0.18, 0.0, 0.0)),
    "humerus_r": ("torso", (0.0, 0.37, 0.17)),
    "ulna_r": ("humerus_r", (0.01, -0.29, -0.01)),
    "radius_r": ("ulna_r", (-0.01, -0.01, 0.02)),
    "hand_r": ("radius_r", (-0.01, -0.24, 0.01)),
}
"""By body the one that carries it, and where its joint is there; the left side mirrors it."""

COORDINATES: dict[str, tuple[str, tuple[str, ...]]] = {
    "pelvis": (
        "FreeJoint",
        ("pelvis_list", "pelvis_rotation", "pelvis_tilt", "pelvis_tx", "pelvis_ty", "pelvis_tz"),
    ),
    "torso": ("BallJoint", ("lumbar_bending", "lumbar_rotation", "lumbar_extension")),
    "femur_r": ("PinJoint", ("hip_flexion_r",)),
    "tibia_r": ("PinJoint", ("knee_angle_r",)),
}
"""By body the kind of its joint, and its coordinates; the others are welded."""


def both_sides() -> dict[str, tuple[str, tuple[float, float, float]]]:
    """`PLACES` with the left side."""
    left = {}
    for body, (carrier, (x, y, z)) in PLACES.items():
        if body.endswith("_r"):
            on = carrier.removesuffix("_r") + "_l" if carrier.endswith("_r") else carrier
            left[body.removesuffix("_r") + "_l"] = (on, (x, y, -z))
    return PLACES | left


def osim(without: str = "", version: str = "40500") -> bytes:
    """The file; `without` leaves a body out."""
    there = {body: place for body, place in both_sides().items() if body != without}
    bodies = "".join(_BODY.format(body) for body in there)
    joints = "".join(_joint(body, *place) for body, place in there.items())
    return (
        f'<OpenSimDocument Version="{version}"><Model name="small">'
        f'<BodySet name="bodyset"><objects>{bodies}</objects></BodySet>'
        f'<JointSet name="jointset"><objects>{joints}</objects></JointSet>'
        "</Model></OpenSimDocument>"
    ).encode()


_BODY = (
    '<Body name="{}"><mass>1</mass><mass_center>0 0 0</mass_center>'
    "<inertia>0.1 0.1 0.1 0 0 0</inertia></Body>"
)


def _joint(body: str, carrier: str, place: tuple[float, float, float]) -> str:
    base = carrier if carrier.startswith("/") else f"/bodyset/{carrier}"
    kind, names = COORDINATES.get(body, ("WeldJoint", ()))
    made = "".join(f'<Coordinate name="{name}"/>' for name in names)
    coordinates = f"<coordinates>{made}</coordinates>" if made else ""
    return (
        f'<{kind} name="{body}_joint"><socket_parent_frame>before</socket_parent_frame>'
        f"<socket_child_frame>/bodyset/{body}</socket_child_frame>{coordinates}<frames>"
        f'<PhysicalOffsetFrame name="before"><socket_parent>{base}</socket_parent>'
        f"<translation>{' '.join(map(str, place))}</translation></PhysicalOffsetFrame>"
        f"</frames></{kind}>"
    )
