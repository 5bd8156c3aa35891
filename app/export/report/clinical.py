"""A person's joint angles by their clinical names: a row for every joint, a column for every plane,
left and right in one chart."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from keypose.app.export.report.charts import framed
from keypose.app.export.report.markup import Html, element
from keypose.app.export.report.plots import Scale, curve, dots, drawing, path, uprights
from keypose.app.export.report.subject import Subject
from keypose.app.posing import part_label
from keypose.app.posing.labels import number_text
from keypose.tracker.body.joint_angles import Angle, Joint, JointAngles
from keypose.tracker.formats.recording import Recording
from keypose.tracker.geometry.rotations import Array

LEAST_MOTION_DEG = 1.0
"""A joint none of whose angles changes more gets no row."""
LEAST_HEIGHT_DEG = 12.0
"""What a chart spans at least, so that a joint that hardly moves looks like one."""

CONVENTIONS = (
    "Both sides have the same signs; what is negative stands beside each title. 0 is standing "
    "upright with the arms hanging, thumbs forward. The order is that of Grood and Suntay, which "
    "the ISB recommends for hip, knee and ankle: flexion about the sideways axis of the part that "
    "carries the joint, rotation about the length of the part that moves, adduction about the axis "
    "across both. Shoulders have the same order, not the ISB's Y-X-Y; for an arm that points "
    "straight sideways, flexion and rotation cannot be distinguished. The pelvis is "
    "measured against the ground, the trunk in the pelvis, the neck in the trunk."
)


@dataclass(frozen=True, eq=False)
class Row:
    """One joint of the body, on its sides: by left, right or middle its angles."""

    name: str
    sides: Mapping[str, JointAngles]

    @property
    def joint(self) -> Joint:
        return next(iter(self.sides.values())).joint

    def moves(self) -> bool:
        """Whether any of its angles changes."""
        return any(
            np.nanmax(np.ptp(_known(one.angles_deg), axis=0), initial=0.0) > LEAST_MOTION_DEG
            for one in self.sides.values()
        )


def legend() -> Html:
    """Which colour is which side."""
    sides = (element("span", part_label(side), class_=f"name {side}") for side in ("left", "right"))
    return element("p", *sides, element("span", "dots are the keyframes"), class_="legend")


def clinical_charts(subject: Subject, recording: Recording) -> list[Html]:
    """Three charts for every joint that moves; none where the body is no person's."""
    rows = [row for row in rows_of(recording.joint_angles) if row.moves()]
    return [chart for row in rows for chart in _charts(subject, recording, row)]


def rows_of(found: Sequence[JointAngles]) -> list[Row]:
    """The joints, left and right together."""
    rows: dict[str, dict[str, JointAngles]] = {}
    for one in found:
        side, _, rest = one.joint.name.partition("_")
        name, side = (rest, side) if rest else (side, "middle")
        rows.setdefault(name, {})[side] = one
    return [Row(name, sides) for name, sides in rows.items()]


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


def chart_range(values: Sequence[Array]) -> tuple[float, float]:
    """Lowest and highest value with 0 between them, not too near to each other."""
    low = min(0.0, *(float(np.nanmin(one)) for one in values))
    high = max(0.0, *(float(np.nanmax(one)) for one in values))
    short = max(0.0, LEAST_HEIGHT_DEG - (high - low)) / 2
    return low - short, high + short


def caption(joint: str, angle: Angle) -> Html:
    """The joint and what is positive; what is negative beside it."""
    positive, negative = angle_words(angle)
    return element(
        "figcaption",
        element("b", f"{part_label(joint)} {positive}"),
        element("span", f"− {negative}", class_="quiet"),
    )


def _charts(subject: Subject, recording: Recording, row: Row) -> Iterator[Html]:
    first = recording.frames[0]
    for k, angle in enumerate(row.joint.angles):
        curves = {side: one.angles_deg[:, k] for side, one in row.sides.items()}
        yield _chart(subject, row.name, angle, curves, first)


def _chart(
    subject: Subject, joint: str, angle: Angle, curves: Mapping[str, Array], first: int
) -> Html:
    low, high = chart_range(list(curves.values()))
    room = 0.06 * (high - low)
    (start, end), keys = subject.ends, subject.keys
    scale = Scale(start, end, low - room, high + room)
    lines = [path(curve(values, first, scale), f"curve {side}") for side, values in curves.items()]
    marks = [
        path(dots(_at(values, first, keys, scale)), f"dots {side}")
        for side, values in curves.items()
    ]
    words = f"{part_label(joint)} {' and '.join(angle_words(angle))}, {', '.join(curves)}"
    drawn = drawing(
        path(f"M0 {scale.y(0.0):.1f}H1000", "zero"), path(uprights(keys, scale), "keys"),
        *lines, *marks, words=words,
    )  # fmt: skip
    return framed(
        caption(joint, angle),
        drawn,
        (f"{number_text(high, 0)}°", f"{number_text(low, 0)}°"),
        (str(start), str(end)),
    )


def _at(
    values: Array, first: int, keys: Sequence[int], scale: Scale
) -> Iterator[tuple[float, float]]:
    for key in keys:
        if 0 <= key - first < len(values) and np.isfinite(values[key - first]):
            yield scale.x(key), scale.y(float(values[key - first]))


def _known(angles: Array) -> Array:
    return angles[np.isfinite(angles).all(axis=1)]
