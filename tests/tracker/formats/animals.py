"""Files of keypoints as SLEAP and DeepLabCut write them, of animals whose places are given."""

from __future__ import annotations

import csv
import pickle
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

SCORER = "DLC_net"


def sleap_h5(
    path: Path, names: Sequence[str], uv: Floats, scores: Floats | None = None,
    tracks: Sequence[str] = (), standard: bool = False,
) -> Path:  # fmt: skip
    """uv (T, N, L, 2) of T tracks in N frames; `standard` has frames first and says so."""
    with h5py.File(path, "w") as file:
        values, dims = uv.transpose(0, 3, 2, 1), ["track", "xy", "node", "frame"]
        if standard:
            values, dims = uv.transpose(1, 0, 2, 3), ["frame", "track", "node", "xy"]
        file["tracks"] = values
        file["node_names"] = [name.encode() for name in names]
        file["track_names"] = [name.encode() for name in tracks]
        if standard:
            file["tracks"].attrs["dims"] = str(dims).replace("'", '"')
        elif scores is not None:
            file["point_scores"] = scores.transpose(0, 2, 1)
    return path


def sleap_csv(path: Path, names: Sequence[str], uv: Floats, tracks: Sequence[str] = ("",)) -> Path:
    """uv (T, N, L, 2); what is not found is left empty."""
    heads = [f"{name}.{what}" for name in names for what in ("x", "y", "score")]
    with path.open("w", newline="") as text:
        writer = csv.writer(text)
        writer.writerow(["track", "frame_idx", "instance.score", *heads])
        for frame in range(uv.shape[1]):
            for track, rows in zip(tracks, uv, strict=True):
                cells = [c for u, v in rows[frame] for c in (_cell(u), _cell(v), 0.9)]
                writer.writerow([track, frame, 0.9, *cells])
    return path


def _cell(value: float) -> object:
    return value if np.isfinite(value) else ""


def dlc_columns(names: Sequence[str], animals: Sequence[str] = ()) -> list[tuple[str, ...]]:
    """The levels of each column."""
    coords = ("x", "y", "likelihood")
    if animals:
        return [(SCORER, a, name, c) for a in animals for name in names for c in coords]
    return [(SCORER, name, c) for name in names for c in coords]


def dlc_values(uv: Floats, likelihood: float = 0.9) -> Floats:
    """(N, 3 · A · L) the numbers of a table; uv (A, N, L, 2) of A animals."""
    sure = np.full((*uv.shape[:-1], 1), likelihood)
    return np.concatenate([uv, sure], axis=-1).transpose(1, 0, 2, 3).reshape(uv.shape[1], -1)


def dlc_csv(
    path: Path, columns: Sequence[tuple[str, ...]], values: Floats, index: Sequence[object] = ()
) -> Path:
    """A row for each frame, named by `index` where it is given."""
    heads = ("scorer", "bodyparts", "coords")
    if len(columns[0]) == 4:
        heads = ("scorer", "individuals", "bodyparts", "coords")
    with path.open("w", newline="") as text:
        writer = csv.writer(text)
        writer.writerows([head, *(c[i] for c in columns)] for i, head in enumerate(heads))
        for name, row in zip(index or range(len(values)), values, strict=True):
            writer.writerow([name, *map(_cell, row)])
    return path


def dlc_table_h5(path: Path, columns: Sequence[tuple[str, ...]], values: Floats) -> Path:
    """As pandas writes a frame with format="table"."""
    kind = np.dtype([("index", "<i8"), ("values_block_0", "<f8", (values.shape[1],))])
    rows = np.zeros(len(values), kind)
    rows["index"], rows["values_block_0"] = np.arange(len(values)), values
    return _pandas(path, "frame_table", {"table": rows}, pickle.dumps(list(columns), 0))


def dlc_fixed_h5(path: Path, columns: Sequence[tuple[str, ...]], values: Floats) -> Path:
    """As pandas writes a frame with format="fixed"."""
    members: dict[str, Any] = {"block0_values": values, "axis1": np.arange(len(values))}
    for i, level in enumerate(zip(*columns, strict=True)):
        words = sorted(set(level))
        members[f"block0_items_level{i}"] = [word.encode() for word in words]
        members[f"block0_items_label{i}"] = np.array([words.index(w) for w in level], np.int8)
    return _pandas(path, "frame", members)


def _pandas(path: Path, kind: str, members: dict[str, Any], pickled: bytes | None = None) -> Path:
    with h5py.File(path, "w") as file:
        group = file.create_group("df_with_missing")
        group.attrs["pandas_type"] = np.bytes_(kind)
        for name, values in members.items():
            group[name] = values
        if pickled is not None:
            group["table"].attrs["values_block_0_kind"] = np.bytes_(pickled)
    return path
