"""Read poses of SMPL, SMPL-H and SMPL-X: AMASS archives, and what networks recover from video.

Whose body it was only a licensed model could give, from `betas`. Joints are where a body of our own
has them in these poses, unless the file brings its `rest_joints`, as one written here does. The
first 22 joints of all three models are the same; the others, of face and hands, are left out.

GVHMR, GEM: a PyTorch file, or an archive made of one, with `global_orient`, `body_pose` and
`transl` under `smpl_params_incam`, in the camera's frame, and `smpl_params_global`, y up; or under
`body_params_…`. WHAM: `pose`, `trans`, beside `pose_world`, in the camera's frame, with the
frames that they are of in `frame_ids`.
Camera frames are as ours, x right, y down, z away, and come before the world's: a session's motion
is in its camera's frame. The person's own lengths only a licensed model could give: the poses are
played on a body of ours, as those of AMASS are. The models put their own origin, and not the
pelvis, at `transl`, some 20 to 35 cm from it by whichever model it was: the keyframes mend that.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import preset
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.joint_motion import MOST_FRAMES, JointMotion, Unit, World, require_size
from keypose.tracker.formats.smpl import JOINTS, joints_of, rest_joints, smpl_of
from keypose.tracker.formats.torch_archive import torch_arrays
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.storage.archive import archive_arrays

AMASS_RATES = ("mocap_framerate", "mocap_frame_rate")
"""What older and newer files call frames a second."""

BODY = "adult_male"
COUNT = len(JOINTS)


def read_amass(file: str, arrays: Mapping[str, NDArray[Any]]) -> JointMotion:
    """The motion in an archive's arrays; FormatError in one sentence."""
    rate_name = next((name for name in AMASS_RATES if name in arrays), None)
    if rate_name is None or not {"poses", "trans"} <= arrays.keys():
        raise FormatError(
            f"{file} is no AMASS file: those have poses, trans and mocap_framerate in them."
        )
    poses = _poses(file, arrays["poses"])
    trans = _archive_numbers(
        file, "trans", arrays["trans"], (len(poses), 3), "a place for each pose"
    )
    rate = float(_archive_numbers(file, rate_name, arrays[rate_name], (), "frames a second"))
    if not 1e-4 < rate < 1e6:
        raise FormatError(f"{file}: its {rate_name} should be frames a second.")
    times_s: Array = np.arange(len(poses)) / rate
    ps = joints_of(_rest(file, arrays), exp_rotation(poses), trans)
    unit: Unit | None = "m" if "rest_joints" in arrays else None  # else lengths are ours
    return JointMotion.of(file, list(JOINTS), ps, times_s, "z up", unit)


def _poses(file: str, array: NDArray[Any]) -> Array:
    """(N, 22, 3) rotation vectors, of the first joints of as many as there are."""
    count = math.prod(array.shape[1:]) // 3
    if array.ndim < 2 or count < COUNT:
        raise FormatError(
            f"{file}: its poses should be three numbers for each of {COUNT} joints or more."
        )
    require_size(file, len(array), COUNT)
    rows = array.reshape(len(array), -1)
    poses = _archive_numbers(
        file, "poses", rows, (len(rows), 3 * count), "three numbers for each joint"
    )
    return poses.reshape(-1, count, 3)[:, :COUNT]


def _rest(file: str, arrays: Mapping[str, NDArray[Any]]) -> Array:
    """(22, 3) where joints rest, metres."""
    if "rest_joints" not in arrays:
        return rest_joints(smpl_of(Skeleton.of(preset(BODY))))
    rest = arrays["rest_joints"]
    return _archive_numbers(file, "rest_joints", rest, (COUNT, 3), f"the places of {COUNT} joints")


def _archive_numbers(
    file: str, name: str, values: NDArray[Any], shape: tuple[int, ...], expected: str
) -> Array:
    """An array as it should be; one number may be an array of one, too."""
    if values.dtype.kind not in "fiu" or not np.isfinite(values).all():
        raise FormatError(f"{file} has something else than finite numbers in its {name}.")
    if values.size != math.prod(shape) or (shape and values.shape != shape):
        raise FormatError(f"{file}: its {name} should be {expected}.")
    return values.astype(np.float64).reshape(shape)


Arrays = Mapping[str, NDArray[Any]]

WORLDS: Final[dict[str, World | None]] = {
    "smpl_params_incam": "camera",
    "body_params_incam": "camera",
    "smpl_params_global": "y up",
    "body_params_global": "y up",
    "": None,
}
"""By the name that parameters are under, the first one present being read."""
FIELDS: Final = ("global_orient", "body_pose", "transl")
WHAM: Final = ("pose", "trans")
RECOVERED_RATES: Final = ("fps", "mocap_framerate", "mocap_frame_rate")
TILTED: Final = 1e-2
"""How far from orthonormal rotation matrices may be."""
MORE: Final = len(JOINTS) - 1
"""Joints after the pelvis."""


class _Params(NamedTuple):
    """orient (N, …), body (N, …) as rotation vectors or matrices, transl (N, 3)."""

    world: World | None
    orient: NDArray[Any]
    body: NDArray[Any]
    transl: NDArray[Any]


def is_recovered(names: Iterable[str]) -> bool:
    """Whether arrays of these names are of such a network."""
    plain = {_apart(name)[-1] for name in names}
    return plain >= set(FIELDS) or plain >= {*WHAM, "pose_world"}


def read_recovered(file: str, arrays: Arrays) -> JointMotion:
    """The motion in arrays by their names; FormatError in one sentence."""
    params = _params(file, arrays)
    trans = _numbers(file, "transl", params.transl)
    if trans.ndim != 2 or trans.shape[1] != 3:
        raise FormatError(f"{file}: its transl should be a place for each pose.")
    count = len(trans)
    require_size(file, count, len(JOINTS))
    orient = _rotations(file, "global_orient", params.orient, count)[:, :1]
    body = _rotations(file, "body_pose", params.body, count)
    if body.shape[1] < MORE or not orient.shape[1]:
        raise FormatError(f"{file}: its body_pose has {body.shape[1]} joints; {MORE} are expected.")
    Rs = np.concatenate([orient, body[:, :MORE]], axis=1)
    ps = joints_of(rest_joints(smpl_of(Skeleton.of(preset(BODY)))), Rs, trans)
    ps = _by_frame(file, ps, arrays.get("frame_ids"))
    rate = _rate(file, arrays)
    times: Array = np.arange(len(ps)) / (rate or 1.0)
    motion = JointMotion.of(file, list(JOINTS), ps, times, params.world, None)
    return motion if rate is not None else motion.per_frame(file)


def _apart(name: str) -> tuple[str, str]:
    """What an array is under, and its own name."""
    under, _, own = name.replace("/", ".").rpartition(".")
    return under, own


def _params(file: str, arrays: Arrays) -> _Params:
    fields_of_person: dict[str, dict[str, NDArray[Any]]] = {}
    for name, values in arrays.items():
        under, own = _apart(name)
        fields_of_person.setdefault(under, {})[own] = values
    for under, world in WORLDS.items():
        fields = fields_of_person.get(under, {})
        if all(field in fields for field in FIELDS):
            return _Params(world, *(fields[field] for field in FIELDS))
    fields = fields_of_person.get("", {})
    if all(field in fields for field in WHAM):
        pose = fields["pose"]
        if pose.ndim != 2 or pose.shape[1] < 3 * (MORE + 1):
            raise FormatError(f"{file}: its pose should be three numbers for each of its joints.")
        return _Params(
            "camera" if "pose_world" in fields else None, pose[:, :3], pose[:, 3:], fields["trans"]
        )
    raise FormatError(f"{file} has no {', '.join(FIELDS)} of one motion in it.")


def _rotations(file: str, name: str, array: NDArray[Any], count: int) -> Array:
    """(N, J, 3, 3) from matrices or rotation vectors, however many joints there are."""
    values = _numbers(file, name, array)
    if len(values) != count:
        raise FormatError(f"{file} has {len(values)} poses in {name} and {count} in transl.")
    if values.shape[-2:] == (3, 3):
        Rs = values.reshape(count, -1, 3, 3)
        if np.abs(Rs @ Rs.swapaxes(-1, -2) - np.eye(3)).max(initial=0.0) > TILTED:
            raise FormatError(f"{file}: its {name} has matrices that are no rotations.")
        return Rs
    if values[0].size % 3:
        raise FormatError(f"{file}: its {name} should be three numbers for each joint.")
    return exp_rotation(values.reshape(count, -1, 3))


def _numbers(file: str, name: str, values: NDArray[Any]) -> Array:
    """Without a first axis of one, as a batch has it."""
    if values.dtype.kind not in "fiu" or not np.isfinite(values).all():
        raise FormatError(f"{file} has something else than finite numbers in its {name}.")
    if values.ndim > 2 and values.shape[0] == 1:
        values = values[0]
    if values.ndim < 2 or not values.size:
        raise FormatError(f"{file}: its {name} should be numbers for each pose.")
    return values.astype(np.float64)


def _by_frame(file: str, ps: Array, frames: NDArray[Any] | None) -> Array:
    """Spread rows over every frame from 0 to the last, NaN where there is no pose."""
    if frames is None:
        return ps
    rows = np.asarray(frames).ravel()
    whole = rows.dtype.kind in "iu" and len(rows) == len(ps) and (np.diff(rows) > 0).all()
    if not whole or rows[0] < 0 or rows[-1] >= MOST_FRAMES:
        raise FormatError(f"{file}: its frame_ids should ascend, one for each pose.")
    require_size(file, int(rows[-1]) + 1, len(JOINTS))
    out = np.full((int(rows[-1]) + 1, *ps.shape[1:]), np.nan)
    out[rows] = ps
    return out


def _rate(file: str, arrays: Arrays) -> float | None:
    name = next((name for name in RECOVERED_RATES if name in arrays), None)
    if name is None:
        return None
    values = arrays[name]
    rate = float(values.ravel()[0]) if values.size == 1 and values.dtype.kind in "fiu" else np.nan
    if not 1e-4 < rate < 1e6:
        raise FormatError(f"{file}: its {name} should be frames a second.")
    return rate


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
    joint_names = [str(name) for name in names.tolist()]
    return JointMotion.of(file, joint_names, ps.astype(float), times_s.astype(float), "camera", "m")


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
