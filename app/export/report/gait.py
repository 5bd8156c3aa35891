"""Steps of a person who walks: when feet touch the ground, strides as a table, and the legs' angles
over the gait cycle."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from keypose.app.export.report.charts import framed, timeline
from keypose.app.export.report.clinical import caption, chart_range
from keypose.app.export.report.figures import figure
from keypose.app.export.report.markup import Child, Html, element, joined
from keypose.app.export.report.plots import Scale, curve, drawing, path, uprights
from keypose.app.export.report.subject import Subject
from keypose.app.export.report.tables import table, tile
from keypose.app.posing import part_label
from keypose.app.posing.labels import number_text
from keypose.tracker.body.joint_angles import Angle
from keypose.tracker.formats.recording import Recording
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.tracking.space.gait import Gait, Stride

CYCLE = np.linspace(0.0, 100.0, 101)
CYCLE_JOINTS = ("hip", "knee", "ankle")
CYCLE_WORDS = (
    "From heel strike to heel strike: every stride, thick their mean, dashed where toes leave."
)

_COLUMNS: tuple[tuple[str, Callable[[Stride], float | None], int], ...] = (
    ("Time, s", lambda one: one.time_s, 2),
    ("Length, m", lambda one: one.length_m, 2),
    ("Step length, m", lambda one: one.step_length_m, 2),
    ("Step width, m", lambda one: one.step_width_m, 2),
    ("Speed, m/s", lambda one: one.speed_m_s, 2),
    ("Cadence, steps/min", lambda one: one.cadence, 0),
    ("Stance, %", lambda one: None if one.stance_share is None else 100 * one.stance_share, 0),
)

_LARGE: tuple[tuple[Callable[[Stride], float | None], int, str, str], ...] = (
    (lambda one: one.speed_m_s, 2, "m/s", "speed"),
    (lambda one: one.cadence, 0, "/min", "steps"),
    (lambda one: one.length_m, 2, "m", "stride length"),
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
        known = [value for one in strides if (value := value_of(one)) is not None]
        if known:
            tiles.append(tile(f"{number_text(float(np.mean(known)), digits)} {unit}", words))
    return element("div", *tiles, class_="tiles")


def strides_table(gait: Gait) -> Html:
    """Every stride, and below the mean and standard deviation of each foot."""
    head = ("Foot", "Heel strikes", "Toe off", *(name for name, _, _ in _COLUMNS))
    offs = {(s.part, s.heel_strike): s.toe_off for s in gait.stances}
    rows = [_row(one, offs.get((one.part, one.first_frame))) for one in gait.strides]
    feet = list(dict.fromkeys(one.part for one in gait.strides))
    rows += [_mean_row([one for one in gait.strides if one.part == foot]) for foot in sorted(feet)]
    return table(head, rows, tuple(range(1, len(head))))


def _row(one: Stride, toe_off: int | None) -> list[Child]:
    frames = f"{one.first_frame} → {one.last_frame}"
    numbers = [frames, "–" if toe_off is None else str(toe_off)]
    for _, value_of, digits in _COLUMNS:
        value = value_of(one)
        numbers.append(figure(np.nan if value is None else value, digits))
    return [_foot(one.part), *(element("td", words, class_="num") for words in numbers)]


def _mean_row(strides: Sequence[Stride]) -> list[Child]:
    cells: list[Child] = [_foot(strides[0].part, f", mean of {len(strides)}")]
    cells += [element("td", class_="num"), element("td", class_="num")]
    for _, value_of, digits in _COLUMNS:
        known = [value for one in strides if (value := value_of(one)) is not None]
        words = figure(float(np.mean(known)) if known else np.nan, digits)
        if len(known) > 1:
            words += f" ± {number_text(float(np.std(known, ddof=1)), digits)}"
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
    angles = {one.joint.name: one for one in recording.joint_angles}
    for name in CYCLE_JOINTS:
        if f"left_{name}" not in angles:
            continue
        angle = angles[f"left_{name}"].joint.angles[0]
        cycles = {
            side: [
                one
                for stride in gait.strides
                if stride.part == f"{side}_foot"
                and (one := _cycle(recording, angles[f"{side}_{name}"].angles_deg[:, 0], stride))
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
    low, high = chart_range([one for side in cycles.values() for one in side])
    room = 0.06 * (high - low)
    scale = Scale(0, 100, low - room, high + room)
    lines: list[Child] = [path(f"M0 {scale.y(0.0):.1f}H1000", "zero")]
    for side, strides in cycles.items():
        shares = [s.stance_share for s in gait.strides if s.part == f"{side}_foot"]
        known = [share for share in shares if share is not None]
        if known:
            lines.append(path(uprights([100 * float(np.mean(known))], scale), f"off {side}"))
        lines += [path(curve(one, 0, scale), f"curve thin {side}") for one in strides]
        if strides:
            lines.append(path(curve(np.mean(strides, axis=0), 0, scale), f"curve {side}"))
    drawn = drawing(*lines, words=f"{part_label(name)} over the gait cycle, left and right")
    ends = (f"{number_text(high, 0)}°", f"{number_text(low, 0)}°")
    return framed(caption(name, angle), drawn, ends, ("0", "50", "100 %"))
