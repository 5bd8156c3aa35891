"""The bodies of a dog and a horse, of estimated sizes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from keypose.tracker.body.body import ALL_DOFS, Body, Limits, Part, Point
from keypose.tracker.body.shapes import Box, Frustum

Radii: TypeAlias = tuple[float, float]

SIDEWAYS = 25
"""Estimate: how far a leg is led away from the trunk or under it."""
GIVE = 10
"""Estimate: what a leg yields about its own length, and a knee across its hinge."""
RANGES: dict[str, Limits] = {
    "neck": {"x": (-40, 125), "y": (-60, 60), "z": (-45, 45)},
    "head": {"x": (-60, 60), "y": (-45, 45), "z": (-30, 30)},
    "front_upper_leg": {"x": (-70, 60), "y": (-GIVE, GIVE), "z": (-SIDEWAYS, SIDEWAYS)},
    "front_lower_leg": {"x": (-110, 60), "y": (-GIVE, GIVE), "z": (-GIVE, GIVE)},
    "hind_upper_leg": {"x": (-80, 55), "y": (-GIVE, GIVE), "z": (-SIDEWAYS, SIDEWAYS)},
    "hind_lower_leg": {"x": (-40, 110), "y": (-GIVE, GIVE), "z": (-GIVE, GIVE)},
}
"""Estimates: angles from legs that stand straight down; a tail goes anywhere. The lower part of a
front leg has elbow and wrist in one, which bend opposite ways, that of a hind leg knee and hock."""


@dataclass(frozen=True)
class Quadruped:
    """The estimated sizes of an animal, metres: its nose toward the camera, its trunk level.

    trunk, head: low and high corners of boxes.  neck, tail: where they are joined, and their shape.
    legs: front and hind, where they are joined on the left, lengths of upper and lower part, radii
    at the top, the middle and the end.  end: what a leg ends in.
    """

    name: str
    end: str
    source: str
    trunk: tuple[Point, Point]
    head: tuple[Point, Point]
    head_at: Point
    neck: tuple[Point, Frustum]
    tail: tuple[Point, Frustum]
    legs: tuple[tuple[str, Point, float, float, Radii, Radii, Radii], ...]


_KNEE = (0.030, 0.035)
_PAW = (0.022, 0.025)
DOG = Quadruped(
    name="dog",
    end="paw",
    source="Estimated, not measured: a dog of about 0.65 m at the withers, its nose toward the "
    "camera.",
    trunk=((-0.1, -0.11, -0.3), (0.1, 0.13, 0.3)),
    head=((-0.055, -0.08, -0.2), (0.055, 0.05, 0.07)),
    head_at=(0.0, -0.2, 0.0),
    neck=((0.0, -0.05, -0.25), Frustum(start_m=0.03, end_m=-0.22, start_radii_m=(0.075, 0.09),
                                       end_radii_m=(0.055, 0.065))),
    tail=((0.0, -0.08, 0.29), Frustum(start_m=-0.01, end_m=0.33, start_radii_m=(0.025, 0.025),
                                      end_radii_m=(0.012, 0.012))),
    legs=(
        ("front", (0.075, 0.05, -0.21), 0.25, 0.25, (0.045, 0.0585), _KNEE, _PAW),
        ("hind", (0.075, 0.05, 0.22), 0.26, 0.24, (0.055, 0.0715), _KNEE, _PAW),
    ),
)  # fmt: skip
HORSE = Quadruped(
    name="horse",
    end="hoof",
    source="Estimated, not measured: a horse of about 1.6 m at the withers, its nose toward the "
    "camera.",
    trunk=((-0.28, -0.3, -0.75), (0.28, 0.3, 0.75)),
    head=((-0.12, -0.16, -0.5), (0.12, 0.12, 0.12)),
    head_at=(0.0, -0.68, -0.08),
    neck=((0.0, -0.15, -0.68), Frustum(start_m=0.1, end_m=-0.72, start_radii_m=(0.16, 0.28),
                                       end_radii_m=(0.10, 0.15))),
    tail=((0.0, -0.2, 0.74), Frustum(start_m=-0.02, end_m=0.75, start_radii_m=(0.05, 0.05),
                                     end_radii_m=(0.06, 0.06))),
    legs=(
        ("front", (0.17, 0.1, -0.52), 0.55, 0.67, (0.11, 0.15), (0.065, 0.07), (0.055, 0.065)),
        ("hind", (0.17, 0.05, 0.55), 0.62, 0.65, (0.14, 0.20), (0.07, 0.08), (0.055, 0.065)),
    ),
)  # fmt: skip


def make_animal(animal: Quadruped) -> Body:
    """The body of an animal, left and right alike."""
    parts = [*_trunk(animal), *_legs(animal, "left", 1), *_legs(animal, "right", -1)]
    limbs = [f"{leg}_{half}_leg" for leg, *_ in animal.legs for half in ("upper", "lower")]
    pairs = tuple((f"left_{limb}", f"right_{limb}") for limb in limbs)
    parts = [part.model_copy(update={"limits_deg": _limits(part.name)}) for part in parts]
    return Body(name=animal.name, parts=tuple(parts), mirror_pairs=pairs, source=animal.source)


def _trunk(animal: Quadruped) -> list[Part]:
    (low, high), (head_low, head_high) = animal.trunk, animal.head
    (neck_at, neck), (tail_at, tail) = animal.neck, animal.tail
    return [
        Part(name="trunk", shape=Box(low_m=low, high_m=high), tracked=ALL_DOFS),
        Part(name="neck", parent="trunk", joint_m=neck_at, shape=neck, tracked=("rx", "ry", "rz")),
        Part(
            name="head",
            parent="neck",
            joint_m=animal.head_at,
            shape=Box(low_m=head_low, high_m=head_high),
            tracked=("rx", "ry"),
            landmarks={"nose": (0.0, 0.0, head_low[2])},
        ),
        Part(
            name="tail",
            parent="trunk",
            joint_m=tail_at,
            shape=tail,
            tracked=("rx", "rz"),
            landmarks={"tail_tip": (0.0, tail.end_m, 0.0)},
        ),
    ]


def _limits(name: str) -> Limits:
    """Of both sides alike."""
    return RANGES.get(name.removeprefix("left_").removeprefix("right_"), {})


def _legs(animal: Quadruped, side: str, out: int) -> list[Part]:
    parts = []
    for leg, (x, y, z), upper, lower, top, knee, end in animal.legs:
        name = f"{side}_{leg}"
        thigh = Frustum(start_m=-0.02, end_m=upper, start_radii_m=top, end_radii_m=knee)
        shin = Frustum(start_m=-0.01, end_m=lower, start_radii_m=knee, end_radii_m=end)
        parts += [
            Part(
                name=f"{name}_upper_leg",
                parent="trunk",
                joint_m=(out * x, y, z),
                shape=thigh,
                tracked=("rx", "rz"),
            ),
            Part(
                name=f"{name}_lower_leg",
                parent=f"{name}_upper_leg",
                joint_m=(0.0, upper, 0.0),
                shape=shin,
                tracked=("rx",),
                landmarks={f"{name}_{animal.end}": (0.0, lower, 0.0)},
            ),
        ]
    return parts
