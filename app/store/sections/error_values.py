"""How far off each part is expected to be, as JSON."""

from __future__ import annotations

import math
from typing import Final

import numpy as np

from app.store.sections.json_value import Json
from app.store.state import AppState
from tracker.body.pose import part_transforms
from tracker.body.skeleton import Skeleton
from tracker.geometry.camera import Camera
from tracker.geometry.rotations import Array
from tracker.tracking.result import SegmentResult

MOST: Final = 5
"""Parts of a segment that are told."""


def errors(app_state: AppState) -> Json:
    """The parts of every segment with the largest expected errors, each at its worst frame, the
    worst first: in pixels of the video, and in centimetres unless the lens is a guess."""
    edit = app_state.edit
    if edit is None:
        return []
    doc = edit.settled
    skeleton, camera = Skeleton.of(doc.body), None if doc.lens_is_guess else doc.camera
    return [
        {"first": found.first, **worst}
        for found in edit.results.fitting(doc).values()
        for worst in _worst_parts(found, skeleton, camera)
    ]


def _worst_parts(
    found: SegmentResult, skeleton: Skeleton, camera: Camera | None
) -> list[dict[str, Json]]:
    """Up to MOST parts of one segment, of those of which anything is known."""
    expected = found.diagnostics.expected_error
    if expected is None or not found.finished:
        return []
    expected = found.where_tracked(expected)
    known = np.where(np.isfinite(expected), expected, -np.inf)
    rows, largest = known.argmax(axis=0), known.max(axis=0)
    parts = [int(k) for k in np.argsort(-largest, kind="stable")[:MOST] if largest[k] >= 0]
    px_per_m = _px_per_m(found, skeleton, camera, rows[parts], parts)
    return [
        {
            "part": skeleton.body.names[part],
            "frame": found.first + int(rows[part]),
            "px": round(float(largest[part]), 2),
            "cm": None if math.isnan(scale) else round(100 * float(largest[part] / scale), 2),
        }
        for part, scale in zip(parts, px_per_m, strict=True)
    ]


def _px_per_m(
    found: SegmentResult, skeleton: Skeleton, camera: Camera | None, rows: Array, parts: list[int]
) -> Array:
    """(K,) pixels that a metre across the line of sight spans where each part is at its row; NaN
    where nobody knows."""
    if camera is None:
        return np.full(len(parts), np.nan)
    path = found.trajectory
    Ts = part_transforms(skeleton, path.Rs_parent_part[rows], path.ps_camera_root[rows])
    depth = camera.depth(Ts[np.arange(len(parts)), parts, :3, 3])
    return np.where(depth > 0, math.sqrt(camera.fx * camera.fy) / np.maximum(depth, 1e-9), np.nan)
