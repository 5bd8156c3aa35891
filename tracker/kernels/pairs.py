"""One frame pair, a pass over a segment's pairs, and a chain that follows from one end.

The motion x of a pair is held to its prediction: (q AᵀWA + Λ) δ = −(q AᵀW r + Λ x), solved again
and again with the points warped to where they are then. A, W and r are the rows, robust weights and
residuals of the followed points, Λ the prior's precision; q is the independent observations that a
point stands for, over the variance of the residuals. This is DRIFT (10), whose choice of directions
is 0 or 1: here a direction of singular value σ in √q A counts by σ²/(σ² + λ²), where λ² is the
prior's precision along it. What the picture does not show follows the prediction, what it shows
does not.

Arguments of several functions: `body`, `lens`, `visibility`, `prior` are as in `layout`. HR
(P, 3, 3), Ho (P, 3) turn and move points of the parts to the camera. uvz, seen, depth and owner are
as `see` fills them. chosen, grey and starts are the followed points, their brightness in the first
picture, and where each part's begin, as `pick` fills them. of: one of so many neighbouring points
is followed. slots: where frames lie in `pictures`. inner: solves at most; stop: they end at an
update whose largest component is less.
"""

from __future__ import annotations

import numpy as np

from keypose.tracker.kernels import compiled
from keypose.tracker.kernels.chain import (
    camera_twists,
    inverse_diagonal,
    move,
    normal_equations,
    place_parts,
    solve_positive,
    sum_subtrees,
)
from keypose.tracker.kernels.layout import Lens
from keypose.tracker.kernels.noise import BINS, capped_square, robust_sigma
from keypose.tracker.kernels.rigid import cleaned, product, put_pose, turned_back
from keypose.tracker.kernels.robust import HUBER
from keypose.tracker.kernels.seeing import pick, room, see
from keypose.tracker.kernels.sums import BLOCK, HUBER_WIDTH, count_inside, sum_points, sum_residuals

FIRST_WIDTH = 20.0
"""Huber width of the first solve, grey levels: before the residuals' own noise is known."""
LONGEST_STEP = 0.5
"""Largest component of one update, radians or metres; a longer one is shortened as a whole."""
CAP = 15.0
"""Grey levels at which a residual stops counting more in the capped score."""


@compiled
def scaled_lens(lens, scale):
    """The lens of a pyramid level: pixel centres stay at integers."""
    return Lens(
        lens.fx * scale,
        lens.fy * scale,
        lens.cx * scale,
        lens.cy * scale,
        lens.perspective,
        lens.distance,
        int(lens.left * scale),
        int(lens.top * scale),
    )


@compiled
def shortened(step, longest):
    """Shorten `step` in place to `longest`; its largest component, −1 where it is not finite."""
    largest = 0.0
    for d in range(step.shape[0]):
        if not np.isfinite(step[d]):
            return -1.0
        largest = max(largest, abs(step[d]))
    if largest > longest:
        for d in range(step.shape[0]):
            step[d] *= longest / largest
    return largest


@compiled
def linearise(body, chosen, grey, starts, R, t, picture, lens, loss, width, N, histogram, A, b):
    """A (D, D) ← AᵀWA and b (D,) ← AᵀWr of the followed points at the target pose R, t.

    N (P, 7, 7) ← the sums of every part and what hangs below it; histogram of |r|. The number of
    points comes back.
    """
    parts = body.parents.shape[0]
    HR, Ho = np.empty((parts, 3, 3)), np.empty((parts, 3))
    twists = np.empty((b.shape[0], 6))
    rows, unseen = np.empty((9, BLOCK), np.float32), np.empty(0, np.uint8)
    place_parts(body, R, t, HR, Ho)
    centre = Ho[0].copy()
    points = sum_points(
        body,
        chosen,
        grey,
        starts,
        HR,
        Ho,
        centre,
        picture,
        lens,
        unseen,
        False,
        loss,
        width,
        False,
        N,
        histogram,
        rows,
    )
    for i in range(parts):
        for a in range(3):
            Ho[i, a] -= centre[a]
    camera_twists(body, HR, Ho, twists)
    sum_subtrees(body, N)
    normal_equations(body, N, twists, A, b)
    return points


@compiled
def doubts(body, precision, L, turned):
    """turned (P,) ← variance of a part's motion as a share of its prior's; that of the root's shift
    comes back.

    L (D, D): factor of the last normal equations, prior included. 1 is pure prediction, 0 all
    picture; 1 as well for parts that are not tracked.
    """
    variance = np.empty(precision.shape[0])
    inverse_diagonal(L, variance)
    number = np.zeros(turned.shape[0])
    turned[:] = 0.0
    shifted, shifts = 0.0, 0
    for d in range(variance.shape[0]):
        share = variance[d] * precision[d]
        if body.dof_turns[d] == 1:
            turned[body.dof_part[d]] += share
            number[body.dof_part[d]] += 1
        else:
            shifted += share
            shifts += 1
    for i in range(turned.shape[0]):
        turned[i] = turned[i] / number[i] if number[i] > 0 else 1.0
    return shifted / shifts if shifts > 0 else 1.0


@compiled
def solve_pair(body, chosen, grey, starts, R, t, x, picture, lens, prior, inner, stop, A):
    """Move R, t (the target's pose, started at the prediction) to where the picture shows it.

    x (D,) is how far the motion has left the prediction, kept over pyramid levels. A (D, D) ← the
    factor of the last normal equations, for `doubts`. The mean capped square of the residuals at
    the start comes back.
    """
    dofs, N = body.dof_part.shape[0], np.empty((body.parents.shape[0], 7, 7))
    b, histogram = np.empty(dofs), np.empty(BINS, np.int32)
    width, start = FIRST_WIDTH, 0.0
    for k in range(inner):
        points = linearise(
            body, chosen, grey, starts, R, t, picture, lens, HUBER, width, N, histogram, A, b
        )
        if k == 0:
            start = capped_square(histogram, points, CAP)
        sigma = robust_sigma(histogram, points)
        width = HUBER_WIDTH * sigma
        q = prior.information / (sigma * sigma)
        for d in range(dofs):
            b[d] = -(q * b[d] + prior.precision[d] * x[d])
            for e in range(dofs):
                A[d, e] *= q
            A[d, d] += prior.precision[d]
        if not solve_positive(A, b):
            A[:] = 0.0  # nothing but the prediction is left
            for d in range(dofs):
                A[d, d] = np.sqrt(prior.precision[d])
            break
        largest = shortened(b, LONGEST_STEP)
        if largest < 0:
            break
        for d in range(dofs):
            x[d] += b[d]
        move(body, R, t, b)
        if largest < stop:
            break
    return start


@compiled
def least_shown(body, lens, visibility, width, height, R, t):
    """Half the points that the less showing end of a trajectory shows: less is hardly a body."""
    HR, Ho, uvz, seen, depth, owner = room(body, visibility, width, height)[:6]
    place_parts(body, R[0], t[0], HR, Ho)
    first = see(body, HR, Ho, lens, visibility, width, height, uvz, seen, depth, owner)
    n = R.shape[0] - 1
    place_parts(body, R[n], t[n], HR, Ho)
    last = see(body, HR, Ho, lens, visibility, width, height, uvz, seen, depth, owner)
    return 0.5 * min(first, last)


@compiled
def charged(score, shown, least, cap):
    """A pair's score, the worse the fewer points its pose shows: none at all costs the cap."""
    if shown >= least:
        return score
    share = shown / least
    return share * score + (1 - share) * cap * cap


@compiled
def follow_pairs(
    body,
    lens,
    visibility,
    prior,
    pictures,
    slots,
    R,
    t,
    of,
    inner,
    stop,
    R_next,
    t_next,
    turned,
    shifted,
):
    """One pass: from every pose of a segment, the motion to the next frame (DRIFT §2.3).

    R (n + 1, P, 3, 3), t (n + 1, 3) is the present trajectory; slots (n + 1,) is where each
    frame lies in `pictures`. Every pair starts from the trajectory's own pose, which keeps frames
    independent. R_next (n, P, 3, 3), t_next (n, 3) ← where frame j's motion leads; turned (n, P)
    and shifted (n,) ← its `doubts`. The mean capped square of the trajectory's own residuals comes
    back.
    """
    height, width = pictures.shape[1], pictures.shape[2]
    HR, Ho, uvz, seen, depth, owner, chosen, grey, starts = room(body, visibility, width, height)
    dofs = body.dof_part.shape[0]
    x, A = np.zeros(dofs), np.empty((dofs, dofs))
    least = least_shown(body, lens, visibility, width, height, R, t)
    score = 0.0
    for j in range(R_next.shape[0]):
        place_parts(body, R[j], t[j], HR, Ho)
        shown = see(body, HR, Ho, lens, visibility, width, height, uvz, seen, depth, owner)
        pick(body, uvz, seen, pictures[slots[j]], lens, 1.0, of, 1, chosen, grey, starts)
        put_pose(R[j + 1], t[j + 1], R_next[j], t_next[j])
        x[:] = 0.0
        own = solve_pair(
            body,
            chosen,
            grey,
            starts,
            R_next[j],
            t_next[j],
            x,
            pictures[slots[j + 1]],
            lens,
            prior,
            inner,
            stop,
            A,
        )
        shifted[j] = doubts(body, prior.precision, A, turned[j])
        score += charged(own, shown, least, CAP)
    return score / R_next.shape[0]


@compiled
def predict_by_velocity(R, t, j):
    """R[j + 1], t[j + 1] ← the pose after frame j if the last motion goes on."""
    if j == 0:
        put_pose(R[0], t[0], R[1], t[1])
        return
    turn = np.empty((3, 3))
    for i in range(R.shape[1]):
        turned_back(R[j - 1, i], R[j, i], turn)
        product(R[j, i], turn, R[j + 1, i])
        cleaned(R[j + 1, i])
    for a in range(3):
        t[j + 1, a] = 2 * t[j, a] - t[j - 1, a]


@compiled
def follow_chain(
    body, lens, visibility, prior, levels, finest, slots, R, t, of, inner, stop, turned, shifted
):
    """Follow the body frame by frame from R[0], t[0], coarse to fine, by constant velocity.

    levels: pictures of the pyramid, finest first, (…, h, w, 4), used down to `finest`; slots
    (n + 1,) in the order in which the frames are visited (backwards for a chain from the end).
    Fills R[1:], t[1:] and the `doubts` of every step: turned (n, P), shifted (n,).
    """
    height, width = levels[0].shape[1], levels[0].shape[2]
    HR, Ho, uvz, seen, depth, owner, chosen, grey, starts = room(body, visibility, width, height)
    dofs = body.dof_part.shape[0]
    x, A = np.zeros(dofs), np.empty((dofs, dofs))
    for j in range(R.shape[0] - 1):
        place_parts(body, R[j], t[j], HR, Ho)
        see(body, HR, Ho, lens, visibility, width, height, uvz, seen, depth, owner)
        predict_by_velocity(R, t, j)
        x[:] = 0.0
        for level in range(len(levels) - 1, finest - 1, -1):
            scale = 0.5**level
            is_coarse = level >= 2  # it has few pixels: fewer points lie as close
            every = 4 if is_coarse else 1
            neighbours = max(1, of // 2) if is_coarse else of
            pictures = levels[level]
            here = scaled_lens(lens, scale)
            pick(
                body,
                uvz,
                seen,
                pictures[slots[j]],
                here,
                scale,
                neighbours,
                every,
                chosen,
                grey,
                starts,
            )
            solve_pair(
                body,
                chosen,
                grey,
                starts,
                R[j + 1],
                t[j + 1],
                x,
                pictures[slots[j + 1]],
                here,
                prior,
                inner,
                stop,
                A,
            )
        shifted[j] = doubts(body, prior.precision, A, turned[j])


@compiled
def mean_capped_square(body, lens, visibility, pictures, slots, R, t, of, cap):
    """Score of a trajectory: mean over its pairs of the mean min(r², cap²), grey levels squared.

    r is the difference of brightness between a point seen in frame j and where the trajectory
    carries it in frame j + 1.  DRIFT (4), per point and capped. Poses that show hardly a point are
    charged for it.
    """
    height, width = pictures.shape[1], pictures.shape[2]
    HR, Ho, uvz, seen, depth, owner, chosen, grey, starts = room(body, visibility, width, height)
    histogram, rows = np.empty(BINS, np.int32), np.empty((9, BLOCK), np.float32)
    least = least_shown(body, lens, visibility, width, height, R, t)
    score = 0.0
    for j in range(R.shape[0] - 1):
        place_parts(body, R[j], t[j], HR, Ho)
        shown = see(body, HR, Ho, lens, visibility, width, height, uvz, seen, depth, owner)
        pick(body, uvz, seen, pictures[slots[j]], lens, 1.0, of, 1, chosen, grey, starts)
        place_parts(body, R[j + 1], t[j + 1], HR, Ho)
        points = sum_residuals(
            body, chosen, grey, starts, HR, Ho, pictures[slots[j + 1]], lens, histogram, rows
        )
        score += charged(capped_square(histogram, points, cap), shown, least, cap)
    return score / max(1, R.shape[0] - 1)


@compiled
def observe_pairs(body, lens, visibility, pictures, slots, R, t, A, residual, shown, sigma):
    """Observe what every frame pair of a trajectory shows of its motion.

    A (n, D, D) ← AᵀWA at the trajectory itself, of all seen points; residual (n, P) ← root mean
    square difference of brightness of each part's own points, grey levels, with outliers beyond
    FIRST_WIDTH weighed down (NaN without points);
    shown (n, P) int64 ← number of points; sigma (n,) ← robust noise of the residuals.
    """
    height, width = pictures.shape[1], pictures.shape[2]
    HR, Ho, uvz, seen, depth, owner, chosen, grey, starts = room(body, visibility, width, height)
    parts, b = body.parents.shape[0], np.empty(body.dof_part.shape[0])
    N = np.empty((parts, 7, 7))
    histogram, squares = np.empty(BINS, np.int32), np.empty(parts)
    landed = np.empty(parts, np.int64)
    for j in range(R.shape[0] - 1):
        place_parts(body, R[j], t[j], HR, Ho)
        see(body, HR, Ho, lens, visibility, width, height, uvz, seen, depth, owner)
        pick(body, uvz, seen, pictures[slots[j]], lens, 1.0, 1, 1, chosen, grey, starts)
        points = linearise(
            body,
            chosen,
            grey,
            starts,
            R[j + 1],
            t[j + 1],
            pictures[slots[j + 1]],
            lens,
            HUBER,
            FIRST_WIDTH,
            N,
            histogram,
            A[j],
            b,
        )
        sigma[j] = robust_sigma(histogram, points)
        place_parts(body, R[j + 1], t[j + 1], HR, Ho)
        count_inside(body, chosen, grey, starts, HR, Ho, pictures[slots[j + 1]], lens, landed)
        for i in range(parts):
            shown[j, i] = starts[i + 1] - starts[i]
            squares[i] = N[i, 6, 6]
        for i in range(parts):  # N sums over all that hangs below a part: take that away again
            if body.parents[i] >= 0:
                squares[body.parents[i]] -= N[i, 6, 6]
        for i in range(parts):
            residual[j, i] = np.sqrt(max(0.0, squares[i]) / landed[i]) if landed[i] else np.nan


@compiled
def view(body, lens, visibility, width, height, picture, of, R, t, chosen, grey, starts):
    """Choose the points that the pose R, t shows, as `pick` does: fills chosen, grey, starts."""
    HR, Ho, uvz, seen, depth, owner = room(body, visibility, width, height)[:6]
    place_parts(body, R, t, HR, Ho)
    see(body, HR, Ho, lens, visibility, width, height, uvz, seen, depth, owner)
    return pick(body, uvz, seen, picture, lens, 1.0, of, 1, chosen, grey, starts)
