"""Keep the keypoints that networks found in this user's cache folder.

They can be found again, so whatever is wrong with a file, or with the folder, it is as if there was
none. Files used longest ago go first when there are too many bytes.
"""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import Final

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import KeypointError
from keypose.tracker.files import read_own
from keypose.tracker.keypoints.blazepose import NAMES
from keypose.tracker.keypoints.detect import DetectionWindow
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.model_files import cache_folder, find_model
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.archive import archive_arrays, archive_bytes
from keypose.tracker.storage.atomic import make_folder, write_file
from keypose.tracker.storage.fingerprints import Span, has_drafted_keypoints
from keypose.tracker.storage.mask_arrays import MASK_ARRAYS, arrays_of_masks, masks_of_arrays
from keypose.tracker.tracking.cues import sources
from keypose.tracker.tracking.cues.drafted import drafted_over

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
        content = archive_bytes({**rows, **arrays_of_masks(stretch.masks)})
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


def _stretch(content: bytes) -> DetectionWindow:
    """ValueError where it is none."""
    arrays = archive_arrays(content)
    if set(arrays) != {*_ROWS, *_STATE, *MASK_ARRAYS}:
        raise ValueError("its entries are not those of a stretch")
    count = len(np.atleast_1d(arrays["lost_for"]))
    masks = masks_of_arrays(*(arrays[name] for name in MASK_ARRAYS))
    shapes = {name: (count, *shape) for name, shape in _ROWS.items()} | {"regions": (count, 4)}
    fits = all(arrays[name].shape == shape for name, shape in shapes.items())
    numbers = all(arrays[name].dtype == np.float64 for name in shapes)
    lost_for = arrays["lost_for"]
    counts = lost_for.shape == (count,) and lost_for.dtype == np.int64
    if not fits or not numbers or not counts or len(masks) != count:
        raise ValueError("its entries do not fit together")
    is_seen = np.isfinite(arrays["uv"]).all(axis=(1, 2))
    if not np.isfinite(arrays["regions"]).all() or (lost_for[is_seen] != 0).any():
        raise ValueError("it holds no stretch")
    if not np.array_equal([mask is not None for mask in masks], is_seen):
        raise ValueError("its masks are of other frames")
    return DetectionWindow(**{name: arrays[name] for name in (*_ROWS, *_STATE)}, masks=masks)


def found_before(
    session: Session, span: Span, drafted: Keypoints | None = None
) -> Keypoints | None:
    """The keypoints that a segment is tracked with, a draft's or those that a network found
    when it was tracked last, without reading the film; None where there are none.

    drafted: what `keypoints_of_session` reads beside the session's file.
    """
    skeleton = Skeleton.of(session.subject.body)
    posed = {k.frame: k.pose(skeleton) for k in session.subject.keyframes if k.frame in span}
    camera, path = session.view.camera, session.camera_path
    file = session.view.keypoints
    if drafted is not None and file is not None and has_drafted_keypoints(session):
        together = file.together
        served = drafted_over(drafted, span, skeleton, posed, camera, path, together=together)
        if served is not None:
            return served
    model, film = find_model(session.settings.network_used), session.view.video.pictures
    return sources.found_before(posed, skeleton, camera, film, Detections(), model, path)
