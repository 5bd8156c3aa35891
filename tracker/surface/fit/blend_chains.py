"""Chains of steps as one motion: from one keyframe, or from two and then blended part by part.

Steps that no chain has reached yet keep the nearest pose, or are interpolated between two.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from keypose.tracker.body.pose import Pose, part_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, exp_rotation, log_rotation, transpose
from keypose.tracker.surface.fit.chain import Link
from keypose.tracker.surface.fit.measuring import StepFit

TRUST_POWER = 2
"""How sharply the chain is preferred whose surfaces lie nearer, in powers of squared distance."""


@dataclass(frozen=True, eq=False)
class JoinedChains:
    """A segment's links in the order of their frames.

    apart_m: (N, P) how far two whole chains put each joint apart; None where there was one.
    unreached: the first and last frame that no chain has reached.  missing: links that the chains
        still lack.
    """

    links: tuple[Link, ...]
    apart_m: Array | None
    unreached: tuple[int, int] | None = None
    missing: int = 0


def join_chains(
    skeleton: Skeleton,
    span: tuple[int, int],
    chains: Sequence[Sequence[Link]],
    keyposes: Mapping[int, Pose],
) -> JoinedChains:
    """All steps of a segment of the one or two chains that begin at its keyframes.

    chains: each in the order in which it was followed, its keyframe first, as far as it has come.
    """
    count = span[1] - span[0] + 1
    missing = sum(count - len(chain) for chain in chains)
    if missing:
        return _join_partial(skeleton, span, chains, missing)
    whole = [_complete(chain, keyposes) for chain in chains]
    first, second = whole[0], whole[-1]
    if len(whole) == 1:
        return JoinedChains(tuple(first), None)
    distances = _joint_distances(skeleton, first, second)
    return JoinedChains(tuple(_blend(skeleton, first, second)), distances)


def _complete(chain: Sequence[Link], keyposes: Mapping[int, Pose]) -> list[Link]:
    """One chain in the order of the frames; a keyframe at its far end is never changed."""
    far = chain[-1].frame
    links = fill_gaps(sorted(chain, key=lambda link: link.frame))
    if far in keyposes:
        place = 0 if links[0].frame == far else -1
        links[place] = replace(links[place], pose=keyposes[far])
    return links


def _join_partial(
    skeleton: Skeleton, span: tuple[int, int], chains: Sequence[Sequence[Link]], missing: int
) -> JoinedChains:
    """What unfinished chains have reached; beyond, the nearest pose before is kept."""
    first, last = span
    keyed = {chain[0].frame: chain[0] for chain in chains}
    at = [{link.frame: link for link in chain} for chain in chains]
    link_of_frame: dict[int, Link] = {}
    for frame in range(first, last + 1):
        there = [links[frame] for links in at if frame in links]
        if frame in keyed:
            link_of_frame[frame] = keyed[frame]
        elif len(there) == 2:
            link_of_frame[frame] = blend_links(
                skeleton, there[0], there[1], (frame - first) / (last - first)
            )
        elif there:
            link_of_frame[frame] = there[0]
    pose = link_of_frame[min(link_of_frame)].pose
    links = []
    for frame in range(first, last + 1):
        link = link_of_frame.get(frame) or Link(frame, pose, None)
        links.append(link)
        pose = link.pose
    beyond = [frame for frame in range(first, last + 1) if frame not in link_of_frame]
    unreached = (beyond[0], beyond[-1]) if beyond else None
    return JoinedChains(tuple(fill_gaps(links)), None, unreached, missing)


def fill_gaps(links: Sequence[Link]) -> list[Link]:
    """Links of consecutive frames; where a step could not be used, its pose is interpolated."""
    good = [k for k, link in enumerate(links) if link.step is not None]
    whole = list(links)
    for before, after in pairwise(good):
        for k in range(before + 1, after):
            share = (k - before) / (after - before)
            pose = _interpolate(links[before].pose, links[after].pose, share)
            whole[k] = replace(links[k], pose=pose)
    return whole


def blend_links(skeleton: Skeleton, forward: Link, backward: Link, share: float) -> Link:
    """One link of the two that chains from both keyframes have at a frame.

    share: how far the frame lies from the first keyframe to the second, 0 to 1. Each part leans to
    the chain whose surfaces lie nearer to each other, on that part and on what hangs from it.
    """
    if forward.step is None or backward.step is None:
        between = _interpolate(forward.pose, backward.pose, share)
        return Link(forward.frame, between, None, forward.problem)
    ahead = _chain_weight(skeleton, forward.step, 1.0 - share)
    behind = _chain_weight(skeleton, backward.step, share)
    back = behind / np.maximum(ahead + behind, 1e-30)
    better = forward if ahead[0] >= behind[0] else backward
    return Link(forward.frame, _interpolate(forward.pose, backward.pose, back), better.step)


def _chain_weight(skeleton: Skeleton, step: StepFit, nearness: float) -> Array:
    """(P,) how much a chain counts for each part."""
    square = np.where(np.isfinite(step.residual), step.residual**2, 0.0) + 1e-9
    weight = np.where(np.isfinite(step.residual), step.counts, 0.0) + 1e-6
    below = skeleton.below.T
    mean = (below @ (weight * square)) / (below @ weight)
    return np.asarray(max(nearness, 1e-3) / mean**TRUST_POWER)


def _interpolate(first: Pose, second: Pose, share: Array | float) -> Pose:
    """A pose between two, part by part: the first one at share 0, the second one at 1."""
    shares = np.broadcast_to(np.asarray(share, dtype=np.float64), (len(first.Rs_parent_part),))
    turn = log_rotation(transpose(first.Rs_parent_part) @ second.Rs_parent_part)
    Rs = first.Rs_parent_part @ exp_rotation(shares[:, None] * turn)
    root = (1 - shares[0]) * first.p_camera_root + shares[0] * second.p_camera_root
    return Pose(Rs, root)


def _blend(skeleton: Skeleton, first: Sequence[Link], second: Sequence[Link]) -> list[Link]:
    """Two chains as one; the keyframes at both ends stay as they are."""
    inner = [
        blend_links(skeleton, ahead, behind, k / (len(first) - 1))
        for k, (ahead, behind) in enumerate(zip(first, second, strict=True))
    ]
    return [first[0], *inner[1:-1], second[-1]]


def _joint_distances(skeleton: Skeleton, first: Sequence[Link], second: Sequence[Link]) -> Array:
    """(N, P) metres between the joints of two chains; near a keyframe the far one has no weight."""
    joints = [_joints(skeleton, links) for links in (first, second)]
    share = np.linspace(0.0, 1.0, len(first))
    return np.asarray(
        np.linalg.norm(joints[0] - joints[1], axis=2) * (4 * share * (1 - share))[:, None]
    )


def _joints(skeleton: Skeleton, links: Sequence[Link]) -> Array:
    Rs = np.array([link.pose.Rs_parent_part for link in links])
    roots = np.array([link.pose.p_camera_root for link in links])
    return part_transforms(skeleton, Rs, roots)[..., :3, 3]
