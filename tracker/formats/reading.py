"""Recorded motion in: joint positions over time, whatever program wrote them.

One module per format reads its own files into a `JointMotion`: `reading_bvh`,
`reading_markers`, `reading_csv`, `reading_smpl`. Whatever is wrong with a file is reported in one
sentence.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Final

import numpy as np

from keypose.tracker.errors import FormatError
from keypose.tracker.files import TooLarge, read_regular
from keypose.tracker.formats.joint_motion import JointMotion

LARGEST_MOTION_BYTES: Final = 96 * 2**20


def load_motion(path: Path) -> JointMotion:
    """The motion in a file, by the ending of its name; FormatError in one sentence."""
    if path.is_dir():
        raise FormatError(f"{str(path)!r} is a folder; name the motion file in it.")
    read = _readers().get(path.suffix.lower())
    if read is None:
        raise FormatError(
            f"{path.name} is no motion file: .bvh, .trc, .c3d, .csv, or SMPL poses as "
            ".npz or .pt are expected."
        )
    try:
        with np.errstate(all="ignore"):  # numbers too large become none, and are refused as such
            return read(path.name, read_regular(path, LARGEST_MOTION_BYTES))
    except TooLarge:
        limit = LARGEST_MOTION_BYTES // 2**20
        raise FormatError(f"{path.name} is larger than the {limit} MB a motion may have.") from None
    except FileNotFoundError:
        raise FormatError(f"There is no motion file {str(path)!r}.") from None
    except OSError as error:
        raise FormatError(f"{path.name} cannot be read: {error.strerror or error}.") from None


def _readers() -> dict[str, Callable[[str, bytes], JointMotion]]:
    """Return by the ending of a name the reader of a file's name and content."""
    from keypose.tracker.formats.reading_bvh import read_bvh
    from keypose.tracker.formats.reading_csv import read_csv
    from keypose.tracker.formats.reading_markers import read_c3d, read_trc
    from keypose.tracker.formats.reading_smpl import read_smpl, read_torch, refuse_pickle

    return {
        ".bvh": read_bvh, ".trc": read_trc, ".c3d": read_c3d, ".csv": read_csv,
        ".npz": read_smpl, ".pt": read_torch, ".pth": read_torch,
        ".pkl": refuse_pickle, ".pickle": refuse_pickle,
    }  # fmt: skip
