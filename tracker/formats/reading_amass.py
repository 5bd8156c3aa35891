"""AMASS archives in: poses of SMPL, SMPL-H or SMPL-X, played on a rest pose of ours.

Whose body it was only a licensed model could give, from `betas`. Joints are where a body of our own
has them in these poses, unless the file brings its `rest_joints`, as one written here does. The
first 22 joints of all three models are the same; the others, of face and hands, are left out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import preset
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.joint_motion import JointMotion, Unit, require_size
from keypose.tracker.formats.smpl import JOINTS, joints_of, rest_joints, smpl_of
from keypose.tracker.geometry.rotations import Array, exp_rotation

RATES = ("mocap_framerate", "mocap_frame_rate")
"""What older and newer files call frames a second."""

BODY = "adult_male"
COUNT = len(JOINTS)


def read_amass(file: str, arrays: Mapping[str, NDArray[Any]]) -> JointMotion:
    """The motion in an archive's arrays; FormatError in one sentence."""
    rate_name = next((name for name in RATES if name in arrays), None)
    if rate_name is None or not {"poses", "trans"} <= arrays.keys():
        raise FormatError(
            f"{file} is no AMASS file: those have poses, trans and mocap_framerate in them."
        )
    poses = _poses(file, arrays["poses"])
    trans = _numbers(file, "trans", arrays["trans"], (len(poses), 3), "a place for each pose")
    rate = float(_numbers(file, rate_name, arrays[rate_name], (), "frames a second"))
    if not 1e-4 < rate < 1e6:
        raise FormatError(f"{file}: its {rate_name} should be frames a second.")
    times_s: Array = np.arange(len(poses)) / rate
    ps = joints_of(_rest(file, arrays), exp_rotation(poses), trans)
    unit: Unit | None = "m" if "rest_joints" in arrays else None  # else lengths are ours
    return JointMotion.of(file, list(JOINTS), ps, times_s, "z up", unit)


def _poses(file: str, given: NDArray[Any]) -> Array:
    """(N, 22, 3) rotation vectors, of the first joints of as many as there are."""
    count = math.prod(given.shape[1:]) // 3
    if given.ndim < 2 or count < COUNT:
        raise FormatError(
            f"{file}: its poses should be three numbers for each of {COUNT} joints or more."
        )
    require_size(file, len(given), COUNT)
    rows = given.reshape(len(given), -1)
    poses = _numbers(file, "poses", rows, (len(rows), 3 * count), "three numbers for each joint")
    return poses.reshape(-1, count, 3)[:, :COUNT]


def _rest(file: str, arrays: Mapping[str, NDArray[Any]]) -> Array:
    """(22, 3) where joints rest, metres."""
    if "rest_joints" not in arrays:
        return rest_joints(smpl_of(Skeleton.of(preset(BODY))))
    rest = arrays["rest_joints"]
    return _numbers(file, "rest_joints", rest, (COUNT, 3), f"the places of {COUNT} joints")


def _numbers(
    file: str, name: str, values: NDArray[Any], shape: tuple[int, ...], what: str
) -> Array:
    """An array as it should be; one number may be an array of one, too."""
    if values.dtype.kind not in "fiu" or not np.isfinite(values).all():
        raise FormatError(f"{file} has something else than finite numbers in its {name}.")
    if values.size != math.prod(shape) or (shape and values.shape != shape):
        raise FormatError(f"{file}: its {name} should be {what}.")
    return values.astype(np.float64).reshape(shape)
