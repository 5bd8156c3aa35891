"""Read archives of NumPy and of PyTorch, known by the names of their arrays: poses of SMPL, and
the motion as Keypose writes it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from numpy.typing import NDArray

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.joint_motion import JointMotion
from keypose.tracker.formats.reading_amass import read_amass
from keypose.tracker.formats.reading_recovered import is_recovered, read_recovered
from keypose.tracker.formats.torch_archive import torch_arrays
from keypose.tracker.storage.archive import archive_arrays


def read_smpl(file: str, content: bytes) -> JointMotion:
    """The motion in an archive of NumPy; FormatError in one sentence."""
    try:
        arrays = archive_arrays(content, packed=True)
    except ValueError as error:
        raise FormatError(f"{file} is no NumPy archive of plain arrays: {error}.") from None
    if arrays.keys() >= OWN:
        return _read_own(file, arrays)
    return (read_recovered if is_recovered(arrays) else read_amass)(file, arrays)


OWN = {"names", "ps_camera_joint", "time_s"}


def _read_own(file: str, arrays: Mapping[str, NDArray[Any]]) -> JointMotion:
    names, ps, times_s = arrays["names"], arrays["ps_camera_joint"], arrays["time_s"]
    if (
        names.ndim != 1
        or (times_s.ndim, ps.shape) != (1, (len(times_s), len(names), 3))
        or {ps.dtype.kind, times_s.dtype.kind} - set("fiu")
    ):
        raise FormatError(f"{file}: ps_camera_joint is not a place for each name at each time_s.")
    given = [str(name) for name in names.tolist()]
    return JointMotion.of(file, given, ps.astype(float), times_s.astype(float), "camera", "m")


def read_torch(file: str, content: bytes) -> JointMotion:
    """The motion in a file of PyTorch; FormatError in one sentence."""
    try:
        arrays = torch_arrays(content)
    except ValueError as error:
        raise FormatError(
            f"{file} is no file of tensors alone: {error}; in Python with PyTorch, save each "
            "tensor's .numpy() with numpy.savez, under names such as smpl_params_incam.transl."
        ) from None
    return read_recovered(file, arrays)


def refuse_pickle(file: str, _content: bytes) -> JointMotion:
    """FormatError."""
    raise FormatError(
        f"{file} may run code when it is read: in Python, load it yourself and save its arrays "
        "with numpy.savez, under the same names."
    )
