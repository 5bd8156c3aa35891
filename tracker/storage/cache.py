"""Keep the keypoints that networks found in this user's cache folder.

They can be found again, so whatever is wrong with a file, or with the folder, it is as if there was
none. Files used longest ago go first when there are too many bytes.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import astuple
from pathlib import Path
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import KeypointError
from keypose.tracker.files import read_own
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.blazepose import NAMES
from keypose.tracker.keypoints.detect import DetectionWindow
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.model_files import cache_folder, find_model
from keypose.tracker.keypoints.person_mask import PersonMask
from keypose.tracker.keypoints.region import Region
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.archive import archive_arrays, archive_bytes
from keypose.tracker.storage.atomic import make_folder, write_file
from keypose.tracker.storage.fingerprints import Span
from keypose.tracker.tracking.cues import sources

Masks: TypeAlias = tuple[PersonMask | None, ...]
MOST_BYTES: Final = 256 * 2**20
"""Some 70,000 frames."""
LARGEST_STRETCH_BYTES: Final = 2**20
_ROWS: Final = {"uv": (len(NAMES), 2), "visibility": (len(NAMES),), "p_hips": (len(NAMES), 3)}


class Detections:
    """Stretches on disk, as `detect` keeps them."""

    def __init__(self, folder: Path | None = None, most_bytes: int = MOST_BYTES) -> None:
        self._folder = cache_folder() / "keypoints" if folder is None else folder
        self._most_bytes = most_bytes

    def get(self, key: str) -> DetectionWindow | None:
        """The stretch of this key; None where there is none that can be used."""
        path = self._path(key)
        try:
            stretch = _stretch(read_own(path, LARGEST_STRETCH_BYTES))
        except (OSError, ValueError):
            return None
        with suppress(OSError):
            os.utime(path)  # used now
        return stretch

    def put(self, key: str, stretch: DetectionWindow) -> None:
        """Keep a stretch, if that can be done."""
        rows = {name: getattr(stretch, name) for name in (*_ROWS, *_STATE)}
        content = archive_bytes({**rows, **_arrays_of(stretch.masks)})
        with suppress(KeypointError):
            make_folder(self._folder, error=KeypointError)
            write_file(self._path(key), content, overwrite=True, error=KeypointError)
        with suppress(OSError):
            self._tidy()

    def _path(self, key: str) -> Path:
        return self._folder / f"{key}.npz"

    def _tidy(self) -> None:
        with os.scandir(self._folder) as entries:
            files = [entry for entry in entries if entry.name.endswith(".npz")]
        facts = [(entry.stat(follow_symlinks=False), entry.path) for entry in files]
        too_many = sum(fact.st_size for fact, _ in facts) - self._most_bytes
        for fact, path in sorted(facts, key=lambda each: each[0].st_mtime_ns):
            if too_many <= 0:
                return
            with suppress(FileNotFoundError):  # another Keypose was quicker
                Path(path).unlink()
            too_many -= fact.st_size


_STATE: Final = ("regions", "lost_for")
_MASKS: Final = ("looked", "packed", "lengths")


def _arrays_of(masks: Sequence[PersonMask | None]) -> dict[str, NDArray[Any]]:
    """Return the squares of masks (N, 4), NaN where there is none, what is packed, one after the
    other, and how many bytes are of each (N,)."""
    nowhere = np.full(4, np.nan)
    packed = [b"" if mask is None else mask.packed for mask in masks]
    return {
        "looked": np.array([nowhere if m is None else astuple(m.region) for m in masks]),
        "packed": np.frombuffer(b"".join(packed), np.uint8),
        "lengths": np.array([len(one) for one in packed], dtype=np.int64),
    }


def _masks(looked: Array, packed: NDArray[np.uint8], lengths: NDArray[np.int64]) -> Masks:
    """The masks of these arrays; ValueError where they hold none."""
    ends = np.cumsum(lengths)
    if packed.dtype != np.uint8 or lengths.min() < 0 or packed.shape != (ends[-1],):
        raise ValueError("its masks do not fit together")
    masks: list[PersonMask | None] = []
    for square, end, length in zip(looked.tolist(), ends, lengths, strict=True):
        mask = PersonMask(Region(*square), packed[end - length : end].tobytes())
        if length:
            mask.levels()  # ValueError where it is damaged
        masks.append(mask if length else None)
    return tuple(masks)


def _stretch(content: bytes) -> DetectionWindow:
    """ValueError where it is none."""
    arrays = archive_arrays(content)
    if set(arrays) != {*_ROWS, *_STATE, *_MASKS}:
        raise ValueError("its entries are not those of a stretch")
    count = len(np.atleast_1d(arrays["lost_for"]))
    shapes = {
        **{name: (count, *shape) for name, shape in _ROWS.items()},
        **{"regions": (count, 4), "looked": (count, 4)},
    }
    fits = all(arrays[name].shape == shape for name, shape in shapes.items())
    numbers = all(arrays[name].dtype == np.float64 for name in shapes)
    lost_for, whole = arrays["lost_for"], [arrays[name] for name in ("lost_for", "lengths")]
    counts = all(one.shape == (count,) and one.dtype == np.int64 for one in whole)
    if not fits or not numbers or not counts:
        raise ValueError("its entries do not fit together")
    seen = np.isfinite(arrays["uv"]).all(axis=(1, 2))
    squares = np.isfinite([*arrays["regions"], *arrays["looked"][seen]])
    if count < 1 or not squares.all() or (lost_for[seen] != 0).any():
        raise ValueError("it holds no stretch")
    if not np.array_equal(arrays["lengths"] > 0, seen):
        raise ValueError("its masks are of other frames")
    masks = _masks(*(arrays[name] for name in _MASKS))
    return DetectionWindow(**{name: arrays[name] for name in (*_ROWS, *_STATE)}, masks=masks)


def found_before(session: Session, span: Span) -> Keypoints | None:
    """Return the keypoints that a network found in one segment, without reading the film; None
    where there are none.
    """
    skeleton = Skeleton.of(session.subject.body)
    posed = {k.frame: k.pose(skeleton) for k in session.subject.keyframes if k.frame in span}
    model = find_model(session.settings.network_used)
    film = session.view.video.pictures
    return sources.found_before(
        posed, skeleton, session.view.camera, film, Detections(), model,
        session.camera_path,
    )  # fmt: skip
