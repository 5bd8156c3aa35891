"""What another film shows, compared with a motion that has the first film's clock.

That film was taken at moments of its own, between those of the motion. Its terms and links are
about poses at its own frames, before its own camera; here they become one link of the motion. A
pose between two frames lies on the even way from one to the other, so what moves it are both, each
by its share.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array, exp_rotation, log_rotation, transpose
from keypose.tracker.kernels.steps import add_blocks
from keypose.tracker.solver.motion_problem import EVERY, MotionProblem, MotionState
from keypose.tracker.solver.terms import Link, Term


@dataclass(frozen=True, eq=False)
class FilmFrames:
    """The M frames of a film beside the N of a motion.

    first_frame: the film's own number of the first.  moments (M,): when they were taken, in rows of
    the motion, within it.  Ts_film_first (M, 4, 4): from the frame of the motion's camera to that
    of the film's, at each.
    """

    first_frame: int
    moments: Array
    Ts_film_first: Array

    def __len__(self) -> int:
        return len(self.moments)

    @cached_property
    def inner(self) -> FilmFrames:
        """All but the first and the last."""
        return FilmFrames(self.first_frame + 1, self.moments[1:-1], self.Ts_film_first[1:-1])

    def between(self, first: int, last: int) -> FilmFrames:
        """Those within two rows of the motion, whose rows count from the first of them then."""
        inside = np.flatnonzero((self.moments >= first) & (self.moments <= last))
        start = self.first_frame + int(inside[0]) if len(inside) else self.first_frame
        return FilmFrames(start, self.moments[inside] - first, self.Ts_film_first[inside])

    @cached_property
    def below(self) -> NDArray[np.int64]:
        """(M,) the rows before them."""
        return np.floor(self.moments).astype(np.int64)

    @cached_property
    def shares(self) -> Array:
        """(2, M) how much the row before and the one after counts."""
        after = self.moments - self.below
        return np.stack([1.0 - after, after])

    def seen(self, motion: Trajectory) -> Trajectory:
        """The motion as the film's camera sees it, at its own frames."""
        R, p = motion.Rs_parent_part, motion.ps_camera_root
        after = np.minimum(self.below + 1, len(motion) - 1)
        share = self.shares[1]
        turns = log_rotation(transpose(R[self.below]) @ R[after])
        Rs = R[self.below] @ exp_rotation(share[:, None, None] * turns)
        ps = p[self.below] + share[:, None] * (p[after] - p[self.below])
        exact = share == 0  # the very numbers, where a frame was taken at the same moment
        Rs[exact], ps[exact] = R[self.below[exact]], p[self.below[exact]]
        return Trajectory(self.first_frame, Rs, ps).carried(self.Ts_film_first)


@dataclass(frozen=True, eq=False)
class InFilm(Link):
    """Terms and links about the poses at a film's own frames, before its camera."""

    skeleton: Skeleton
    frames: FilmFrames
    terms: Sequence[Term] = ()
    links: Sequence[Link] = ()

    @cached_property
    def _problem(self) -> MotionProblem:
        return MotionProblem(self.skeleton, self.terms, self.links, EVERY)

    def cost(self, motion: Trajectory) -> float:
        return self._problem.cost(self.frames.seen(motion))

    def width(self, dofs: int) -> int:
        return (self._reach(dofs) + 1) * dofs

    def _reach(self, dofs: int) -> int:
        """How many rows of the motion lie between the first and the last that it couples."""
        below = self.frames.below
        last = np.minimum(np.arange(len(below)) + self._apart(dofs), len(below) - 1)
        return int((below[last] - below).max(initial=0)) + 1

    def _apart(self, dofs: int) -> int:
        """How many frames of the film lie between the first and the last that it couples."""
        width = max((link.width(dofs) for link in self.links), default=1)
        return -(-(width - 1) // dofs)

    def add_to(self, motion: Trajectory, unknown: slice, rows: Array, b: Array) -> None:
        equations = self._problem.at(MotionState(self.frames.seen(motion)), 0).equations
        dofs = self.skeleton.dof_count
        first, last, _ = unknown.indices(len(motion))
        count, reach = last - first, self._reach(dofs)
        gradient = equations.b.reshape(-1, dofs)
        blocks = np.zeros((reach + 1, count, dofs, dofs))
        pull = np.zeros((count, dofs))
        for side in (0, 1):
            at, share = self.frames.below + side - first, self.frames.shares[side]
            inside = (at >= 0) & (at < count) & (share > 0)
            np.add.at(pull, at[inside], share[inside, None] * gradient[inside])
        for apart, own in enumerate(_blocks(equations.rows, dofs, self._apart(dofs))):
            self._spread(own, apart, first, blocks)
        for apart in range(min(reach + 1, count)):
            add_blocks(np.ascontiguousarray(blocks[apart, : count - apart]), apart, rows)
        b += pull.ravel()

    def _spread(self, own: Array, apart: int, first: int, blocks: Array) -> None:
        """blocks (reach + 1, n, D, D) of the motion += own (M − apart, D, D) between frames of the
        film that lie so far apart, by the shares of the rows about both."""
        below, shares = self.frames.below, self.frames.shares
        count, pairs = blocks.shape[1], len(below) - apart
        for side, far_side in product((0, 1), repeat=2):
            i, k = below[:pairs] + side - first, below[apart:] + far_side - first
            weight = shares[side, :pairs] * shares[far_side, apart:]
            inside = (i >= 0) & (k >= 0) & (i < count) & (k < count) & (weight > 0)
            if apart == 0:
                inside &= i <= k  # the other half is its mirror image
            for rows, flip in ((inside & (i <= k), False), (inside & (i > k), True)):
                part = weight[rows, None, None] * own[rows]
                part = transpose(part) if flip else part
                low, high = np.minimum(i, k)[rows], np.maximum(i, k)[rows]
                np.add.at(blocks, (high - low, low), part)
            if apart > 0:
                same = inside & (i == k)  # both halves fall on the diagonal
                np.add.at(blocks, (0, i[same]), transpose(weight[same, None, None] * own[same]))


def _blocks(rows: Array, dofs: int, farthest: int) -> list[Array]:
    """The blocks (M − k, D, D) between frames k = 0 … farthest apart of a symmetric matrix whose
    rows (M · D, w) go from the diagonal on."""
    count = len(rows) // dofs
    own = rows.reshape(count, dofs, -1)
    blocks = []
    for apart in range(min(farthest, count - 1) + 1):
        block = np.zeros((count - apart, dofs, dofs))
        for d, e in product(range(dofs), repeat=2):
            at = apart * dofs + e - d
            if 0 <= at < own.shape[-1]:
                block[:, d, e] = own[: count - apart, d, at]
        if apart == 0:
            block += transpose(np.triu(block, 1))
        blocks.append(block)
    return blocks
