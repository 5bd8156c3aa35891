"""How fast the body's ends move and how they accelerate, low-pass filtered as is usual.

Differences of tracked positions magnify what shakes from frame to frame: without a filter,
accelerations say more of that than of the motion. Only these figures are filtered, no pose.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from keypose.app.export.report.charts import single_chart
from keypose.app.export.report.markup import Child, Html, element
from keypose.app.export.report.subject import Subject, recording_of
from keypose.app.export.report.tables import figure, table
from keypose.app.posing import part_label
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.recording import Recording
from keypose.tracker.formats.sampling import low_passed
from keypose.tracker.geometry.rotations import Array

FILTER_HZ = 6.0
MOST_PARTS = 12


@dataclass(frozen=True, eq=False)
class Derivatives:
    """Of the joint of a part: metres a second and metres a second², NaN where not known.

    first: the frame of the video that the first value belongs to; there is one for each frame.
    """

    part: str
    first: int
    speed: Array
    acceleration: Array


def derivatives_section(subject: Subject) -> Child:
    """Peak speeds and accelerations as a table, speeds over time; why there are none."""
    if not any(track.finished for track in subject.fitting.values()):
        return None
    title = element("h2", "Speed and acceleration")
    try:
        ends = derivatives(subject)
    except FormatError as error:
        return element("section", title, element("p", str(error), class_="quiet"))
    words = (
        f"Of joints in space, low-pass filtered at {FILTER_HZ:g} Hz (Butterworth, fourth order, "
        "without delay, 3 dB down there); the poses themselves are not filtered. Along the view "
        "they are the least certain."
    )
    charts = element("div", *_charts(subject, ends), class_="cols")
    return element("section", title, element("p", words, class_="quiet"), _figures(ends), charts)


def derivatives(subject: Subject) -> list[Derivatives]:
    """Differentiate the root and every end of a limb. FormatError where the film has too few
    frames.
    """
    recorded = recording_of(subject)
    if recorded is None:
        return []
    recording = low_passed(recorded.evened, FILTER_HZ)
    ps, dt = recording.ps_camera_joint, 1 / recording.frames_per_second
    velocity, acceleration = np.full(ps.shape, np.nan), np.full(ps.shape, np.nan)
    velocity[1:-1] = (ps[2:] - ps[:-2]) / (2 * dt)
    acceleration[1:-1] = (ps[2:] - 2 * ps[1:-1] + ps[:-2]) / dt**2
    film = recording.film_frames
    frames = np.arange(np.ceil(film[0]), np.floor(film[-1]) + 1)
    names = recording.skeleton.body.names
    return [
        Derivatives(
            names[i],
            int(frames[0]),
            np.interp(frames, film, np.linalg.norm(velocity[:, i], axis=-1)),
            np.interp(frames, film, np.linalg.norm(acceleration[:, i], axis=-1)),
        )
        for i in _ends(recording)
    ]


def _ends(recording: Recording) -> list[int]:
    """The root, and the parts that carry no other."""
    parents = set(recording.skeleton.parents.tolist())
    ends = [i for i in range(recording.skeleton.part_count) if i not in parents]
    return [0, *(i for i in ends if i)][:MOST_PARTS]


def _figures(ends: list[Derivatives]) -> Html:
    head = ("Joint", "Peak speed, m/s", "Peak acceleration, m/s²", "RMS acceleration, m/s²")
    rows = [_row(end) for end in ends]
    return element("div", table(head, rows, (1, 2, 3)), class_="scroll")


def _row(end: Derivatives) -> list[Child]:
    known_acceleration = end.acceleration[np.isfinite(end.acceleration)]
    rms = (
        float(np.sqrt(np.square(known_acceleration).mean())) if len(known_acceleration) else np.nan
    )
    numbers = (figure(_peak(end.speed), 2), figure(_peak(known_acceleration), 1), figure(rms, 1))
    return [
        element("th", part_label(end.part), scope="row"),
        *(element("td", number, class_="num") for number in numbers),
    ]


def _peak(values: Array) -> float:
    finite = values[np.isfinite(values)]
    return float(finite.max()) if len(finite) else np.nan


def _charts(subject: Subject, ends: list[Derivatives]) -> Iterator[Html]:
    for end in ends:
        if np.isfinite(end.speed).any():
            yield single_chart(subject, f"{part_label(end.part)}, m/s", end.speed, end.first)
