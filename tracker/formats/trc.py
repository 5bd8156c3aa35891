"""The motion as TRC, the table of markers that OpenSim and motion capture programs read.

Markers are those of the recording (`keypose.tracker.formats.marker_sets`), on the ground as in MOT
and C3D: x ahead, y up, z right. `Units` are those of the program whose markers they are. Columns
are parted by tabs, and no tab ends a row: readers take it for one more column. Frames that are not
tracked have `nan`, as OpenSim writes it, which refuses a row that ends with empty places. `Time`
counts in seconds from the video's first frame and `Frame#` from 0; the rates in the header are the
mean where times are uneven.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from keypose.tracker.formats.conventions import fixed_decimals, single_words
from keypose.tracker.formats.marker_sets import marked
from keypose.tracker.formats.recording import MarkerSetName, Recording

UNITS: Final[Mapping[MarkerSetName, tuple[str, float, int]]] = {
    "keypose": ("mm", 1000.0, 4),
    "halpe26": ("m", 1.0, 7),
}
"""By markers the unit, how many a metre has, and decimals: a tenth of a micrometre."""

_HEADER = (
    *("DataRate", "CameraRate", "NumFrames", "NumMarkers"),
    *("Units", "OrigDataRate", "OrigDataStartFrame", "OrigNumFrames"),
)


def trc(recording: Recording, file_name: str) -> str:
    """The text of the file, which says its own name. FormatError without two times."""
    labels, places = marked(recording)
    names = single_words(labels)
    unit, per_metre, decimals = UNITS[recording.marker_set]
    rate, count = f"{recording.frames_per_second:.6f}".rstrip("0").rstrip("."), str(len(recording))
    first = str(recording.frames[0])
    axes = (f"{axis}{i + 1}" for i in range(len(names)) for axis in "XYZ")
    lines = [
        "\t".join(("PathFileType", "4", "(X/Y/Z)", file_name)),
        "\t".join(_HEADER),
        "\t".join((rate, rate, count, str(len(names)), unit, rate, first, count)),
        "\t".join(("Frame#", "Time", *(cell for name in names for cell in (name, "", "")))),
        "\t".join(("", "", *axes)),
        "",
    ]
    ps = places * per_metre
    for frame, time_s, positions in zip(recording.frames, recording.times_s, ps, strict=True):
        cells = (cell or "nan" for cell in fixed_decimals(positions.ravel(), decimals))
        lines.append("\t".join((str(frame), f"{time_s:.6f}", *cells)))
    return "\n".join(lines) + "\n"
