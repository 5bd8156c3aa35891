"""Motion in, as networks recover it from video: poses of SMPL or SMPL-X, one for each frame.

GVHMR, GEM: a PyTorch file, or an archive made of one, with `global_orient`, `body_pose` and
`transl` under `smpl_params_incam`, in the camera's frame, and `smpl_params_global`, y up; or under
`body_params_…`. WHAM: `pose`, `trans`, beside `pose_world`, in the camera's frame, with the
frames that they are of in `frame_ids`.
Camera frames are as ours, x right, y down, z away, and come before the world's: a session's motion
is in its camera's frame. The person's own lengths only a licensed model could give: the poses are
played on a body of ours, as in `reading_amass`. The models put their own origin, and not the
pelvis, at `transl`, some 20 to 35 cm from it by whichever model it was: the keyframes mend that.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import preset
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.joint_motion import MOST_FRAMES, JointMotion, World, require_size
from keypose.tracker.formats.reading_amass import BODY
from keypose.tracker.formats.smpl import JOINTS, joints_of, rest_joints, smpl_of
from keypose.tracker.geometry.rotations import Array, exp_rotation

Arrays = Mapping[str, NDArray[Any]]

WORLDS: Final[dict[str, World | None]] = {
    "smpl_params_incam": "camera", "body_params_incam": "camera",
    "smpl_params_global": "y up", "body_params_global": "y up", "": None,
}  # fmt: skip
"""By the name that parameters are under, the first one present being read."""
FIELDS: Final = ("global_orient", "body_pose", "transl")
WHAM: Final = ("pose", "trans")
RATES: Final = ("fps", "mocap_framerate", "mocap_frame_rate")
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
    found: dict[str, dict[str, NDArray[Any]]] = {}
    for name, values in arrays.items():
        under, own = _apart(name)
        found.setdefault(under, {})[own] = values
    for under, world in WORLDS.items():
        given = found.get(under, {})
        if all(field in given for field in FIELDS):
            return _Params(world, *(given[field] for field in FIELDS))
    given = found.get("", {})
    if all(field in given for field in WHAM):
        pose = given["pose"]
        if pose.ndim != 2 or pose.shape[1] < 3 * (MORE + 1):
            raise FormatError(f"{file}: its pose should be three numbers for each of its joints.")
        return _Params(
            "camera" if "pose_world" in given else None, pose[:, :3], pose[:, 3:], given["trans"]
        )
    raise FormatError(f"{file} has no {', '.join(FIELDS)} of one motion in it.")


def _rotations(file: str, name: str, given: NDArray[Any], count: int) -> Array:
    """(N, J, 3, 3) from matrices or rotation vectors, however many joints there are."""
    values = _numbers(file, name, given)
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
    """With a row for every frame from 0 to the last, NaN where there is no pose."""
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
    name = next((name for name in RATES if name in arrays), None)
    if name is None:
        return None
    values = arrays[name]
    rate = float(values.ravel()[0]) if values.size == 1 and values.dtype.kind in "fiu" else np.nan
    if not 1e-4 < rate < 1e6:
        raise FormatError(f"{file}: its {name} should be frames a second.")
    return rate
