"""A first trajectory from templates and planar limbs, as published (INITIAL §3).

Hips, head, hands and feet are followed from the first keyframe to the last one by what they look
like. The motion is taken to lie in a plane parallel to the picture: the hips carry the body, the
head leans the trunk, and every arm and leg is a planar chain of two links. What that leaves open,
such as all depths, is interpolated between the keyframes; both keyframes are met exactly.

INITIAL does not say what carries the body, nor how its templates cope with parts that turn. Ours
turn with the limb that carries them, as the chain predicts.
"""

from __future__ import annotations

from collections.abc import Collection

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array, exp_rotation, log_rotation, transpose
from keypose.tracker.tracking.initial.templates import Start
from keypose.tracker.tracking.initial.templates.first_keyframe import FirstKeyframe, NotFollowed
from keypose.tracker.tracking.initial.templates.tracks import (
    TwoLinks,
    is_left_out,
    leaves,
    middle,
    two_link_limbs,
)
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment

LEAST_FLAT = 0.5
LEAST_ALIKE = 0.7
"""Seen length of a limb as a share of its true one, and of one keyframe's as a share of the
other's, below which it does not move in the picture's plane."""
REACH_SHARE = 0.07
LEAST_REACH = 8
"""How far beside its expected place a part is looked for, as a share of its limb's length in the
picture, and at least, pixels."""
BEYOND = 1.15
MOST_BEYOND = 0.2
"""A place further off than this share of a limb's length is beyond its reach; at most this share
of all frames may be."""
INSTEAD = "interpolated instead"


def two_link_angles(p: Array, L1: Array | float, L2: Array | float) -> tuple[Array, Array]:
    """The angles (…) of two links whose end lies at p (…, 2), the second at the joint angle θ2 ≥ 0.

    A position out of reach is replaced by the nearest one within.  INITIAL §3.2
    """
    x, y = p[..., 0], p[..., 1]
    cosine = (x**2 + y**2 - L1**2 - L2**2) / (2 * L1 * L2)
    bend = np.arccos(np.clip(cosine, -1.0, 1.0))
    first = np.arctan2(y, x) - np.arctan2(L2 * np.sin(bend), L1 + L2 * np.cos(bend))
    return np.asarray(first), np.asarray(bend)


def planar_start(scene: Scene, segment: Segment, left_out: Collection[str] = ()) -> Start:
    """The first trajectory, and what of the body could not be followed.

    left_out: names of parts; the limb of each is interpolated.
    """
    interpolated = segment.interpolated()
    limbs = two_link_limbs(scene.skeleton)
    if not limbs:
        return Start(interpolated, (f"the body has no limbs of two links: {INSTEAD}",))
    keyed = FirstKeyframe.of(scene, segment)
    guided, notes = _carry_root(keyed, interpolated, _head(scene, limbs), left_out)
    Rs, ps = guided.writable()
    for limb in limbs:
        if is_left_out(scene.skeleton, limb.leaf, left_out):
            continue
        try:
            Rs[:, limb.upper], Rs[:, limb.lower] = _as_rotations(
                scene, guided, limb, _angles(keyed, guided, limb)
            )
        except NotFollowed as reason:
            notes.append(f"{reason}: {INSTEAD}")
    Rs[0], Rs[-1] = segment.start.Rs_parent_part, segment.end.Rs_parent_part
    return Start(Trajectory(interpolated.first_frame, Rs, ps), tuple(notes))


def _head(scene: Scene, limbs: list[TwoLinks]) -> int | None:
    """The first leaf that ends no limb of two links and does not hang from the root itself."""
    ends = [limb.leaf for limb in limbs]
    parents = scene.skeleton.parents
    return next((i for i in leaves(scene.skeleton) if i not in ends and parents[i] > 0), None)


def _carry_root(
    keyed: FirstKeyframe, motion: Trajectory, head: int | None, left_out: Collection[str]
) -> tuple[Trajectory, list[str]]:
    """Interpolation with the root carried by the hips and the trunk leant by the head.

    Without the hips the head carries the root, and the trunk leans as interpolated.
    """
    notes, has_hips = [], False
    if not is_left_out(keyed.scene.skeleton, 0, left_out):
        try:
            motion = _shift_in_picture(keyed.scene, motion, _offset_px(keyed, motion, 0))
            has_hips = True
        except NotFollowed as reason:
            notes.append(f"{reason}: {INSTEAD if head is None else 'carried by the head instead'}")
    if head is None or is_left_out(keyed.scene.skeleton, head, left_out):
        return motion, notes
    try:
        offset = _offset_px(keyed, motion, head)
    except NotFollowed as reason:
        return motion, [*notes, f"{reason}: {INSTEAD}"]
    if has_hips:
        return _lean_trunk(keyed, motion, head, offset), notes
    return _shift_in_picture(keyed.scene, motion, offset), notes


def _offset_px(keyed: FirstKeyframe, motion: Trajectory, part: int) -> Array:
    """(N, 2) pixels by which a part is seen away from where a motion has it; zero at the ends."""
    expected = keyed.scene.point_pixels(motion, part, middle(keyed.scene.skeleton, part))
    template = keyed.template(part, expected[0])
    followed_uv = keyed.track(part, template, lambda n, uv: 0.0, expected[-1], LEAST_REACH)
    return np.asarray(followed_uv - expected)


def _shift_in_picture(scene: Scene, motion: Trajectory, uv: Array) -> Trajectory:
    """A motion whose root is shifted parallel to the picture, by pixels (N, 2)."""
    Rs, ps = motion.writable()
    metres = scene.camera.depth(ps)[1:-1, None] / (scene.camera.fx, scene.camera.fy)
    ps[1:-1, :2] += uv[1:-1] * metres
    return Trajectory(motion.first_frame, Rs, ps)


def _lean_trunk(keyed: FirstKeyframe, motion: Trajectory, head: int, offset: Array) -> Trajectory:
    """The part that the head hangs from, next to the root, turned until the head is in place."""
    skeleton = keyed.scene.skeleton
    trunk = head
    while skeleton.parents[trunk] > 0:
        trunk = int(skeleton.parents[trunk])
    pivot = keyed.scene.point_pixels(motion, trunk, np.zeros(3))
    was = keyed.scene.point_pixels(motion, head, middle(skeleton, head)) - pivot
    turn = _wrapped(_angle(was + offset) - _angle(was))
    Ts = motion.transforms(skeleton)
    above = Ts[:, skeleton.parents[trunk], :3, :3]
    Rs, ps = motion.writable()
    Rs[:, trunk] = transpose(above) @ _about_view(turn) @ Ts[:, trunk, :3, :3]
    return Trajectory(motion.first_frame, Rs, ps)


def _angles(keyed: FirstKeyframe, guided: Trajectory, limb: TwoLinks) -> tuple[Array, Array]:
    """(N,) how the upper and the lower link point in the picture, radians from u towards v.

    The lengths are those seen in the keyframes. θ2 is taken positive with the picture's v axis
    pointing the way that makes the keyframes' own bends so.
    """
    hip, first, second = _links(keyed, guided, limb)
    L1, L2 = (_linear(np.linalg.norm(d[[0, -1]], axis=-1), len(d)) for d in (first, second))
    ends = [_angle(d[[0, -1]]) for d in (first, second)]
    if not _is_planar(keyed.scene, guided, limb, L1[[0, -1]], L2[[0, -1]]):
        raise NotFollowed(f"{keyed.name(limb.leaf)} does not move in the picture's plane")
    sense = 1.0 if np.sin(ends[1] - ends[0]).sum() >= 0 else -1.0

    def pointing(n: NDArray[np.int64] | int, uv: Array) -> tuple[Array, Array]:
        theta1, theta2 = two_link_angles((uv - hip[n]) * (1.0, sense), L1[n], L2[n])
        return sense * theta1, sense * (theta1 + theta2)

    def turn_at(n: int, uv: Array) -> float:
        return float(pointing(n, uv)[1] - ends[1][0])

    keyed_at = hip + first + second
    template = keyed.template(limb.leaf, keyed_at[0], also=[limb.lower])
    reach = int(max(LEAST_REACH, REACH_SHARE * (L1 + L2).max()))
    uv = keyed.track(limb.leaf, template, turn_at, keyed_at[-1], reach)
    beyond = np.linalg.norm(uv - hip, axis=-1) > BEYOND * (L1 + L2)
    if beyond.mean() > MOST_BEYOND:
        raise NotFollowed(f"{keyed.name(limb.leaf)} reaches further than in the picture's plane")
    upper, lower = pointing(np.arange(len(uv)), uv)
    return _meet_ends(upper, ends[0]), _meet_ends(lower, ends[1])


def _links(keyed: FirstKeyframe, motion: Trajectory, limb: TwoLinks) -> tuple[Array, Array, Array]:
    """In the picture, (N, 2), where a limb begins, and its upper and lower link."""
    origin = np.zeros(3)
    hip = keyed.scene.point_pixels(motion, limb.upper, origin)
    knee = keyed.scene.point_pixels(motion, limb.lower, origin)
    return hip, knee - hip, keyed.scene.point_pixels(motion, limb.leaf, limb.p_leaf) - knee


def _is_planar(scene: Scene, motion: Trajectory, limb: TwoLinks, L1: Array, L2: Array) -> bool:
    """Whether both keyframes show both links (2,) about as long as they are."""
    Ts = motion.transforms(scene.skeleton)[[0, -1]]
    hip, knee = Ts[:, limb.upper, :3, 3], Ts[:, limb.lower, :3, 3]
    end = Ts[:, limb.leaf, :3, :3] @ limb.p_leaf + Ts[:, limb.leaf, :3, 3]
    px_per_m = np.sqrt(scene.camera.fx * scene.camera.fy) / scene.camera.depth(knee)
    flat = np.stack(
        [
            L1 / (px_per_m * np.linalg.norm(knee - hip, axis=-1)),
            L2 / (px_per_m * np.linalg.norm(end - knee, axis=-1)),
        ]
    )
    alike = flat.min(axis=1) / flat.max(axis=1)
    return bool(flat.min() > LEAST_FLAT and alike.min() > LEAST_ALIKE)


def _as_rotations(
    scene: Scene, guided: Trajectory, limb: TwoLinks, angles: tuple[Array, Array]
) -> tuple[Array, Array]:
    """(N, 3, 3) both links in their parents, turned in the picture's plane from the first keyframe.

    The miss at the last keyframe, turns out of the plane, is spread evenly.
    """
    Ts = guided.transforms(scene.skeleton)
    above, links = Ts[:, scene.skeleton.parents[limb.upper], :3, :3], []
    for part, angle in zip((limb.upper, limb.lower), angles, strict=True):
        R = _about_view(angle - angle[0]) @ Ts[0, part, :3, :3]
        rest = log_rotation(transpose(R[-1]) @ Ts[-1, part, :3, :3])
        R = R @ exp_rotation(np.linspace(0.0, 1.0, len(R))[:, None] * rest)
        links.append(transpose(above) @ R)
        above = R
    return links[0], links[1]


def _meet_ends(angle: Array, ends: Array) -> Array:
    """Angles (N,) that begin and end at the keyed ones (2,), the misses spread evenly."""
    angle = np.unwrap(angle)
    return np.asarray(angle + _linear(_wrapped(ends - angle[[0, -1]]), len(angle)))


def _linear(ends: Array, count: int) -> Array:
    return np.linspace(ends[0], ends[1], count)


def _about_view(turn: Array) -> Array:
    """(N, 3, 3) turns about the view's axis, from the picture's u axis to its v axis."""
    return exp_rotation(turn[:, None] * (0.0, 0.0, 1.0))


def _angle(d: Array) -> Array:
    return np.asarray(np.arctan2(d[..., 1], d[..., 0]))


def _wrapped(angle: Array) -> Array:
    return np.asarray((angle + np.pi) % (2 * np.pi) - np.pi)
