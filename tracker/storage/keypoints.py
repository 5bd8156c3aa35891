"""Keypoints on disk: `keypoints-<hash>.npz` beside the session, written once, never changed.

The file is a plain NumPy archive, as a tracks file is:

    first_frame  ()         index of the first row's video frame
    names        (L,)       text
    uv           (N, L, 2)  pixels, NaN where nothing was found
    visibility   (N, L)     from 0 to 1, 0 where uv is NaN
    p_hips       (N, L, 3)  metres, NaN where unknown; left out where no depth is known

Its numbers have four bytes: a fraction of a thousandth of a pixel.
"""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.errors import KeypointError
from keypose.tracker.files import read_regular
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.session.references import KeypointFile
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.archive import LARGEST_PACKED_BYTES, archive_arrays, archive_bytes
from keypose.tracker.storage.atomic import write_file


def save_keypoints(
    session: Session,
    session_path: Path,
    keypoints: Keypoints,
    source: str,
    *,
    network: str = "",
    seeds: Sequence[int] = (),
) -> Session:
    """Write keypoints beside the session file; the session that refers to them, not yet saved.

    source:  what found them, for people: a network's name, or the file they were imported from.
    network: fingerprint of the network; empty for an imported file.
    seeds:   frames where somebody said where the body is.
    KeypointError in one sentence when the file cannot be written.
    """
    content = archive_bytes(_arrays(keypoints))
    name = _name(content)
    write_file(session_path.parent / name, content, overwrite=True, error=KeypointError)
    reference = KeypointFile(
        file=name, source=source, network=network, seeds=tuple(sorted(set(seeds)))
    )
    return session.model_copy(update={"keypoints": reference})


def of_session(session: Session, folder: Path) -> Keypoints | None:
    """The keypoints a session's segments are tracked with; None where it has none.

    folder: of the session's file.
    KeypointError in one sentence when their file is missing, damaged, or of a longer film.
    """
    if session.keypoints is None:
        return None
    found = load_keypoints(folder / session.keypoints.file)
    if found.last_frame >= session.video.frame_count:
        raise KeypointError(
            f"{session.keypoints.file} holds keypoints up to frame {found.last_frame}, but the "
            f"video ends at {session.video.frame_count - 1}: find them again."
        )
    return found


def load_keypoints(path: Path) -> Keypoints:
    """The keypoints in a file; KeypointError in one sentence when there are none."""
    try:
        content = read_regular(path, LARGEST_PACKED_BYTES)
    except OSError as error:
        raise KeypointError(
            f"The keypoints {str(path)!r} cannot be read: {error.strerror or error}; find them "
            "again."
        ) from None
    try:
        if path.name != _name(content):
            raise ValueError("its content does not fit its name")
        return _keypoints(archive_arrays(content))
    except ValueError as error:
        raise KeypointError(
            f"The keypoints {str(path)!r} are damaged: {error}; find them again."
        ) from None


def _arrays(keypoints: Keypoints) -> dict[str, NDArray[Any]]:
    arrays: dict[str, NDArray[Any]] = {
        "first_frame": np.array(keypoints.first_frame, dtype="<i8"),
        "names": np.array(keypoints.names, dtype=np.str_),
        "uv": keypoints.uv.astype("<f4"),
        "visibility": keypoints.visibility.astype("<f4"),
    }
    if keypoints.p_hips is not None:
        arrays["p_hips"] = keypoints.p_hips.astype("<f4")
    return arrays


def _keypoints(arrays: dict[str, NDArray[Any]]) -> Keypoints:
    try:
        names = tuple(str(name) for name in arrays["names"])
        first = int(arrays["first_frame"])
        uv, visibility = _numbers(arrays["uv"]), _numbers(arrays["visibility"])
        p_hips = _numbers(arrays["p_hips"]) if "p_hips" in arrays else None
    except (KeyError, TypeError):
        raise ValueError("its entries are not those of keypoints") from None
    shape = (len(uv), len(names))
    fits = uv.shape == (*shape, 2) and visibility.shape == shape
    if not fits or (p_hips is not None and p_hips.shape != (*shape, 3)) or first < 0:
        raise ValueError("its entries do not fit together")
    if 0 in shape or len(set(names)) < len(names):
        raise ValueError("it holds no keypoints, or two of one name")
    known = np.isfinite(uv).all(axis=-1)
    if not ((visibility >= 0) & (visibility <= 1)).all() or visibility[~known].any():
        raise ValueError("it holds visibilities that are none")
    return Keypoints(first, names, uv, visibility, p_hips)


def _numbers(array: NDArray[Any]) -> Array:
    if array.dtype.kind != "f":
        raise ValueError("its entries are not those of keypoints")
    return array.astype(np.float64)


def _name(content: bytes) -> str:
    return f"keypoints-{hashlib.sha256(content).hexdigest()[:12]}.npz"
