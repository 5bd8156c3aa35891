"""Write the motion as markers: TRC tables, and C3D by ezc3d.

Both have the recording's markers (`keypose.tracker.formats.marker_sets`), in the world of all files
(`keypose.tracker.body.ground`).

Of several bodies the names are `NAME:marker`, the frames those of all, and in C3D each is one of
SUBJECTS, as Vicon has them.

C3D: millimetres, as POINT:UNITS says, in single precision, good to a thousandth of a millimetre.
Where a frame is not tracked its points have the residual −1, "invalid" in C3D. Of a motion that
several films show, the residual of a joint is by how many millimetres it lies beside the rays on
which their cameras see it, on average, and the camera mask says which of the first seven films do;
0 and no camera of a point that none sees. KEYPOSE:FILMS names them. The events are heel
strikes and toe offs of a person who walks (`keypose.tracker.space.gait`). There are no analog
channels. Frames are evenly spaced, as C3D allows nothing else, and numbered from 1: frame 0 of the
video is frame 1. Where the motion was low-pass filtered, KEYPOSE:LOW_PASS_HZ has the cut-off.

TRC: `Units` are those of the program whose markers they are. Columns are parted by tabs, and no tab
ends a row: readers take it for one more column. Frames that are not tracked have `nan`, as OpenSim
writes it, which refuses a row that ends with empty places. `Time` counts in seconds from the
video's first frame, and `Frame#` from 0, as in the video; the rates in the header are the mean
where times are uneven.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.conventions import fixed_decimals, single_words
from keypose.tracker.formats.marker_sets import detected, marked, markers_of
from keypose.tracker.formats.recording import MarkerSetName, Recording, named_apart
from keypose.tracker.geometry.rotations import Array

MM_PER_M = 1000.0

LAST_FRAME = 65_534
"""C3D has two bytes for a frame's number, and 65,535 there means "or later"."""
MOST_CAMERAS: Final = 7
"""Of which C3D can say that they see a point."""
LARGEST_RESIDUAL: Final = 255
"""C3D has one byte for it, in whole units of POINT:SCALE, here millimetres."""
MOST_POINTS = 255
"""C3D has one byte for how many there are."""

LONGEST_LABEL = 127
"""Bytes of a point's name: some readers take a longer length for a negative one."""


def c3d(recording: Recording, beside: Sequence[Recording] = ()) -> bytes:
    """The bytes of the file.

    FormatError where ezc3d is not installed, where the format has no room, or without two times.

    beside: the other bodies of the scene, of the same frames and world.
    """
    bodies = (recording, *beside)
    labels, places = _marked_together(bodies)
    _require_c3d_capacity(recording, labels)
    file = _library().c3d()
    file["header"]["points"]["first_frame"] = recording.frames[0]
    point = file["parameters"]["POINT"]
    point["RATE"]["value"] = [recording.frames_per_second]
    point["UNITS"]["value"] = ["mm"]
    point["LABELS"]["value"] = list(labels)
    point["DESCRIPTIONS"]["value"] = [""] * len(labels)
    file.add_parameter("POINT", "X_SCREEN", ["+X"])
    file.add_parameter("POINT", "Y_SCREEN", ["+Y"])
    if recording.filter_hz is not None:
        file.add_parameter("KEYPOSE", "LOW_PASS_HZ", [recording.filter_hz])
    if recording.unscaled:
        spans = [f"{first}-{last}" for first, last in recording.unscaled]
        file.add_parameter("KEYPOSE", "CAMERA_WITHOUT_SCALE", spans)
    _add_subjects(file, bodies)
    _add_events(file, bodies)
    ps = np.moveaxis(places * MM_PER_M, -1, 0).swapaxes(1, 2)
    missing = np.isnan(ps).any(axis=0)
    file["data"]["points"] = np.concatenate([ps, np.ones((1, *missing.shape))])
    marks = file["data"]["meta_points"]
    residuals_mm, masks = _seen_together(bodies, len(recording))
    marks["residuals"] = np.where(missing, -1.0, residuals_mm)[None]
    marks["camera_masks"] = masks & ~missing
    if recording.films:
        file.add_parameter("KEYPOSE", "FILMS", [film.name for film in recording.films])
    with tempfile.TemporaryDirectory() as folder:  # ezc3d writes to a path and nowhere else
        path = Path(folder) / "motion.c3d"
        file.write(str(path))
        return path.read_bytes()


def _marked_together(bodies: Sequence[Recording]) -> tuple[tuple[str, ...], Array]:
    """The markers of all bodies and where they are in the world (N, M, 3), metres, named apart
    where there are several."""
    if len(bodies) == 1:
        return marked(bodies[0])
    each = [marked(body) for body in bodies]
    labels = [named_apart(body, names) for body, (names, _) in zip(bodies, each, strict=True)]
    return tuple(chain.from_iterable(labels)), np.concatenate(
        [places for _, places in each], axis=1
    )


def _seen_together(bodies: Sequence[Recording], frames: int) -> tuple[Array, NDArray[np.bool_]]:
    """As `_seen_by_films`, of the markers of all bodies."""
    counts = [len(marked(body)[0]) for body in bodies]
    each = [
        _seen_by_films(body, (count, frames)) for body, count in zip(bodies, counts, strict=True)
    ]
    residuals_mm, masks = zip(*each, strict=True)
    return np.concatenate(residuals_mm), np.concatenate(masks, axis=1)


def _add_subjects(file: Any, bodies: Sequence[Recording]) -> None:
    """SUBJECTS, where there are several."""
    if len(bodies) == 1:
        return
    names = [body.body_id for body in bodies]
    for name, values in (
        ("USED", [len(names)]),
        ("USES_PREFIXES", [1]),
        ("NAMES", names),
        ("LABEL_PREFIXES", [f"{each}:" for each in names]),
    ):
        file.add_parameter("SUBJECTS", name, values)


def _seen_by_films(recording: Recording, shape: tuple[int, ...]) -> tuple[Array, NDArray[np.bool_]]:
    """(M, N) whole millimetres beside the films' rays, and (7, M, N) which films see a point."""
    residuals_mm, masks = np.zeros(shape), np.zeros((MOST_CAMERAS, *shape), dtype=np.bool_)
    if not recording.films:
        return residuals_mm, masks
    body = recording.skeleton.body
    joint_of = detected(body, markers_of(body, recording.marker_set))
    of_film = np.stack([film.aside_m for film in recording.errors_by_film])
    for marker in np.flatnonzero(joint_of >= 0):
        aside_mm = MM_PER_M * of_film[:, :, joint_of[marker]]
        sees = np.isfinite(aside_mm)
        total = np.where(sees, aside_mm, 0.0).sum(axis=0)
        mean_mm = total / np.maximum(sees.sum(axis=0), 1)
        residuals_mm[marker] = np.clip(np.round(mean_mm), 0, LARGEST_RESIDUAL)
        masks[: len(sees), marker] = sees[:MOST_CAMERAS]
    return residuals_mm, masks


def _add_events(file: Any, bodies: Sequence[Recording]) -> None:
    """EVENT, as programs for gait read it: what, of which side and subject, and when, from frame 1
    on."""
    events = [
        (frame, label, icon, _side(stance.part), body.body_id if len(bodies) > 1 else "")
        for body in bodies
        for stance in body.gait.stances
        for frame, label, icon in (
            (stance.heel_strike, "Foot Strike", 1),
            (stance.toe_off, "Foot Off", 2),
        )
        if frame is not None
    ]
    if not events:
        return
    events.sort()
    frames, labels, icons, sides, subjects = (list(column) for column in zip(*events, strict=True))
    seconds = np.array(frames) / bodies[0].frames_per_second
    for name, values in (
        ("USED", [len(events)]),
        ("CONTEXTS", sides),
        ("LABELS", labels),
        ("ICON_IDS", icons),
        ("DESCRIPTIONS", [""] * len(events)),
        ("SUBJECTS", subjects),
        ("TIMES", np.stack([seconds // 60, seconds % 60])),
        ("GENERIC_FLAGS", [0] * len(events)),
    ):
        file.add_parameter("EVENT", name, values)


def _side(part: str) -> str:
    """Left, Right or General, as contexts of events are called."""
    side = part.partition("_")[0]
    return side.capitalize() if side in ("left", "right") else "General"


def _library() -> Any:
    try:
        import ezc3d
    except ImportError:
        raise FormatError("C3D files need ezc3d: pip install 'keypose[c3d]'.") from None
    return ezc3d


def _require_c3d_capacity(recording: Recording, labels: tuple[str, ...]) -> None:
    if recording.frames[-1] + 1 > LAST_FRAME:
        raise FormatError(
            f"C3D numbers frames up to {LAST_FRAME} and this motion goes beyond: choose CSV or NPZ."
        )
    if len(labels) > MOST_POINTS:
        raise FormatError(
            f"C3D holds {MOST_POINTS} points and the body has {len(labels)} joints and landmarks: "
            "choose CSV or NPZ."
        )
    longest = max(labels, key=lambda label: len(label.encode()))
    if len(longest.encode()) > LONGEST_LABEL:
        raise FormatError(
            f"C3D has no room for the name {longest!r} of {len(longest.encode())} bytes; "
            f"{LONGEST_LABEL} are the most."
        )


UNITS: Final[Mapping[MarkerSetName, tuple[str, float, int]]] = {
    "keypose": ("mm", 1000.0, 4),
    "halpe26": ("m", 1.0, 7),
}
"""By markers the unit, how many a metre has, and decimals: a tenth of a micrometre."""

_HEADER = (
    *("DataRate", "CameraRate", "NumFrames", "NumMarkers"),
    *("Units", "OrigDataRate", "OrigDataStartFrame", "OrigNumFrames"),
)


def trc(recording: Recording, beside: Sequence[Recording] = ()) -> str:
    """The text of the file, which says its own name. FormatError without two times.

    beside: the other bodies of the scene, of the same frames and world.
    """
    file_name = f"{'motion' if beside else recording.body_id or 'motion'}.trc"
    labels, places = _marked_together((recording, *beside))
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
