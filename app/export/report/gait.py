"""Report gait and a person's joint angles by their clinical names."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from keypose.app.export.report.charts import Line, line_chart, timeline
from keypose.app.export.report.markup import Child, Html, element, joined
from keypose.app.export.report.plots import Scale
from keypose.app.export.report.subject import Subject
from keypose.app.export.report.tables import figure, table, tile
from keypose.app.posing import part_label
from keypose.app.posing.labels import number_text
from keypose.app.words.angles import angle_words
from keypose.tracker.body.angle_errors import GUESSED_RAD
from keypose.tracker.body.joint_angles import Angle, Joint, JointAngles
from keypose.tracker.formats.recording import Recording
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.space.gait import Gait, Stride

GUESS_DEG = float(np.degrees(GUESSED_RAD))
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
            np.nanmax(np.ptp(_known(joint_angles.angles_deg), axis=0), initial=0.0)
            > LEAST_MOTION_DEG
            for joint_angles in self.sides.values()
        )


def legend(recording: Recording) -> Html:
    """Which colour is which side, and what is drawn beside curves."""
    sides = (element("span", part_label(side), class_=f"name {side}") for side in ("left", "right"))
    has_errors = any(joint_angles.errors_deg is not None for joint_angles in recording.joint_angles)
    more = "; bands: half of all angles are off by less; grey: not seen, or a guess in depth"
    words = f"dots are the keyframes{more if has_errors else ''}"
    return element("p", *sides, element("span", words), class_="legend")


def clinical_charts(subject: Subject, recording: Recording) -> list[Html]:
    """Three charts for every joint that moves; none where the body is no person's."""
    rows = [row for row in rows_of(recording.joint_angles) if row.moves()]
    return [chart for row in rows for chart in _charts(subject, recording, row)]


def rows_of(measured: Sequence[JointAngles]) -> list[Row]:
    """The joints, left and right together."""
    rows: dict[str, dict[str, JointAngles]] = {}
    for joint_angles in measured:
        side, _, rest = joint_angles.joint.name.partition("_")
        name, side = (rest, side) if rest else (side, "middle")
        rows.setdefault(name, {})[side] = joint_angles
    return [Row(name, sides) for name, sides in rows.items()]


def chart_range(values: Sequence[Array]) -> tuple[float, float]:
    """Lowest and highest value with 0 between them, not too near to each other."""
    low = min(0.0, *(float(np.nanmin(series)) for series in values))
    high = max(0.0, *(float(np.nanmax(series)) for series in values))
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
        lines = []
        for side, joint_angles in row.sides.items():
            errors = None if joint_angles.errors_deg is None else joint_angles.errors_deg[:, k]
            values = joint_angles.angles_deg[:, k]
            lines.append(Line(values, side, first, subject.keys, errors, GUESS_DEG))
        yield _chart(subject, row.name, angle, lines)


def _chart(subject: Subject, joint: str, angle: Angle, lines: Sequence[Line]) -> Html:
    low, high = chart_range([each for line in lines for each in line.around])
    return line_chart(
        caption(joint, angle),
        _with_room(*subject.ends, low, high),
        lines,
        words=f"{part_label(joint)} {' and '.join(angle_words(angle))}, "
        f"{', '.join(line.style for line in lines)}",
        high=f"{number_text(high, 0)}°",
        low=f"{number_text(low, 0)}°",
        uprights_at={"keys": subject.keys},
        has_zero=True,
    )


def _with_room(first: float, last: float, low: float, high: float) -> Scale:
    room = 0.06 * (high - low)
    return Scale(first, last, low - room, high + room)


def _known(angles: Array) -> Array:
    return angles[np.isfinite(angles).all(axis=1)]


CYCLE = np.linspace(0.0, 100.0, 101)
CYCLE_JOINTS = ("hip", "knee", "ankle")
CYCLE_WORDS = (
    "From heel strike to heel strike: every stride, thick their mean, dashed where toes leave."
)

_COLUMNS: tuple[tuple[str, Callable[[Stride], float | None], int], ...] = (
    ("Time, s", lambda stride: stride.time_s, 2),
    ("Length, m", lambda stride: stride.length_m, 2),
    ("Step length, m", lambda stride: stride.step_length_m, 2),
    ("Step width, m", lambda stride: stride.step_width_m, 2),
    ("Speed, m/s", lambda stride: stride.speed_m_s, 2),
    ("Cadence, steps/min", lambda stride: stride.cadence, 0),
    (
        "Stance, %",
        lambda stride: None if stride.stance_share is None else 100 * stride.stance_share,
        0,
    ),
)

_LARGE: tuple[tuple[Callable[[Stride], float | None], int, str, str], ...] = (
    (lambda stride: stride.speed_m_s, 2, "m/s", "speed"),
    (lambda stride: stride.cadence, 0, "/min", "steps"),
    (lambda stride: stride.length_m, 2, "m", "stride length"),
    (_COLUMNS[-1][1], 0, "%", "stance"),
)


def gait_section(subject: Subject, recording: Recording) -> Html | None:
    """None where no foot makes a stride."""
    gait = recording.gait
    if not gait.strides:
        return None
    how = "as pinned" if recording.foot_pins else "as they were found standing"
    words = (
        f"Feet stand still {how}; the thin bars reach from heel strike to toe off. A heel strikes "
        "where it is farthest ahead of the pelvis, toes leave where they are farthest behind it "
        "(Zeni et al. 2008), to within a frame. A stride goes from a heel strike of a foot to its "
        "next; step length and width are from where the other foot stood in between. Lengths are "
        "as good as the body's size, and the least certain along the view."
    )
    return element(
        "section",
        element("h2", "Gait"),
        element("p", words, class_="quiet"),
        _tiles(gait.strides),
        _diagram(subject, gait),
        element("div", strides_table(gait), class_="scroll gait"),
        element("p", CYCLE_WORDS, class_="quiet"),
        element("div", *_cycles(recording, gait), class_="cols clinical"),
    )


def _tiles(strides: Sequence[Stride]) -> Html:
    """The mean over both feet in large figures."""
    tiles = [tile(str(len(strides)), "stride" if len(strides) == 1 else "strides")]
    for value_of, digits, unit, words in _LARGE:
        known_values = [value for stride in strides if (value := value_of(stride)) is not None]
        if known_values:
            tiles.append(tile(f"{number_text(float(np.mean(known_values)), digits)} {unit}", words))
    return element("div", *tiles, class_="tiles")


def strides_table(gait: Gait) -> Html:
    """Every stride, and below the mean and standard deviation of each foot."""
    head = ("Foot", "Heel strikes", "Toe off", *(name for name, _, _ in _COLUMNS))
    offs = {(s.part, s.heel_strike): s.toe_off for s in gait.stances}
    rows = [_row(each, offs.get((each.part, each.first_frame))) for each in gait.strides]
    feet = list(dict.fromkeys(stride.part for stride in gait.strides))
    rows += [
        _mean_row([each for each in gait.strides if each.part == foot]) for foot in sorted(feet)
    ]
    return table(head, rows, tuple(range(1, len(head))))


def _row(stride: Stride, toe_off: int | None) -> list[Child]:
    frames = f"{stride.first_frame} → {stride.last_frame}"
    numbers = [frames, "–" if toe_off is None else str(toe_off)]
    for _, value_of, digits in _COLUMNS:
        value = value_of(stride)
        numbers.append(figure(np.nan if value is None else value, digits))
    return [_foot(stride.part), *(element("td", words, class_="num") for words in numbers)]


def _mean_row(strides: Sequence[Stride]) -> list[Child]:
    cells: list[Child] = [_foot(strides[0].part, f", mean of {len(strides)}")]
    cells += [element("td", class_="num"), element("td", class_="num")]
    for _, value_of, digits in _COLUMNS:
        known_values = [value for stride in strides if (value := value_of(stride)) is not None]
        words = figure(float(np.mean(known_values)) if known_values else np.nan, digits)
        if len(known_values) > 1:
            words += f" ± {number_text(float(np.std(known_values, ddof=1)), digits)}"
        cells.append(element("td", words, class_="num mean"))
    return cells


def _foot(part: str, more: str = "") -> Html:
    side = part.partition("_")[0]
    name = element("span", part_label(side), class_=f"name {side}")
    return element("th", name, more, scope="row")


def _diagram(subject: Subject, gait: Gait) -> Html:
    """When each foot is on the ground: all of it still, and from heel strike to toe off."""
    scale = Scale(*subject.ends)
    rows = []
    for part in sorted({stance.part for stance in gait.stances}):
        side = part.partition("_")[0]
        bars = []
        for stance in (s for s in gait.stances if s.part == part):
            first = stance.still[0] if stance.heel_strike is None else stance.heel_strike
            last = stance.still[1] if stance.toe_off is None else stance.toe_off
            tip = (
                "" if stance.heel_strike is None else f"heel strike {first}, ",
                f"still {stance.still[0]}–{stance.still[1]}",
                "" if stance.toe_off is None else f", toe off {last}",
            )
            bars.append(_bar(scale, first, last, f"stance {side}", "".join(tip)))
            bars.append(_bar(scale, *stance.still, f"stance still {side}", "".join(tip)))
        rows.append((f"{part_label(side)} foot", joined(bars)))
    return timeline(rows, scale)


def _bar(scale: Scale, first: int, last: int, class_: str, title: str) -> Html:
    left, right = scale.percent(first), scale.percent(last)
    place = f"left:{left:.2f}%;width:{right - left:.2f}%"
    return element("i", class_=class_, style=place, title=title)


def _cycles(recording: Recording, gait: Gait) -> Iterator[Html]:
    """Flexion of hip, knee and ankle over the strides, every one and their mean."""
    angles = {joint_angles.joint.name: joint_angles for joint_angles in recording.joint_angles}
    for name in CYCLE_JOINTS:
        if f"left_{name}" not in angles:
            continue
        angle = angles[f"left_{name}"].joint.angles[0]
        cycles = {
            side: [
                cycle
                for stride in gait.strides
                if stride.part == f"{side}_foot"
                and (cycle := _cycle(recording, angles[f"{side}_{name}"].angles_deg[:, 0], stride))
                is not None
            ]
            for side in ("left", "right")
        }
        if any(cycles.values()):
            yield _cycle_chart(name, angle, cycles, gait)


def _cycle(recording: Recording, values: Array, stride: Stride) -> Array | None:
    """(101,) an angle over one stride, None where not all of it is known."""
    first = recording.frames[0]
    rows = slice(stride.first_frame - first, stride.last_frame - first + 1)
    times_s, own = recording.times_s[rows], values[rows]
    if not np.isfinite(own).all():
        return None
    share = 100 * (times_s - times_s[0]) / (times_s[-1] - times_s[0])
    return np.interp(CYCLE, share, own)


def _cycle_chart(name: str, angle: Angle, cycles: dict[str, list[Array]], gait: Gait) -> Html:
    low, high = chart_range([cycle for side in cycles.values() for cycle in side])
    lines: list[Line] = []
    toes_leave: dict[str, Sequence[float]] = {}
    for side, strides in cycles.items():
        shares = [s.stance_share for s in gait.strides if s.part == f"{side}_foot"]
        known_shares = [share for share in shares if share is not None]
        if known_shares:
            toes_leave[f"off {side}"] = [100 * float(np.mean(known_shares))]
        lines += [Line(cycle, f"thin {side}") for cycle in strides]
        if strides:
            lines.append(Line(np.mean(strides, axis=0), side))
    return line_chart(
        caption(name, angle),
        _with_room(0, 100, low, high),
        lines,
        words=f"{part_label(name)} over the gait cycle, left and right",
        high=f"{number_text(high, 0)}°",
        low=f"{number_text(low, 0)}°",
        uprights_at=toes_leave,
        ticks=("0", "50", "100 %"),
        has_zero=True,
    )
