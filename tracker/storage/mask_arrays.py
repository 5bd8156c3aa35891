"""Where a person is in each frame, as arrays of a file.

looked   (N, 4)  squares that the masks are of, NaN in frames without one
packed   (B,)    what is packed of all, one after the other
lengths  (N,)    how many bytes are of each frame, 0 in frames without one
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import astuple
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.person_mask import PersonMask
from keypose.tracker.keypoints.region import Region

Masks: TypeAlias = tuple[PersonMask | None, ...]
MASK_ARRAYS: Final = ("looked", "packed", "lengths")


def arrays_of_masks(masks: Sequence[PersonMask | None]) -> dict[str, NDArray[Any]]:
    """The arrays of so many frames' masks, None where there is none."""
    nowhere = np.full(4, np.nan)
    packed = [b"" if mask is None else mask.packed for mask in masks]
    return {
        "looked": np.array([nowhere if m is None else astuple(m.region) for m in masks]),
        "packed": np.frombuffer(b"".join(packed), np.uint8),
        "lengths": np.array([len(mask_bytes) for mask_bytes in packed], dtype=np.int64),
    }


def masks_of_arrays(looked: Array, packed: NDArray[np.uint8], lengths: NDArray[np.int64]) -> Masks:
    """The masks of these arrays; ValueError where they hold none."""
    count = len(np.atleast_1d(lengths))
    if lengths.shape != (count,) or lengths.dtype != np.int64 or count < 1 or lengths.min() < 0:
        raise ValueError("its masks are not counted")
    ends = np.cumsum(lengths)
    if packed.dtype != np.uint8 or packed.shape != (ends[-1],):
        raise ValueError("its masks do not fit together")
    if looked.shape != (count, 4) or looked.dtype != np.float64:
        raise ValueError("its masks are of no squares")
    if not np.isfinite(looked[lengths > 0]).all():
        raise ValueError("its masks are of no squares")
    masks: list[PersonMask | None] = []
    for square, end, length in zip(looked.tolist(), ends, lengths, strict=True):
        mask = PersonMask(Region(*square), packed[end - length : end].tobytes())
        if length:
            mask.levels()  # ValueError where it is damaged
        masks.append(mask if length else None)
    return tuple(masks)
