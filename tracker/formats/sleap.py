"""Keypoints as SLEAP exports them for analysis, as HDF5 or as CSV.

HDF5: `tracks` of n_tracks × 2 × n_nodes × n_frames, `node_names`, `track_names`, `point_scores` of
n_tracks × n_nodes × n_frames. An attribute `dims` names the axes where they are in another order.
The first frame is the video's.
CSV: a row for each instance, `track`, `frame_idx`, and `<node>.x`, `<node>.y`, `<node>.score`.
"""

from __future__ import annotations

import json
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.hdf5 import Group
from keypose.tracker.formats.people import People, chosen_individual, person_numbers
from keypose.tracker.formats.reading_csv import number
from keypose.tracker.geometry.rotations import Array

AXES: Final = ("track", "xy", "node", "frame")
"""Of `tracks`, where the file does not say otherwise."""
FRAME: Final = "frame_idx"
UNTRACKED: Final = "untracked"
"""Instances of a CSV that belong to no track."""


def is_analysis(root: Group) -> bool:
    """Whether an HDF5 file is SLEAP's analysis, rather than somebody else's."""
    return root.has("tracks", "node_names")


def read_analysis(root: Group, individual: str | None) -> People:
    """One track of an analysis file; FormatError in one sentence."""
    file, names = root.file, root.texts("node_names")
    tracks = _ordered(root, "tracks", AXES)
    count, axes, nodes, frames = tracks.shape
    if axes != 2 or nodes != len(names):
        raise FormatError(
            f"{file}: its tracks are {count} × {axes} × {nodes} × {frames}; 2 coordinates of "
            f"{len(names)} nodes are expected."
        )
    track_names = root.texts("track_names") if root.has("track_names") else []
    labels = track_names if len(track_names) == count else [f"track_{i}" for i in range(count)]
    i = labels.index(chosen_individual(file, labels, individual))
    uv = tracks[i].transpose(2, 1, 0)
    scores = np.full(uv.shape[:2], np.nan)
    if root.has("point_scores"):
        all_scores = _ordered(root, "point_scores", ("track", "node", "frame"))
        if all_scores.shape != (count, nodes, frames):
            raise FormatError(f"{file}: its point_scores do not have the shape of its tracks.")
        scores = all_scores[i].T
    rows = person_numbers(file, uv, scores)
    return People({n: [row] for n, row in enumerate(rows)}, tuple(names), program="SLEAP")


def _ordered(root: Group, name: str, axes: tuple[str, ...]) -> NDArray[np.float64]:
    """A dataset with its axes in this order."""
    values, axes_text = root.numbers(name), root.dataset_text(name, "dims")
    if values.ndim != len(axes):
        raise FormatError(
            f"{root.file}: its {name} has {values.ndim} axes where {len(axes)} are due."
        )
    try:
        dims = json.loads(axes_text) if axes_text else list(axes)
    except ValueError:
        dims = None
    if not isinstance(dims, list) or sorted(map(str, dims)) != sorted(axes):
        raise FormatError(f"{root.file}: its {name} names its axes {axes_text[:60]!r}.")
    return values.transpose([dims.index(axis) for axis in axes])


def is_table(heads: list[str]) -> bool:
    """Whether the heads of a CSV are those of SLEAP."""
    return FRAME in heads and any(head.endswith(".x") for head in heads)


def read_table(file: str, rows: list[list[str]], individual: str | None) -> People:
    """One track of a CSV; FormatError in one sentence."""
    heads = [head.strip() for head in rows[0]]
    names = [head[:-2] for head in heads if head.endswith(".x") and f"{head[:-2]}.y" in heads]
    if not names:
        raise FormatError(f"{file} has no node with columns NAME.x and NAME.y.")
    short = next((n for n, row in enumerate(rows) if len(row) != len(heads)), None)
    if short is not None:
        raise FormatError(
            f"{file}: row {short + 1} has {len(rows[short])} columns where {len(heads)} are due."
        )
    track = heads.index("track") if "track" in heads else None
    labels = [(row[track].strip() or UNTRACKED) if track is not None else "" for row in rows[1:]]
    if not labels:
        raise FormatError(f"{file} holds no frame.")
    wanted = chosen_individual(file, list(dict.fromkeys(labels)), individual)
    mine = [row for row, label in zip(rows[1:], labels, strict=True) if label == wanted]
    frames = [_frame(file, row[heads.index(FRAME)]) for row in mine]
    uv = np.stack(
        [_column(file, mine, heads.index(f"{name}.{axis}")) for name in names for axis in "xy"], 1
    ).reshape(len(mine), len(names), 2)
    scores = np.stack([_scores(file, mine, heads, f"{name}.score") for name in names], axis=1)
    rows_of_frame: dict[int, list[Any]] = {}
    for frame, row in zip(frames, person_numbers(file, uv, scores), strict=True):
        rows_of_frame.setdefault(frame, []).append(row)
    return People(rows_of_frame, tuple(names), program="SLEAP")


def _scores(file: str, rows: list[list[str]], heads: list[str], name: str) -> Array:
    return _column(file, rows, heads.index(name)) if name in heads else np.full(len(rows), np.nan)


def _column(file: str, rows: list[list[str]], column: int) -> Array:
    return np.array([number(file, row[column]) for row in rows])


def _frame(file: str, word: str) -> int:
    value = number(file, word)
    if not (0 <= value < 1e9 and value == int(value)):
        raise FormatError(f"{file} has a frame that is numbered {word[:40]!r}.")
    return int(value)
