"""Pose every frame by itself, in closed form, and scale the proportions, from landmarks in space.

Height and distance show only together in a picture, so the body keeps its height. What the network
does give is how long bones are beside each other: its landmarks in space have the person's bones up
to one common factor. Where enough frames show a bone, its median length there is believed, drawn
toward the preset's proportions, and never beyond what people differ by. Widths of the hips stay:
the network puts hips where no joint is. So does thickness, which landmarks do not show.

A network finds where joints are in space, in axes parallel to the picture's, as if the person were
in the picture's middle, and only about as long as they are. Its bones are made as long as the
body's, turned from the camera's axis onto the ray through the hips, and put at the distance from
which the joints are seen at their pixels: that is linear.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Body
from keypose.tracker.body.modify import height, joint_moved, resized, with_height
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.fitting.draft.observed import SIDES, Joints, Limb, Observed, place_of, unit
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, nearest_rotation
from keypose.tracker.solver.fit_joints import aim_parts, rigid

SURE = 0.7
"""Visibility of both ends of a bone that is measured."""
FEWEST = 12
"""Frames from which a length is known."""
USUAL: Final = 0.08
"""Standard deviation of people's proportions about the preset's."""
DOUBT = 0.04
SHOULDER_DOUBT = 0.15
"""Those of the network's, which puts shoulders mostly too near each other."""
LARGEST: Final = 0.15
"""By which a length is changed at most, beside the others."""
_TRUNK = "trunk"
_SIZE_SHOULDERS = "shoulders"


def with_proportions(body: Body, observed: Observed) -> Body:
    """The body with trunk, shoulders, arms and legs in the person's proportions, and its height."""
    joints = Joints.of(Skeleton.of(body))
    ratios = _ratios(joints, observed)
    known_ratios = [ratio for ratio in ratios.values() if ratio is not None]
    if not known_ratios:
        return body
    common = float(np.median(known_ratios))
    factors = {
        name: _toward_preset(ratio / common, SHOULDER_DOUBT if name == _SIZE_SHOULDERS else DOUBT)
        for name, ratio in ratios.items()
        if ratio is not None
    }
    return with_height(_scaled(body, joints, factors), height(body))


def _toward_preset(factor: float, doubt: float) -> float:
    share = USUAL**2 / (USUAL**2 + doubt**2)
    return float(np.exp(np.clip(share * np.log(factor), -LARGEST, LARGEST)))


def _scaled(body: Body, joints: Joints, factors: dict[str, float]) -> Body:
    names = body.names
    for left, right in zip(joints.limbs[::2], joints.limbs[1::2], strict=True):
        for left_bone, right_bone in ((left.upper, right.upper), (left.lower, right.lower)):
            factor = factors.get(names[left_bone.part], 1.0)
            for part in (left_bone.part, right_bone.part):
                body = resized(body, names[part], length_factor=factor, linked=False)
    chest = names[joints.parts[place_of("left", "shoulder")]]
    body = resized(body, chest, length_factor=factors.get(_TRUNK, 1.0))
    for arm in joints.limbs[:2]:
        x, y, z = body.parts[arm.upper.part].joint_m
        shoulder = (x * factors.get(_SIZE_SHOULDERS, 1.0), y, z)
        body = joint_moved(body, names[arm.upper.part], shoulder, linked=False)
    return body


def _ratios(joints: Joints, observed: Observed) -> dict[str, float | None]:
    """By part, and of trunk and shoulders, its length in the landmarks over the body's; None
    where too few frames show it.
    """
    names = joints.skeleton.body.names
    ratios = {}
    for left, right in zip(joints.limbs[::2], joints.limbs[1::2], strict=True):
        for left_bone, right_bone in ((left.upper, right.upper), (left.lower, right.lower)):
            lengths = [_lengths(observed, bone.near, bone.far) for bone in (left_bone, right_bone)]
            ratios[names[left_bone.part]] = _median(
                np.concatenate(lengths), joints.seen_length_m(left_bone)
            )
    ratios[_TRUNK] = _trunk_lengths(joints, observed)
    a, b = (place_of(side, "shoulder") for side in SIDES)
    p = joints.seen.at(
        pose_transforms(joints.skeleton, Pose.rest(joints.skeleton, (0.0, 0.0, 0.0)))
    )
    ours = float(np.linalg.norm(p[a] - p[b]))
    ratios[_SIZE_SHOULDERS] = _median(_lengths(observed, a, b), ours)
    return ratios


def _trunk_lengths(joints: Joints, observed: Observed) -> float | None:
    """Measure from the middle of the hips to that of the shoulders."""
    hips, shoulders = ([place_of(side, name) for side in SIDES] for name in ("hip", "shoulder"))
    sure = observed.usable & (observed.visibility[:, hips + shoulders].min(axis=1) >= SURE)
    p = observed.p_hips[sure]
    own = np.linalg.norm(p[:, shoulders].mean(1) - p[:, hips].mean(1), axis=-1)
    ours = np.linalg.norm(joints.rest[shoulders].mean(0) - joints.rest[hips].mean(0))
    return _median(own, float(ours))


def _lengths(observed: Observed, near: int, far: int) -> Array:
    sure = observed.usable & (observed.visibility[:, [near, far]].min(axis=1) >= SURE)
    p = observed.p_hips[sure]
    return np.asarray(np.linalg.norm(p[:, far] - p[:, near], axis=-1))


def _median(lengths: Array, ours: float) -> float | None:
    return float(np.median(lengths)) / ours if len(lengths) >= FEWEST else None


NEAREST_M = 0.3
"""A body is not put nearer to the camera."""
STRAIGHT = 0.05
"""How much the hinge's plane is held to that of the least turn: it decides for a straight limb."""
ROUNDS = 3
FAR = 2.0
"""Robust rounds of placing; joints farther off than so many times the median count less."""
LEAST_PX = 1e-3
"""Nothing is seen more exactly."""
_HIPS = [place_of(side, "hip") for side in SIDES]
_SHOULDERS = [place_of(side, "shoulder") for side in SIDES]


def first_pose(joints: Joints, camera: Camera, uv: Array, sure: Array, p_hips: Array) -> Pose:
    """The pose of one frame.

    camera: without distortion.  uv (12, 2), sure (12,) weights from 0 to 1, p_hips (12, 3): finite
    where sure is not 0.
    """
    bones = _with_lengths_of(joints, p_hips)
    p = bones @ landmark_axes(camera, uv, sure > 0).T
    p = p + placed(camera, p, uv, sure)
    return _posed(joints, p)


def _with_lengths_of(joints: Joints, p_hips: Array) -> Array:
    """(12, 3) the landmarks with bones in their directions and of the body's lengths; the middle
    of the body's hips is at 0."""
    p, rest = p_hips, joints.rest
    out = np.zeros_like(p)
    for pair, middle in ((_HIPS, np.zeros(3)), (_SHOULDERS, _trunk(joints, p))):
        half = 0.5 * float(np.linalg.norm(rest[pair[0]] - rest[pair[1]]))
        across = unit(p[pair[0]] - p[pair[1]])
        out[pair[0]], out[pair[1]] = middle + half * across, middle - half * across
    for bone in joints.bones:
        out[bone.far] = out[bone.near] + joints.length_m(bone) * unit(p[bone.far] - p[bone.near])
    return out


def _trunk(joints: Joints, p: Array) -> Array:
    """The vector from the middle of the hips to that of the shoulders, as long as on the
    body.
    """
    ours = joints.rest[_SHOULDERS].mean(0) - joints.rest[_HIPS].mean(0)
    theirs = p[_SHOULDERS].mean(0) - p[_HIPS].mean(0)
    return float(np.linalg.norm(ours)) * unit(theirs)


def landmark_axes(camera: Camera, uv: Array, is_known: NDArray[np.bool_]) -> Array:
    """(3, 3) the axes of a frame's landmarks in the camera: a network has a person as if in the
    middle of the picture. uv (K, 2), is_known (K,): of its points."""
    return _onto_ray(camera, uv[_HIPS].mean(0) if is_known[_HIPS].all() else uv[is_known].mean(0))


def _onto_ray(camera: Camera, uv: Array) -> Array:
    """The rotation that turns the camera's axis onto the ray through a pixel, x kept level."""
    if camera.telephoto_distance_m is not None:
        return np.eye(3)
    z = unit(camera.back_project(uv, 1.0))
    x = unit(np.cross((0.0, 1.0, 0.0), z))
    return np.stack([x, np.cross(z, x), z], axis=1)


def placed(camera: Camera, p: Array, uv: Array, sure: Array) -> Array:
    """(3,) the shift that puts points p (K, 3) where they are seen at pixels uv (K, 2).

    u · (z + t_z) = f · (x + t_x) + c · (z + t_z) is linear in t; robust by reweighting.
    """
    weight = np.sqrt(sure)
    for _ in range(ROUNDS):
        t = _linear_place(camera, p, uv, weight)
        away = np.linalg.norm(_project(camera, p + t) - uv, axis=-1)
        usual = max(float(np.median(away[sure > 0])), LEAST_PX)
        weight = np.sqrt(sure * np.minimum(1.0, FAR * usual / np.maximum(away, 1e-9)))
    return t


def _linear_place(camera: Camera, p: Array, uv: Array, weight: Array) -> Array:
    ray = (uv - (camera.cx, camera.cy)) / (camera.fx, camera.fy)
    if camera.telephoto_distance_m is not None:
        distance = camera.telephoto_distance_m
        shift = (weight[:, None] ** 2 * (ray * distance - p[:, :2])).sum(0) / (weight**2).sum()
        return np.array([*shift, distance])
    A, b = np.zeros((len(p), 2, 3)), p[:, 2:] * ray - p[:, :2]
    A[:, 0, 0] = A[:, 1, 1] = 1.0
    A[:, :, 2] = -ray
    A, b = A * weight[:, None, None], b * weight[:, None]
    t = np.linalg.lstsq(A.reshape(-1, 3), b.ravel(), rcond=None)[0]
    nearest = NEAREST_M - float(p[:, 2].min())
    return np.array([t[0], t[1], max(float(t[2]), nearest)])


def _project(camera: Camera, p: Array) -> Array:
    z = np.maximum(camera.depth(p), 1e-3)[:, None]
    return np.asarray(p[:, :2] / z * (camera.fx, camera.fy) + (camera.cx, camera.cy))


def _posed(joints: Joints, p: Array) -> Pose:
    """The body with its joints toward points p (12, 3): the trunk as a whole, then every part."""
    skeleton, trunk = joints.skeleton, [*_HIPS, *_SHOULDERS]
    R, t = rigid(joints.rest[trunk], p[trunk])
    Rs = np.tile(np.eye(3), (skeleton.part_count, 1, 1))
    Rs[0] = R
    aimed = aim_parts(joints.points, p, Pose(Rs, t))
    return _with_hinges(joints, p, aimed)


def _with_hinges(joints: Joints, p: Array, pose: Pose) -> Pose:
    """Turn upper arms and thighs about themselves so that elbows and knees bend as hinges do."""
    H = pose_transforms(joints.skeleton, pose)[:, :3, :3]
    Rs = pose.Rs_parent_part.copy()
    for limb in joints.limbs:
        upper, lower = hinged(limb, p, H[limb.upper.part])
        above = H[joints.skeleton.parents[limb.upper.part]]
        Rs[limb.upper.part] = nearest_rotation(above.T @ upper)
        Rs[limb.lower.part] = nearest_rotation(upper.T @ lower)
    return Pose(Rs, pose.p_camera_root)


def hinged(limb: Limb, p: Array, H: Array) -> tuple[Array, Array]:
    """The orientations (..., 3, 3) of both parts of a limb with joints at p (..., 12, 3).

    H (..., 3, 3): of the upper part, which decides how it is turned about itself where the limb is
    straight.
    """
    along = unit(p[..., limb.upper.far, :] - p[..., limb.upper.near, :])
    beyond = unit(p[..., limb.lower.far, :] - p[..., limb.lower.near, :])
    # as long as the sine of the bend
    across = beyond - (beyond * along).sum(-1, keepdims=True) * along
    x, y = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    bends_to = np.array(limb.bends_to)
    upper = nearest_rotation(_outer(along, y) + _outer(across, bends_to) + STRAIGHT * H)
    lower = nearest_rotation(_outer(beyond, y) + _outer(upper[..., 0], x))
    return upper, lower


def _outer(a: Array, b: Array) -> Array:
    return np.asarray(a[..., :, None] * b)
