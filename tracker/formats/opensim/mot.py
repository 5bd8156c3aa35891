"""Joint coordinates as .mot, OpenSim's table of motions: degrees, metres, seconds.

What the columns mean is in `keypose.tracker.formats.opensim.coordinates`. Frames must be tracked
from the first to the last, for OpenSim reads no gaps.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from keypose.tracker.formats.decimals import fixed_decimals
from keypose.tracker.formats.opensim.coordinates import coordinates
from keypose.tracker.formats.opensim.model import OpenSimModel
from keypose.tracker.formats.recording import Recording
from keypose.tracker.geometry.rotations import Array

DECIMALS = 6
"""A microdegree, a micrometre, a microsecond."""


def mot(recording: Recording, model: OpenSimModel | None = None) -> str:
    """The text of the file. FormatError where frames between are not tracked, or no person is."""
    whole = recording.whole("MOT")
    return _table("Coordinates", whole.times_s, coordinates(whole, model))


def _table(name: str, times_s: Array, columns: Mapping[str, Array]) -> str:
    head = [
        name,
        "version=1",
        f"nRows={len(times_s)}",
        f"nColumns={len(columns) + 1}",
        "inDegrees=yes",
        "",
        "Angles are degrees, lengths metres, times seconds; x is ahead, y up, z right.",
        "endheader",
        "\t".join(("time", *columns)),
    ]
    rows = np.column_stack([times_s, *columns.values()])
    return "\n".join([*head, *("\t".join(fixed_decimals(row, DECIMALS)) for row in rows)]) + "\n"
