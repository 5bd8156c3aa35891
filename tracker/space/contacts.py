"""Find where feet stand still in the world, as pins to propose.

The picture shows how fast a point moves across the view; along it the motion is known badly, counts
little and is smoothed for longer. Slow feet high in the air (a raised foot held still, the top of a
jump) are left out by how low the lower foot was nearby, but for one that stays: an error in depth
puts it into the air.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.body import Body
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, runs
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.pins import Pin, sole_of
from keypose.tracker.solver.posed import BodyPoint, BodyPoints

START_M_S = 0.30
STAY_M_S = 0.55
"""A stance begins below the first speed and lasts until the second is passed."""
DEPTH_SHARE = 0.15
"""How much of the speed along the view counts."""
ACROSS_S = 0.025
DEPTH_S = 0.08
"""Widths of the Gaussians that places are smoothed with."""
LEAST_S = 0.09
GAP_S = 0.05
"""A shorter stance is none; a shorter gap does not end one."""
LOW_M = 0.12
NEAR_S = 0.75
"""How far above its lowest place, within so long before and after, a foot may stand."""
STEP_M = 0.30
"""How far above another that stands: one foot on a beam or a stair, but none held up still."""
STAYS_S = 0.25
BELOW_WAIST_M = 0.15
"""The lowest foot that is still for so long, so far below the waist, stands at whatever height."""
GUESSED_UP = np.array([0.0, -1.0, 0.0])
GUESSED_STEP_M = 0.40
"""Where nobody knows how the camera tilts it is taken to stand level, and so much is allowed: feet
0.3 m apart along the view differ by 0.1 m in a camera tilted by 20°."""
MOVED_M = 0.08
"""Where a foot's places before and after are so far apart, as the picture shows it, it has moved in
between, however slowly and shortly."""
TOES_S = 0.15
"""Toes that stay for so long after the heel has left get a pin of their own."""


def proposed_pins(
    skeleton: Skeleton,
    motion: Trajectory,
    frames_per_second: float,
    up_world: Array | None,
    eyes: Array | None = None,
) -> tuple[Pin, ...]:
    """Pins for the feet of a body, where they stand still; whole feet, then toes alone.

    motion: in the world.  up_world: unit vector, None where up is not known: then only a foot held
        far above another that stands is told from a standing one.  eyes (N, 3): where the camera
        was; None where it stands still, in the world's origin.
    """
    feet = list(_feet(skeleton.body))
    if not feet or len(motion) < 3:
        return ()
    points: list[BodyPoint] = []
    for part, _, toe in feet:
        points += [((part, (0.0, 0.0, 0.0)),), ((part, toe),)]
    places = BodyPoints(skeleton, tuple(points)).at(motion.transforms(skeleton))  # (N, 2F, 3)
    waist = motion.ps_camera_root
    low = _low(places, waist, up_world, frames_per_second, eyes)
    least = max(2, round(LEAST_S * frames_per_second))
    pins: list[Pin] = []
    for i, (part, names, _) in enumerate(feet):
        whole = _as_seen(places[:, 2 * i : 2 * i + 2], eyes)
        ankles, toes = (
            _at_one_place(
                whole, still_ranges(places[:, k], frames_per_second, low[:, k], eyes), least
            )
            for k in (2 * i, 2 * i + 1)
        )
        later = _after(toes, ankles, TOES_S * frames_per_second)
        for held, spans in ((names, ankles), (names[1:], later)):
            pins += [_pin(skeleton.body.names[part], held, span, motion) for span in spans]
    return tuple(sorted(pins, key=lambda pin: (pin.first_frame, pin.part)))


def still_ranges(
    p_world: Array,
    frames_per_second: float,
    low: NDArray[np.bool_],
    eyes: Array | None = None,
) -> list[tuple[int, int]]:
    """First and last rows of the ranges over which a point (N, 3) stands still, low (N,) enough."""
    v, n = speed_m_s(p_world, frames_per_second, eyes), len(p_world)
    ranges: list[tuple[int, int]] = []
    row = 0
    while row < n:
        if not (v[row] < START_M_S and low[row]):
            row += 1
            continue
        first = last = row
        begins = 0.5 * (START_M_S + STAY_M_S)
        before = ranges[-1][1] if ranges else -1
        while first - 1 > before and v[first - 1] < begins and low[first - 1]:
            first -= 1
        while last + 1 < n and v[last + 1] < STAY_M_S and low[last + 1]:
            last += 1
        if ranges and first - before - 1 <= GAP_S * frames_per_second:
            first = ranges.pop()[0]
        ranges.append((first, last))
        row = last + 1
    least = LEAST_S * frames_per_second
    # the frames at both ends are where the foot lands and leaves
    kept = [(a + (a > 0), b - (b < n - 1)) for a, b in ranges if b - a + 1 >= least and b - a > 2]
    return [(a, b) for a, b in (_without_leaving(v, *span) for span in kept) if a < b]


def _at_one_place(
    p_seen: Array, spans: Sequence[tuple[int, int]], least: int
) -> list[tuple[int, int]]:
    """Ranges as those over which a foot is at one place each: one ends where all points of the foot
    (N, K, 3) are elsewhere before and after, and the frames on the way are none's."""
    ranges: list[tuple[int, int]] = []
    for first, last in spans:
        pieces = _divided(p_seen, first, last, least)
        for a, b in pieces:
            stays = a + np.flatnonzero(_strays(p_seen[a : b + 1]) < MOVED_M / 4)
            begin = a if a == first else int(stays.min(initial=b))
            end = b if b == last else int(stays.max(initial=a))
            if len(pieces) == 1 or end - begin + 1 >= least:
                ranges.append((begin, end))
    return ranges


def _divided(p_seen: Array, first: int, last: int, least: int) -> list[tuple[int, int]]:
    """A range, or the two that it is divided into where its foot moves on, these again."""
    row = first + _turning(p_seen[first : last + 1], least)
    if row == first or _apart(p_seen[first:row], p_seen[row : last + 1]) < MOVED_M:
        return [(first, last)]
    halves = ((first, row - 1), (row, last))
    return [piece for half in halves for piece in _divided(p_seen, *half, least)]


def _turning(p: Array, least: int) -> int:
    """The row at which a foot's places (n, K, 3) are divided into two that are each as much at one
    place as they can be; 0 where there are too few rows."""
    total = np.cumsum((p - p.mean(axis=0)).reshape(len(p), -1), axis=0)
    rows = np.arange(least, len(p) - least + 1)
    if not len(rows):
        return 0
    before, after = total[rows - 1], total[-1] - total[rows - 1]
    explained = (before**2).sum(axis=1) / rows + (after**2).sum(axis=1) / (len(p) - rows)
    return int(rows[np.argmax(explained)])


def _apart(before: Array, after: Array) -> float:
    """How far the usual places (n, K, 3) of a foot are apart, by the point that moved least."""
    offsets = np.median(before, axis=0) - np.median(after, axis=0)
    return float(np.linalg.norm(offsets, axis=-1).min())


def _strays(p: Array) -> Array:
    """(n,) how far a foot (n, K, 3) is from where it usually is, by the point that is nearest."""
    return np.asarray(np.linalg.norm(p - np.median(p, axis=0), axis=-1).min(axis=1))


def _as_seen(p_world: Array, eyes: Array | None) -> Array:
    """Places (N, K, 3) whose way along the view counts as little as the picture shows it."""
    view = p_world if eyes is None else p_world - eyes[:, None]
    usual = np.median(view, axis=0)
    usual = usual / np.linalg.norm(usual, axis=-1, keepdims=True)
    along = (p_world * usual).sum(axis=-1, keepdims=True) * usual
    return np.asarray(p_world - (1 - DEPTH_SHARE) * along)


def _without_leaving(v: Array, first: int, last: int) -> tuple[int, int]:
    """A range without the frames at the motion's own ends in which the foot lands or leaves."""
    slow = first + np.flatnonzero(v[first : last + 1] < START_M_S)
    if not len(slow):
        return first, last
    return int(slow[0]) if first == 0 else first, int(slow[-1]) if last == len(v) - 1 else last


def _pin(part: str, held: tuple[str, ...], rows: tuple[int, int], motion: Trajectory) -> Pin:
    first, last = (motion.first_frame + row for row in rows)
    return Pin(part=part, landmarks=held, first_frame=first, last_frame=last)


def _feet(body: Body) -> Iterator[tuple[int, tuple[str, ...], tuple[float, float, float]]]:
    """Part, names of heel and toe, and the toe's place of every foot."""
    for i, part in enumerate(body.parts):
        names = sole_of(part)
        if names:
            yield i, names, part.landmarks[names[-1]]


def _after(
    toes: Sequence[tuple[int, int]], heels: Sequence[tuple[int, int]], least: float
) -> list[tuple[int, int]]:
    """What is left of the toes' ranges once their heels have left."""
    ranges = []
    for first, last in toes:
        ends = [b for a, b in heels if a <= last and b >= first]
        if ends and last - max(ends) >= least:
            ranges.append((max(ends) + 1, last))
    return ranges


def speed_m_s(p_world: Array, frames_per_second: float, eyes: Array | None = None) -> Array:
    """(N,) how fast a point (N, 3) moves, as far as pictures taken from eyes (N, 3) show it; None:
    all from the world's origin, along z."""
    if eyes is not None:
        return _speed_from(p_world, frames_per_second, eyes)
    z = p_world[:, 2:]
    ray = _smoothed(p_world[:, :2] / z, ACROSS_S * frames_per_second)
    depth = _smoothed(z, DEPTH_S * frames_per_second)
    across = np.gradient(ray, axis=0) * depth
    along = np.gradient(depth[:, 0])
    moved = np.sqrt((across**2).sum(axis=-1) + (DEPTH_SHARE * along) ** 2)
    return np.asarray(moved * frames_per_second)


def _speed_from(p_world: Array, frames_per_second: float, eyes: Array) -> Array:
    view = p_world - eyes
    view = view / np.linalg.norm(view, axis=1, keepdims=True)
    across, along = (
        np.gradient(_smoothed(p_world, seconds * frames_per_second), axis=0)
        for seconds in (ACROSS_S, DEPTH_S)
    )
    across = across - (across * view).sum(axis=1, keepdims=True) * view
    moved = np.sqrt((across**2).sum(axis=1) + (DEPTH_SHARE * (along * view).sum(axis=1)) ** 2)
    return np.asarray(moved * frames_per_second)


def _smoothed(x: Array, sigma: float) -> Array:
    """Ends are continued as if turned about themselves, so that a slope there stays one."""
    from scipy.ndimage import gaussian_filter1d  # scipy: loads longer than a page needs to start

    pad = min(len(x) - 1, int(np.ceil(4 * sigma)))
    before, after = 2 * x[:1] - x[pad:0:-1], 2 * x[-1:] - x[-2 : -pad - 2 : -1]
    whole = gaussian_filter1d(np.concatenate([before, x, after]), sigma, axis=0)
    return np.asarray(whole[pad : pad + len(x)])


def _low(
    places: Array,
    waist: Array,
    up_world: Array | None,
    frames_per_second: float,
    eyes: Array | None,
) -> NDArray[np.bool_]:
    """(N, K) whether each point is near its own lowest place nearby in time, and no other foot
    stands still below it; or stays where it is, lower than all else that stands still."""
    from scipy.ndimage import minimum_filter1d

    up = GUESSED_UP if up_world is None else up_world
    high, hangs = places @ up, (waist @ up)[:, None] - BELOW_WAIST_M
    step = GUESSED_STEP_M if up_world is None else STEP_M
    near = 2 * int(NEAR_S * frames_per_second) + 1
    lowest = minimum_filter1d(high, near, axis=0, mode="nearest")
    low = (high < lowest + LOW_M) | (up_world is None)
    low &= (high < (waist @ up)[:, None]) | (up_world is None)
    still = np.stack(
        [
            speed_m_s(places[:, k], frames_per_second, eyes) < START_M_S
            for k in range(high.shape[1])
        ],
        axis=1,
    )
    for kind in (slice(0, None, 2), slice(1, None, 2)):  # ankles, toes
        standing = np.where(still[:, kind], high[:, kind], np.inf).min(axis=1, keepdims=True)
        lowest_still = still[:, kind] & (high[:, kind] < standing + LOW_M)
        lowest_still &= high[:, kind] < hangs
        low[:, kind] |= _lasting(lowest_still, STAYS_S * frames_per_second)
        low[:, kind] &= high[:, kind] < standing + step
    return np.asarray(low)


def _lasting(there: NDArray[np.bool_], least: float) -> NDArray[np.bool_]:
    """(N, K) what is there for at least so many frames in a row."""
    lasts = np.zeros_like(there)
    for k in range(there.shape[1]):
        for first, last in runs(there[:, k]):
            lasts[first : last + 1, k] = last - first + 1 >= least
    return lasts
