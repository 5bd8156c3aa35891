"""The key poses of a right-handed throw toward the picture's left."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class KeyPose:
    """Angles (x, y, z), radians, of the parts that leave their rest; place is the root's (x, z)."""

    frame: int
    place: tuple[float, float]
    angles: dict[str, tuple[float, float, float]]


def _pose(
    frame: int,
    place: tuple[float, float],
    waist: tuple[float, float, float],
    chest: tuple[float, float, float],
    head: tuple[float, float, float],
    right_arm: tuple[float, float, float],
    left_arm: tuple[float, float, float],
    right_leg: tuple[float, float, float],
    left_leg: tuple[float, float, float],
) -> KeyPose:
    """Limbs are written (upper x, upper z, lower x): shoulder and elbow, hip and knee."""
    angles = {"waist": waist, "chest": chest, "head": head}
    for names, (swing, side, bend) in (
        (("right_upper_arm", "right_forearm"), right_arm),
        (("left_upper_arm", "left_forearm"), left_arm),
        (("right_thigh", "right_shin"), right_leg),
        (("left_thigh", "left_shin"), left_leg),
    ):
        angles[names[0]] = (swing, 0.0, side)
        angles[names[1]] = (bend, 0.0, 0.0)
    return KeyPose(frame, place, angles)


THROW = (
    _pose(
        *(0, (0.42, 5.25), (0.02, 0.15, 0.0), (0.0, 0.05, 0.0), (0.0, 0.2, 0.0)),
        *((-0.45, 0.10, -1.25), (-0.45, -0.10, -1.25), (-0.02, 0.06, 0.06), (0.02, -0.06, 0.06)),
    ),
    _pose(
        *(22, (0.42, 5.25), (0.02, 0.20, 0.0), (-0.02, 0.05, 0.0), (0.0, 0.2, 0.0)),
        *((-1.10, 0.18, -1.60), (-1.10, -0.18, -1.60), (-0.02, 0.06, 0.06), (0.02, -0.06, 0.06)),
    ),
    _pose(
        *(44, (0.40, 5.25), (0.0, -0.25, 0.0), (-0.04, -0.20, 0.0), (0.05, 0.55, 0.0)),
        *((-0.70, 0.25, -1.50), (-0.75, -0.25, -1.35), (-0.02, 0.06, 0.08), (-1.25, -0.08, 1.40)),
    ),
    _pose(
        *(58, (0.26, 5.23), (0.0, -0.15, 0.03), (0.0, -0.35, 0.05), (0.05, 0.60, 0.0)),
        *((0.25, 0.85, -0.70), (-0.60, -0.75, -0.45), (0.10, 0.22, 0.30), (-0.85, -0.28, 0.75)),
    ),
    _pose(
        *(68, (0.05, 5.20), (0.02, 0.15, 0.05), (-0.04, -0.30, 0.05), (0.05, 0.50, 0.0)),
        *((0.25, 1.45, -1.45), (-0.75, -0.95, -0.25), (0.32, 0.26, 0.40), (-0.70, -0.30, 0.35)),
    ),
    _pose(
        *(75, (-0.08, 5.17), (0.06, 0.75, 0.06), (0.05, 0.10, 0.05), (0.02, 0.10, 0.0)),
        *((-0.45, 1.85, -1.65), (-0.50, -0.60, -0.95), (0.42, 0.22, 0.55), (-0.72, -0.22, 0.42)),
    ),
    _pose(
        *(80, (-0.15, 5.15), (0.14, 1.10, 0.06), (0.18, 0.40, 0.05), (-0.05, -0.25, 0.0)),
        *((-1.65, 1.25, -0.65), (-0.20, -0.40, -1.35), (0.45, 0.16, 0.75), (-0.78, -0.15, 0.52)),
    ),
    _pose(
        *(87, (-0.21, 5.13), (0.24, 1.35, 0.05), (0.36, 0.50, 0.0), (-0.15, -0.40, 0.0)),
        *((-1.05, 0.40, -0.40), (0.15, -0.35, -1.40), (0.30, 0.10, 0.95), (-0.80, -0.10, 0.60)),
    ),
    _pose(
        *(102, (-0.27, 5.12), (0.18, 1.30, 0.02), (0.26, 0.40, 0.0), (-0.15, -0.30, 0.0)),
        *((-0.55, 0.20, -0.55), (0.05, -0.25, -1.10), (-0.05, 0.06, 0.55), (-0.50, -0.08, 0.48)),
    ),
    _pose(
        *(119, (-0.30, 5.12), (0.05, 1.15, 0.0), (0.10, 0.15, 0.0), (-0.05, -0.15, 0.0)),
        *((-0.25, 0.14, -0.55), (-0.15, -0.18, -0.75), (-0.08, 0.05, 0.18), (-0.18, -0.06, 0.22)),
    ),
)
