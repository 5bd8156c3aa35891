"""The bodies of things: some that hands hold, and a bicycle.

A thing that is held hangs from its grip as it would from a hand: the joint of its first part is
where the hand is, and its face is toward the camera, as a person's is.

Sources
  [T] International Tennis Federation, Rules of Tennis 2024, appendix II: a racket of at most 73.7
      by 31.7 cm; those of adults are 68.5 cm (27 inches) long.
  [G] The R&A, Rules of Equipment 2019: a club of 45.7 to 116.8 cm, its grip round.
  [F] IFAB, Laws of the Game, law 2: a ball 68 to 70 cm around.
  [B] ISO 5775: a tyre of 28-622 is 678 mm across.
All else is estimated from what shops sell.
"""

from __future__ import annotations

from bench.presets.animals import Radii
from keypose.tracker.body.body import ALL_DOFS, Body, Dof, Limits, Part, Point
from keypose.tracker.body.shapes import Box, Capsule, Cylinder, Disc, Frustum, Shape

FIXED: Limits = {"x": (0, 0), "y": (0, 0), "z": (0, 0)}
ABOUT_X: Limits = {"y": (0, 0), "z": (0, 0)}
"""Of a wheel on its axle."""
STEERING: Limits = {"x": (0, 0), "y": (-80, 80), "z": (0, 0)}
"""Estimate: how far a handlebar turns until it meets the frame."""
HALF_AXLE_M = 0.05
"""Estimate: from the middle of a wheel to the fork's blade."""


def make_objects() -> tuple[Body, ...]:
    """All of them."""
    return _box(), _cylinder(), _ball(), _stick(), _racket(), _club(), _bicycle()


def _box() -> Body:
    shape = Box(low_m=(-0.1, -0.15, -0.1), high_m=(0.1, 0.15, 0.1))
    return _thing("box", [_root("box", shape)])


def _cylinder() -> Body:
    shape = Cylinder(start_m=0.15, end_m=-0.15, radius_m=0.05)
    return _thing("cylinder", [_root("cylinder", shape)])


def _ball() -> Body:
    shape = Capsule(start_m=-0.11, end_m=0.11, radius_m=0.11)
    return _thing("ball", [_root("ball", shape)], "Size: a football's, IFAB, Laws of the Game.")


def _stick() -> Body:
    shape = Cylinder(start_m=0.5, end_m=-0.5, radius_m=0.015)
    ends = {"top": (0.0, -0.5, 0.0), "bottom": (0.0, 0.5, 0.0)}
    return _thing("stick", [_root("stick", shape, ends)])


def _racket() -> Body:
    """A tennis racket. Its head is seen as if it were closed."""
    grip = Cylinder(start_m=-0.09, end_m=0.11, radius_m=0.016)
    shaft = Frustum(
        start_m=0.0, end_m=0.16, start_radii_m=(0.016, 0.012), end_radii_m=(0.06, 0.012)
    )
    head = Disc(low_m=(-0.13, 0.0, -0.012), high_m=(0.13, 0.345, 0.012), axis="z")
    parts = [
        _root("grip", grip, {"butt": (0.0, -0.09, 0.0)}),
        _fixed("throat", "grip", (0.0, 0.11, 0.0), shaft),
        _fixed("head", "throat", (0.0, 0.14, 0.0), head, {"tip": (0.0, 0.345, 0.0)}),
    ]
    return _thing("racket", parts, "Length: of adults' tennis rackets, 27 inches.")


def _club() -> Body:
    """A golfer's driver."""
    grip = _tube(-0.12, 0.15, (0.0135, 0.0135), (0.009, 0.009))
    shaft = _tube(-0.01, 0.785, (0.0075, 0.0075), (0.0045, 0.0045))
    head = Box(low_m=(-0.02, 0.0, -0.05), high_m=(0.1, 0.055, 0.05))
    parts = [
        _root("grip", grip, {"butt": (0.0, -0.12, 0.0)}),
        _fixed("shaft", "grip", (0.0, 0.15, 0.0), shaft),
        _fixed("head", "shaft", (0.0, 0.775, 0.0), head, {"toe": (0.1, 0.03, 0.0)}),
    ]
    return _thing("club", parts, "Length within The R&A's Rules of Equipment.")


WHEEL_M = 0.339
"""From a wheel's axle to the ground, as [B] has it."""
AXLE_Y = -0.06
"""Estimate: the wheels' axles, above that of the cranks."""
REAR_Z = 0.44
"""Estimate: the rear axle, behind the cranks'."""
FRONT_Z = -0.6
"""Estimate: the front axle."""
SEAT_Z = 0.12
"""Estimate: the seat tube."""
HEAD_Z = -0.55
"""Estimate: the axis of steering, behind the front axle by what keeps it straight."""
TOP_Y = -0.5
"""Estimate: the top tube."""
BAR_Y = -0.24
"""Estimate: the handlebar, above the top tube."""
CRANK_M = 0.17
"""What most cranks are: 165 to 175 mm."""


def _bicycle() -> Body:
    """A bicycle from the axle of its cranks, its front wheel toward the camera."""
    parts = [*_frame(), *_steered(), *_wheel("rear_wheel", "frame", (0.0, AXLE_Y, REAR_Z))]
    parts += _cranks()
    pairs = [(f"left_{name}", f"right_{name}") for name in ("fork", "crank", "pedal")]
    body = _thing(
        "bicycle",
        parts,
        "Wheels: 28-622 of ISO 5775, 678 mm. The down tube is left out and the steering axis "
        "upright, where others lean it by 18 degrees; wheels are seen as if they were closed.",
    )
    return body.model_copy(update={"mirror_pairs": tuple(pairs)})


def _frame() -> list[Part]:
    top_tube = Box(low_m=(-0.02, TOP_Y - 0.02, HEAD_Z), high_m=(0.02, TOP_Y + 0.02, SEAT_Z))
    seat_tube = Cylinder(start_m=0.03, end_m=TOP_Y - 0.12, radius_m=0.017)
    stays = Box(low_m=(-0.035, -0.02, 0.0), high_m=(0.035, 0.02, REAR_Z - SEAT_Z))
    bottom = Box(low_m=(-0.025, -0.025, -SEAT_Z - 0.04), high_m=(0.025, 0.025, 0.02))
    saddle = Box(low_m=(-0.07, -0.06, -0.15), high_m=(0.07, 0.0, 0.12))
    return [
        _root("frame", top_tube),
        _fixed("seat_tube", "frame", (0.0, 0.0, SEAT_Z), seat_tube),
        _fixed("bottom_tube", "frame", (0.0, 0.0, SEAT_Z), bottom),
        _fixed("stays", "frame", (0.0, AXLE_Y / 2, SEAT_Z), stays),
        _fixed("saddle", "seat_tube", (0.0, TOP_Y - 0.12, 0.0), saddle),
    ]


def _steered() -> list[Part]:
    bar = Box(low_m=(-0.3, BAR_Y - 0.015, -0.015), high_m=(0.3, BAR_Y + 0.015, 0.015))
    stem = Cylinder(start_m=0.1, end_m=BAR_Y, radius_m=0.02)
    ends = {"left_grip": (0.28, BAR_Y, 0.0), "right_grip": (-0.28, BAR_Y, 0.0)}
    parts = [
        _part("handlebar", "frame", (0.0, TOP_Y, HEAD_Z), bar, ("ry",), STEERING, ends),
        _fixed("stem", "handlebar", (0.0, 0.0, 0.0), stem),
    ]
    down = AXLE_Y - TOP_Y
    blade = Cylinder(start_m=0.08, end_m=down, radius_m=0.012)
    for side, out in (("left", 1), ("right", -1)):
        at = (out * HALF_AXLE_M, 0.0, FRONT_Z - HEAD_Z)
        parts.append(_fixed(f"{side}_fork", "handlebar", at, blade))
    return [*parts, *_wheel("front_wheel", "handlebar", (0.0, down, FRONT_Z - HEAD_Z))]


def _wheel(name: str, parent: str, joint_m: Point) -> list[Part]:
    tyre = Disc(low_m=(-0.016, -WHEEL_M, -WHEEL_M), high_m=(0.016, WHEEL_M, WHEEL_M))
    return [_part(name, parent, joint_m, tyre, ("rx",), ABOUT_X)]


def _cranks() -> list[Part]:
    ring = Disc(low_m=(-0.055, -0.09, -0.09), high_m=(-0.045, 0.09, 0.09))
    parts = [_part("cranks", "frame", (0.0, 0.0, 0.0), ring, ("rx",), ABOUT_X)]
    for side, out in (("left", 1), ("right", -1)):
        low, high = sorted((-0.015 * out, (CRANK_M + 0.015) * out))
        arm = Box(low_m=(-0.008, low, -0.015), high_m=(0.008, high, 0.015))
        tread = Box(low_m=(-0.05, -0.012, -0.04), high_m=(0.05, 0.012, 0.04))
        at = (out * 0.05, out * CRANK_M, 0.0)
        parts += [
            _fixed(f"{side}_crank", "cranks", (out * 0.075, 0.0, 0.0), arm),
            _part(f"{side}_pedal", f"{side}_crank", at, tread, ("rx",), ABOUT_X),
        ]
    return parts


def _thing(name: str, parts: list[Part], source: str = "") -> Body:
    text = f"{source} All else is estimated." if source else "Estimated."
    return Body(name=name, parts=tuple(parts), source=text)


def _tube(start: float, end: float, start_radii: Radii, end_radii: Radii) -> Frustum:
    return Frustum(start_m=start, end_m=end, start_radii_m=start_radii, end_radii_m=end_radii)


def _root(name: str, shape: Shape, landmarks: dict[str, Point] | None = None) -> Part:
    return Part(name=name, shape=shape, tracked=ALL_DOFS, landmarks=landmarks or {})


def _fixed(
    name: str,
    parent: str,
    joint_m: Point,
    shape: Shape,
    landmarks: dict[str, Point] | None = None,
) -> Part:
    """A part that does not move against its parent."""
    return _part(name, parent, joint_m, shape, (), FIXED, landmarks)


def _part(
    name: str,
    parent: str,
    joint_m: Point,
    shape: Shape,
    tracked: tuple[Dof, ...],
    limits: Limits,
    landmarks: dict[str, Point] | None = None,
) -> Part:
    return Part(
        name=name,
        parent=parent,
        joint_m=joint_m,
        shape=shape,
        tracked=tracked,
        limits_deg=limits,
        landmarks=landmarks or {},
    )
