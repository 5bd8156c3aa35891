"""The compiled loops once more, in plain numpy: slow, double precision, written to be read."""

from __future__ import annotations

from dataclasses import dataclass
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import (
    exp_rotation,
    log_rotation,
    nearest_rotation,
    rotation_between,
)
from keypose.tracker.kernels.layout import STEPS, BodyArrays, Lens, Visibility

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

BINS = 257
BIN = 0.25
GAIN_CENTRE = 110.0
GAIN_SCALE = 0.02
GAIN_RIDGE = 1e-3


def place_parts(body: BodyArrays, R: Floats, t: Floats) -> tuple[Floats, Floats]:
    """Every part's rotation (P, 3, 3) and origin (P, 3) in the camera frame."""
    HR, Ho = np.empty(R.shape), np.empty((len(R), 3))
    for i, parent in enumerate(body.parents):
        HR[i] = R[i] if parent < 0 else HR[parent] @ R[i]
        Ho[i] = t if parent < 0 else Ho[parent] + HR[parent] @ body.joints[i]
    return HR, Ho


def camera_twists(body: BodyArrays, HR: Floats, Ho: Floats) -> Floats:
    """(D, 6) velocity at the camera's origin, and turn, of every degree of freedom."""
    S = np.zeros((len(body.dof_part), 6))
    for d, (i, turns, axis) in enumerate(
        zip(body.dof_part, body.dof_turns, body.dof_axis, strict=True)
    ):
        direction = HR[i][:, axis]
        if turns:
            S[d] = [*np.cross(Ho[i], direction), *direction]
        else:
            S[d, :3] = direction
    return S


def project(lens: Lens, p: Floats) -> Floats:
    """Pixels (N, 2) of points (N, 3) in the camera frame."""
    z = p[:, 2:] if lens.perspective else np.full((len(p), 1), lens.distance)
    return p[:, :2] / z * (lens.fx, lens.fy) + (lens.cx, lens.cy)


def part_of(body: BodyArrays) -> NDArray[np.int64]:
    """(S,) the part of every surface point."""
    return np.repeat(np.arange(len(body.parents)), np.diff(body.starts))


def in_camera(body: BodyArrays, HR: Floats, Ho: Floats, which: NDArray[np.int64]) -> Floats:
    """Surface points of these indices in the camera frame."""
    part = part_of(body)[which]
    return np.einsum("nij,nj->ni", HR[part], body.points[which].astype(float)) + Ho[part]


def see(
    body: BodyArrays,
    HR: Floats,
    Ho: Floats,
    lens: Lens,
    visibility: Visibility,
    width: int,
    height: int,
) -> tuple[Floats, Bools]:
    """Pixel and depth (S, 3) of every point, and which are seen (S,)."""
    part = part_of(body)
    p = in_camera(body, HR, Ho, np.arange(len(part)))
    normal = np.einsum("nij,nj->ni", HR[part], body.normals.astype(float))
    ray = p if lens.perspective else np.broadcast_to([0.0, 0.0, 1.0], p.shape)
    cosine = -np.sum(normal * ray, axis=1) / np.linalg.norm(ray, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        uv = project(lens, p)
    inside = (uv >= 0).all(1) & (uv[:, 0] < width - 1) & (uv[:, 1] < height - 1)
    facing = (cosine > 0) & (p[:, 2] > 0.05) & inside
    cells = np.where(facing[:, None], (uv + 0.5) / visibility.cell, 0).astype(int)
    nearest: dict[tuple[int, int], tuple[float, int]] = {}
    for q in np.flatnonzero(facing):
        mine = (p[q, 2], int(part[q]))
        place = (cells[q, 0], cells[q, 1])
        nearest[place] = min(nearest.get(place, mine), mine)
    seen = facing & (cosine >= visibility.facing)
    for q in np.flatnonzero(seen):
        depth, owner = nearest[cells[q, 0], cells[q, 1]]
        seen[q] = owner == part[q] or p[q, 2] <= depth + visibility.tolerance
    return np.column_stack([uv, p[:, 2]]), seen


def bilinear(picture: NDArray[np.int16], uv: Floats) -> Floats:
    """Channels (N, 4) of a picture between its pixels, grey levels and share that is usable."""
    column, row = np.floor(uv[:, 0]).astype(int), np.floor(uv[:, 1]).astype(int)
    fu, fv = (uv[:, 0] - column)[:, None], (uv[:, 1] - row)[:, None]
    E = picture / STEPS
    upper = E[row, column] * (1 - fu) + E[row, column + 1] * fu
    lower = E[row + 1, column] * (1 - fu) + E[row + 1, column + 1] * fu
    return upper * (1 - fv) + lower * fv


def pick(
    body: BodyArrays, uvz: NDArray[np.float32], seen: Bools, picture: NDArray[np.int16],
    scale: float, of: int, every: int,
) -> tuple[list[int], list[int]]:  # fmt: skip
    """Indices of the points to follow, and where each part's begin among them."""
    height, width = picture.shape[:2]
    chosen: list[int] = []
    starts = [0]
    for first, last, least in zip(body.starts, body.starts[1:], body.least, strict=False):
        fit = []
        for q in range(first, last, every):
            if not seen[q]:
                continue
            column, row = (int(x) for x in uvz[q, :2] * np.float32(scale) + np.float32(0.5))
            if column + 1 >= width or row + 1 >= height:
                continue
            if picture[row, column, 3] >= least:
                fit.append((float(np.hypot(*picture[row, column, 1:3])), q))
        groups = [fit[k : k + of] for k in range(0, len(fit), of)]
        chosen += [max(g, key=lambda x: x[0])[1] for g in groups if 2 * len(g) >= of]
        starts.append(len(chosen))
    return chosen, starts


@dataclass(frozen=True, eq=False)
class Rows:
    """Linearised brightness of the followed points that fall on usable pixels.

    part (M,), row (M, 6) [g, (p − c) × g], r (M,) residual, source (M,) brightness in the source.
    lost: how many fall outside the picture.
    """

    part: NDArray[np.int64]
    row: Floats
    r: Floats
    source: Floats
    lost: int = 0


def rows_of(
    body: BodyArrays, chosen: NDArray[np.int64], grey: Floats, HR: Floats, Ho: Floats,
    centre: Floats, picture: NDArray[np.int16], lens: Lens, seen: Bools | None = None,
) -> Rows:  # fmt: skip
    """One row of A for every followed point, at the target pose."""
    height, width = picture.shape[:2]
    p = in_camera(body, HR, Ho, chosen)
    uv = project(lens, p)
    fits = (uv >= 0).all(1) & (uv < (width - 1, height - 1)).all(1) & (p[:, 2] > 0.05)
    followed = np.ones(len(chosen), bool) if seen is None else seen[chosen]
    lost = int((followed & ~fits).sum())
    fits &= followed
    fits[fits] = bilinear(picture, uv[fits])[:, 3] >= 0.3
    p, E = p[fits], bilinear(picture, uv[fits])
    x, y, z = p.T if lens.perspective else (*p[:, :2].T, np.full(len(p), lens.distance))
    gx, gy = lens.fx * E[:, 1] / z, lens.fy * E[:, 2] / z
    gz = -(x * gx + y * gy) / z if lens.perspective else np.zeros(len(p))
    g = np.column_stack([gx, gy, gz])
    row = np.column_stack([g, np.cross(p - centre, g)])
    return Rows(part_of(body)[chosen][fits], row, E[:, 0] - grey[fits], grey[fits], lost)


def weights_of(r: Floats, loss: str, scale: float) -> Floats:
    """Weights of least squares, of Huber and of Tukey."""
    if loss == "huber":
        return np.minimum(1.0, scale / np.maximum(np.abs(r), 1e-300))
    if loss == "tukey":
        return np.maximum(1 - (r / scale) ** 2, 0.0) ** 2
    return np.ones_like(r)


def sum_points(rows: Rows, parts: int, loss: str, scale: float, gain: bool) -> Floats:
    """(P, 7, 7) Σ w [row, r]ᵀ[row, r] of every part, the best gain and bias taken out of the rows.

    The squared residuals themselves, entry [6, 6], are left as they are.
    """
    N = np.zeros((parts, 7, 7))
    for i in range(parts):
        mine = rows.part == i
        A = np.column_stack([rows.row[mine], rows.r[mine]])
        W = weights_of(rows.r[mine], loss, scale)[:, None]
        N[i] = A.T @ (W * A)
        if gain:
            source = (rows.source[mine] - GAIN_CENTRE) * GAIN_SCALE
            G = np.column_stack([source, np.ones(mine.sum())])
            cross, own = A.T @ (W * G), G.T @ (W * G) + GAIN_RIDGE * np.eye(2)
            squares = N[i, 6, 6]
            N[i] -= cross @ np.linalg.solve(own, cross.T)
            N[i, 6, 6] = squares
    return N


def histogram(r: Floats, lost: int = 0) -> NDArray[np.int64]:
    """Counts of |r| in quarter grey levels, one open bin, and how many left the picture."""
    counts = np.bincount(np.minimum((np.abs(r) / BIN).astype(int), BINS - 2), minlength=BINS)
    counts[BINS - 1] = lost
    return counts


def robust_sigma(r: Floats) -> float:
    """max(2, 1.4826 MAD); 10 where there is hardly any data."""
    return max(2.0, 1.4826 * float(np.median(np.abs(r)))) if len(r) > 50 else 10.0


def dense_jacobian(body: BodyArrays, below: Bools, rows: Rows, S: Floats) -> Floats:
    """(M, D) A itself: a point moves with the dofs of its own part and of those above it."""
    return (rows.row @ S.T) * below[rows.part][:, body.dof_part]


def normal_equations(body: BodyArrays, below: Bools, N: Floats, S: Floats) -> tuple[Floats, Floats]:
    """AᵀA and Aᵀr from the sums of every part alone (not yet over subtrees)."""
    dofs = len(S)
    A, b = np.zeros((dofs, dofs)), np.zeros(dofs)
    for i in range(len(N)):
        mine = S * below[i][body.dof_part][:, None]
        A += mine @ N[i, :6, :6] @ mine.T
        b += mine @ N[i, :6, 6]
    return A, b


def capped_square(r: Floats, cap: float) -> float:
    """Mean min(r², cap²), every |r| taken at the middle of its bin."""
    middle = (np.minimum((np.abs(r) / BIN).astype(int), BINS - 2) + 0.5) * BIN
    return float(np.minimum(middle**2, cap**2).sum() / max(1, len(r)))


def find_correction(
    M: Floats, T: Floats, shares: Floats | None = None, rounds: int = 20
) -> tuple[Floats, int]:
    """The motions (n, 3, 3) times powers of one X whose product is T, and the rounds it took."""
    shares = np.ones(len(M)) if shares is None else shares
    for k in range(rounds):
        tails = [np.eye(3)]
        for step in M[::-1]:
            tails.append(step @ tails[-1])
        gap = log_rotation(tails[-1].T @ T)
        if np.abs(gap).max() < 1e-11:
            return M, k
        J = sum(w * tail.T for w, tail in zip(shares[::-1], tails[:-1], strict=True))
        M = M @ exp_rotation(shares[:, None] * np.linalg.solve(J, gap))
    return M, -1


def printed_correction(M: Floats, T: Floats, rounds: int) -> list[float]:
    """Errors after each round of DRIFT's nine equations with X = I + Y, as printed (20)–(23)."""
    errors = []
    n = len(M)
    generators = [np.array(g, dtype=float) for g in _SKEW]
    for _ in range(rounds):
        F, G = [np.eye(3)], [np.eye(3)]
        for j in range(n):
            F.append(F[-1] @ M[j])
            G.append(M[n - 1 - j] @ G[-1])
        columns = [
            sum(F[j] @ g @ G[n - j] for j in range(1, n + 1)).ravel()  # type: ignore[union-attr]
            for g in generators
        ]
        abc = np.linalg.lstsq(np.column_stack(columns), (T - F[n]).ravel(), rcond=None)[0]
        M = M @ (np.eye(3) + sum(v * g for v, g in zip(abc, generators, strict=True)))
        errors.append(float(np.linalg.norm(reduce(np.matmul, M) - T)))
    return errors


_SKEW = (
    [[0, 0, 0], [0, 0, -1], [0, 1, 0]],
    [[0, 0, 1], [0, 0, 0], [-1, 0, 0]],
    [[0, -1, 0], [1, 0, 0], [0, 0, 0]],
)


def close_segment(
    R: Floats, t: Floats, R_next: Floats, t_next: Floats, turned: Floats, shifted: Floats,
    R_end: Floats, t_end: Floats,
) -> tuple[Floats, Floats]:  # fmt: skip
    """The motions accumulated from frame 0 and made to meet the end."""
    n = len(R_next)
    M = np.swapaxes(R[:n], -1, -2) @ R_next
    path, R_root = [t[0]], R[0, 0]
    for j in range(n):
        path.append(path[-1] + R_root @ R[j, 0].T @ (t_next[j] - t[j]))
        R_root = R_root @ M[j, 0]
    shares = np.concatenate([[0.0], np.cumsum(shifted)])[:, None] / n
    t_out = np.array(path) + shares * (t_end - path[-1])
    R_out = np.empty((n + 1, *R.shape[1:]))
    for i in range(R.shape[1]):
        steps, _ = find_correction(M[:, i], R[0, i].T @ R_end[i], turned[:, i])
        R_out[0, i] = R[0, i]
        for j in range(n):
            R_out[j + 1, i] = nearest_rotation(R_out[j, i] @ steps[j])
    return R_out, t_out


def blend(forward: Floats, backward: Floats, shares: Floats) -> Floats:
    """Rotations (N, P, 3, 3) that go over from one chain to the other, by shares (N, P)."""
    out = np.empty_like(forward)
    for j, i in np.ndindex(shares.shape):
        out[j, i] = rotation_between(forward[j, i], backward[j, i], [shares[j, i]])[0]
    return out
