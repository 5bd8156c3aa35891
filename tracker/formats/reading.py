"""Recorded motion in: joint positions over time, whatever program wrote them.

One module per format reads its own files into a `JointMotion`: `reading_bvh`,
`reading_markers`, `reading_csv`, `reading_smpl`. Whatever is wrong with a file is reported in one
sentence.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Final

import numpy as np

from keypose.tracker.errors import FormatError
from keypose.tracker.files import TooLarge, read_regular
from keypose.tracker.formats.joint_motion import JointMotion

LARGEST_MOTION_BYTES: Final = 96 * 2**20
MOTION_READERS: Final[Mapping[str, tuple[str, str]]] = {
    ".bvh": ("BVH", "reading_bvh.read_bvh"),
    ".trc": ("TRC", "reading_markers.read_trc"),
    ".c3d": ("C3D", "reading_markers.read_c3d"),
    ".csv": ("CSV", "reading_csv.read_csv"),
    ".npz": ("SMPL poses", "reading_smpl.read_smpl"),
    ".pt": ("SMPL poses", "reading_smpl.read_torch"),
    ".pth": ("SMPL poses", "reading_smpl.read_torch"),
    ".pkl": ("", "reading_smpl.refuse_pickle"),
    ".pickle": ("", "reading_smpl.refuse_pickle"),
}
"""By the ending of a name what writes such files, and what reads a file's name and content; a
reader without a program says why it reads nothing."""


def load_motion(path: Path) -> JointMotion:
    """The motion in a file, by the ending of its name; FormatError in one sentence."""
    if path.is_dir():
        raise FormatError(f"{str(path)!r} is a folder; name the motion file in it.")
    ending = path.suffix.lower()
    if ending not in MOTION_READERS:
        raise FormatError(
            f"{path.name} is no motion file: .bvh, .trc, .c3d, .csv, or SMPL poses as "
            ".npz or .pt are expected."
        )
    try:
        with np.errstate(all="ignore"):  # numbers too large become none, and are refused as such
            return _reader(ending)(path.name, read_regular(path, LARGEST_MOTION_BYTES))
    except TooLarge:
        limit = LARGEST_MOTION_BYTES // 2**20
        raise FormatError(f"{path.name} is larger than the {limit} MB a motion may have.") from None
    except FileNotFoundError:
        raise FormatError(f"There is no motion file {str(path)!r}.") from None
    except OSError as error:
        raise FormatError(f"{path.name} cannot be read: {error.strerror or error}.") from None


def _reader(ending: str) -> Callable[[str, bytes], JointMotion]:
    module, name = MOTION_READERS[ending][1].split(".")
    read: Callable[[str, bytes], JointMotion] = getattr(
        import_module(f"keypose.tracker.formats.{module}"), name
    )
    return read
