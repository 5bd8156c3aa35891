"""Judge whether an imported motion can be what it seems to be.

A small joint error proves little: few joints are met by any body. Sizes are compared bone by bone,
and what is unlikely is noted or, where the rest would be invented, refused.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import TypeAlias

import numpy as np

from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.joint_motion import World
from keypose.tracker.formats.text import Note
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.fit_joints import JointFit, rigid
from keypose.tracker.solver.posed import BodyPoint, BodyPoints

LEAST_DETERMINED = 0.5
"""Least share of inner parts, which carry others, that the file's joints must show the turns of."""
POOR = 0.04
"""Joint error, as a share of the body's extent, above what other people's proportions give."""
UNLIKE = 1.6
"""Ratio of a bone's length to the body's, over the median of all bones, that is plausible."""
FLAT = 0.005
"""Thickness of a motion, as a share of its extent, below which it has no depth."""
LYING_DEG = 60.0
UPRIGHT = 0.7
"""Cosine to an axis of what points along it."""
Bones: TypeAlias = dict[tuple[int, int], tuple[float, float]]
"""Pairs of places at a fixed distance: metres on the body, and the ratio to the file's length."""
_UP_AT_REST = np.array([0.0, -1.0, 0.0])


def require_limbs(skeleton: Skeleton, places: Sequence[BodyPoint], file: str) -> None:
    """FormatError where the places say too little of how the body's parts turn."""
    inner, undetermined = _inner(skeleton), _undetermined(skeleton, places)
    if len(inner) - len(undetermined) < LEAST_DETERMINED * len(inner):
        raise FormatError(
            f"{file}: of its joints {len(places)} are known, too few to say how the body's "
            f"{len(skeleton.body.parts)} parts move: name the places of more."
        )


def _inner(skeleton: Skeleton) -> list[int]:
    """Parts that carry another one, but for the neck; of a body of one part that one."""
    carrying = sorted({int(p) for p in skeleton.parents if p >= 0} or {0})
    return [part for part in carrying if skeleton.body.names[part] != "neck"]


def _undetermined(skeleton: Skeleton, places: Sequence[BodyPoint]) -> list[int]:
    """Inner parts whose turning moves none of the places."""
    moving: set[int] = set()
    for place in places:
        for part, p in place:
            moving |= {part} if any(p) else set()
            while (part := int(skeleton.parents[part])) >= 0:
                moving.add(part)
    return [part for part in _inner(skeleton) if part not in moving]


def _middles(skeleton: Skeleton, places: Sequence[BodyPoint]) -> list[int]:
    """Parts in the middle of a limb, such as a shin, at whose joint no place is."""
    children = np.bincount(skeleton.parents[skeleton.parents >= 0], minlength=skeleton.part_count)
    placed = {place[0][0] for place in places if len(place) == 1 and not any(place[0][1])}
    return [
        part
        for part in _inner(skeleton)
        if part not in placed
        and children[part] == 1
        and (parent := int(skeleton.parents[part])) >= 0
        and children[parent] == 1
    ]


# --- size


def bone_ratios(points: BodyPoints, ps: Array) -> Bones:
    """Compare bones with a file's positions (N, J, 3); tips of limbs only where nothing else is
    known."""
    ratios: Bones = {}
    tips: Bones = {}
    for part in range(points.skeleton.part_count):
        for (j, a), (k, b) in combinations(points.of_part(part), 2):
            lengths = np.linalg.norm(ps[:, j] - ps[:, k], axis=-1)
            lengths = lengths[np.isfinite(lengths)]
            ours = float(np.linalg.norm(a - b))
            if not len(lengths) or min(ours, float(np.median(lengths))) < 1e-9:
                continue
            are_joints = not np.any(points.points[j][0][1]) and not np.any(points.points[k][0][1])
            (ratios if are_joints else tips)[j, k] = (ours, ours / float(np.median(lengths)))
    return ratios or (tips if len(tips) > 1 else {})


def median_ratio(bones: Bones) -> float:
    """The median of the ratios, each counted by its bone's length; 1 without any."""
    if not bones:
        return 1.0
    lengths, ratios = np.array(list(bones.values())).T
    order = np.argsort(ratios)
    share = (np.cumsum(lengths[order]) - lengths[order] / 2) / lengths.sum()
    return float(np.interp(0.5, share, ratios[order]))


# --- what is up


def world_at_rest(
    points: BodyPoints, world: World, rest_m: Array | None, indices: Sequence[int]
) -> World:
    """The file's world, by its pose at rest where it has one and y up is only the custom."""
    if rest_m is None or world != "y up":
        return world
    rest = pose_transforms(points.skeleton, Pose.rest(points.skeleton, (0.0, 0.0, 0.0)))
    R, _ = rigid(rest_m[indices], points.at(rest))
    return "z up" if (R.T @ _UP_AT_REST)[2] > UPRIGHT else world


def lying(motion: Trajectory, up: Array) -> tuple[Note, ...]:
    """A note where the body lies nearly all the time; up (3,) in the frame of the motion."""
    up_body = motion.Rs_parent_part[:, 0] @ _UP_AT_REST
    cosine = up_body @ up / np.linalg.norm(up)
    angle = float(np.degrees(np.arccos(np.clip(np.median(cosine), -1.0, 1.0))))
    return (Note("lying", (angle,)),) if angle > LYING_DEG else ()


# --- the fitted motion


def implausible(
    skeleton: Skeleton,
    places: Sequence[BodyPoint],
    bones: Bones,
    size: float,
    ps: Array,
    fit: JointFit,
) -> tuple[Note, ...]:
    """Notes on what the joints do not tell, on proportions, on error and on depth.

    bones: of the file as it is.  size: their median ratio, by which the body is larger than they
    are.  ps (N, J, 3): joints as they were fitted.
    """
    notes: list[Note] = []
    names = skeleton.body.names
    undetermined = _undetermined(skeleton, places)
    if undetermined:
        notes.append(Note("undetermined parts", tuple(names[part] for part in undetermined)))
    unplaced = [part for part in _middles(skeleton, places) if part not in undetermined]
    if unplaced:
        notes.append(Note("unplaced joints", tuple(names[part] for part in unplaced)))
    if len(places) > 3 and _is_flat(ps):
        return (*notes, Note("flat"))  # which gives wrong proportions, and errors
    odd = {
        names[_owner(skeleton, places, pair)]: size / ratio
        for pair, (_, ratio) in bones.items()
        if not 1 / UNLIKE < ratio / size < UNLIKE
    }
    if odd:
        notes.append(Note("proportions", tuple(odd.items())))
    rms_m = float(np.sqrt(np.nanmean(fit.rms_m**2)))
    if rms_m > POOR * _extent(skeleton):
        notes.append(Note("poor fit", (100 * rms_m,)))
    return tuple(notes)


def _owner(skeleton: Skeleton, places: Sequence[BodyPoint], pair: tuple[int, int]) -> int:
    """The part that two places at a fixed distance lie on."""
    a, b = (places[j][0][0] for j in pair)
    if a == b:
        return a
    return b if skeleton.parents[a] == b else int(skeleton.parents[b])


def _extent(skeleton: Skeleton) -> float:
    """The greatest distance between joints at rest, metres."""
    rest = pose_transforms(skeleton, Pose.rest(skeleton, (0.0, 0.0, 0.0)))[:, :3, 3]
    return float(np.linalg.norm(np.ptp(rest, axis=0)))


def _is_flat(ps: Array) -> bool:
    known_ps = ps[np.isfinite(ps).all(-1)]
    spread = np.linalg.svd(known_ps - known_ps.mean(0), compute_uv=False)
    return bool(spread[2] < FLAT * spread[0])
