"""The motion as TRC, the table of markers that OpenSim and motion capture programs read.

Markers and axes are those of the recording's markers (`keypose.tracker.formats.marker_sets`):
joints and landmarks, x right, y up, z toward the camera, which is the origin; those of halpe26 on
the ground. Millimetres, as `Units` says. Columns are parted by tabs. Frames that are not tracked
have no positions, and a tab ends every row, without which OpenSim would miss a last marker left
empty. `Time` counts in seconds from the video's first frame and `Frame#` from 0; the rates in the
header are the mean where times are uneven.
"""

from __future__ import annotations

from collections.abc import Iterable

from keypose.tracker.formats.decimals import fixed_decimals
from keypose.tracker.formats.marker_sets import marked
from keypose.tracker.formats.names import single_words
from keypose.tracker.formats.recording import Recording

MM_PER_M = 1000.0
DECIMALS = 4
"""A tenth of a micrometre."""

_HEADER = (
    *("DataRate", "CameraRate", "NumFrames", "NumMarkers"),
    *("Units", "OrigDataRate", "OrigDataStartFrame", "OrigNumFrames"),
)


def trc(recording: Recording, file_name: str) -> str:
    """The text of the file, which says its own name. FormatError without two times."""
    labels, places = marked(recording)
    names = single_words(labels)
    rate, count = f"{recording.frames_per_second:.6f}", str(len(recording))
    first = str(recording.frames[0])
    axes = (f"{axis}{i + 1}" for i in range(len(names)) for axis in "XYZ")
    lines = [
        "\t".join(("PathFileType", "4", "(X/Y/Z)", file_name)),
        "\t".join(_HEADER),
        "\t".join((rate, rate, count, str(len(names)), "mm", rate, first, count)),
        _row(("Frame#", "Time", *(cell for name in names for cell in (name, "", "")))),
        _row(("", "", *axes)),
        "",
    ]
    ps = places * MM_PER_M
    for frame, time_s, positions in zip(recording.frames, recording.times_s, ps, strict=True):
        lines.append(
            _row((str(frame), f"{time_s:.6f}", *fixed_decimals(positions.ravel(), DECIMALS)))
        )
    return "\n".join(lines) + "\n"


def _row(cells: Iterable[str]) -> str:
    return "".join(f"{cell}\t" for cell in cells)
