"""Motions of our own where capture is thin: squats, sitting down, bending, lunges, lying, leaps.

Feet are planted, legs bend by two links, and the trunk leans so that the body's weight stays over
the feet; arms do as they like within what joints allow. All values go smoothly from one key to the
next. Metres, y up, z ahead.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from keypose.tracker.geometry.rotations import Array

JOINTS = (
    "pelvis",
    "hip_r",
    "knee_r",
    "ankle_r",
    "toe_r",
    "hip_l",
    "knee_l",
    "ankle_l",
    "toe_l",
    "chest",
    "neck",
    "head",
    "head_top",
    "shoulder_r",
    "elbow_r",
    "wrist_r",
    "shoulder_l",
    "elbow_l",
    "wrist_l",
)
"""In the order of the captures."""
RATE = 30
"""Frames a second."""
SECONDS = 12.0
"""Of a clip."""
THIGH_M = 0.41
SHIN_M = 0.42
TRUNK_M = 0.48
"""Trunk: from the middle of the hips to the base of the neck."""
HIP_M = 0.088
SHOULDER_M = 0.185
"""From the middle line."""
UPPER_ARM_M = 0.285
FOREARM_M = 0.235
FOOT_M = 0.135
ANKLE_M = 0.08
LEG_M = THIGH_M + SHIN_M
_UPPER_WEIGHT = 0.66
_UPPER_MIDDLE = 0.6
_THIGH_WEIGHT = 0.22
"""Shares of the body's weight, and how far up the trunk that of trunk, head and arms acts."""

KINDS = ("squat", "sit", "bend", "lunge", "kneel", "lie", "lift a leg", "twist", "leap", "tumble")


def own_motions(clips: int, rng: np.random.Generator) -> tuple[Array, Array, list[str]]:
    """Joints (N, 19, 3) of so many clips, the first frame of each and the end, and their kinds."""
    kinds = [KINDS[n % len(KINDS)] for n in range(clips)]
    motions = [_motion(kind, rng) for kind in kinds]
    starts = np.cumsum([0, *(len(each) for each in motions)])
    return np.concatenate(motions).astype(np.float32), starts, kinds


def _motion(kind: str, rng: np.random.Generator) -> Array:
    count = int(SECONDS * RATE)
    style = _style(kind, rng)
    keys = _key_frames(count, rng, *style.pauses)
    rows = np.array([style.key(n, rng) for n in range(len(keys))])
    rows[:, _B] = np.where(np.isnan(rows[:, _B]), _balanced(rows), rows[:, _B])
    track = smooth(keys, rows, count)
    arms = smooth(keys, np.array([_arms(row, rng) for row in rows]), count)
    heads = smooth(keys, rng.normal(0, [0.25, 0.4, 0.15], (len(keys), 3)), count)
    joints = _body(track, arms.reshape(count, 4, 3), heads, style)
    if kind == "lie":
        joints = _lying(joints, count, rng)
    if kind == "tumble":
        joints = _tumbling(joints, count, rng)
    heading = smooth(_key_frames(count, rng, 2.0, 5.0), None, count, rng.normal)
    return joints @ np.swapaxes(_about_y(0.3 * heading), -1, -2)


_H, _B, _LEAN, _PELVIS, _TWIST, _SIDE, _ASIDE, _ROLL = range(8)
_LEFT = (8, 9, 10)
_RIGHT = (11, 12, 13)
"""Of a row: hips' height above the ankles over the leg's length, how far behind the ankles they
are (m; NaN: where weight balances), the trunk's lean (rad), its share in the pelvis, the shoulders'
turn against the hips and their lean to the side (rad), the hips' way to the side (m), the pelvis'
list (rad); each foot's way out, up and ahead (m)."""


class _Style:
    """What stays through a clip, and how its keys come."""

    def __init__(
        self,
        key: Callable[[int, np.random.Generator], list[float]],
        rng: np.random.Generator,
        pauses: tuple[float, float] = (0.5, 1.6),
        width: tuple[float, float] = (0.08, 0.28),
        stride: float = 0.0,
        back_heel: float = 0.0,
    ) -> None:
        self.key, self.pauses = key, pauses
        self.half_width = rng.uniform(*width)
        self.toes_out = rng.uniform(0.0, 0.6, 2)
        self.knees_out = rng.uniform(-0.1, 0.35, 2) + self.toes_out * 0.8
        self.stride, self.back_heel = stride, back_heel


def _style(kind: str, rng: np.random.Generator) -> _Style:
    bottom = rng.uniform(0.25, 0.8)
    lean = rng.uniform(0.2, 1.1)

    def stand(r: np.random.Generator) -> list[float]:
        row = [0.0] * 14
        row[_H], row[_B] = r.uniform(0.95, 0.998), np.nan
        row[_LEAN], row[_PELVIS] = r.normal(0.03, 0.06), 0.6
        row[_TWIST], row[_SIDE] = r.normal(0, 0.12), r.normal(0, 0.05)
        row[_ASIDE], row[_ROLL] = r.normal(0, 0.02), r.normal(0, 0.03)
        return row

    def squat(n: int, r: np.random.Generator) -> list[float]:
        row = stand(r)
        if n % 2:
            row[_H] = np.clip(bottom + r.normal(0, 0.06), 0.2, 0.95)
            row[_LEAN] = np.clip(lean + r.normal(0, 0.1), -0.1, 1.4)
        row[_PELVIS] = r.uniform(0.5, 1.0)
        return row

    seat, reach = rng.uniform(0.4, 0.68), rng.uniform(0.22, 0.5)

    def sit(n: int, r: np.random.Generator) -> list[float]:
        row, turn = stand(r), n % 6
        if turn in (1, 5):
            row[_H], row[_LEAN] = seat + r.uniform(0.05, 0.2), r.uniform(0.5, 1.0)
        elif turn in (2, 3, 4):
            row[_H], row[_B] = seat, reach + r.normal(0, 0.01)
            row[_LEAN] = r.uniform(-0.45, 0.7 if turn == 3 else 0.2)
            row[_TWIST], row[_SIDE] = r.normal(0, 0.3), r.normal(0, 0.15)
        row[_PELVIS] = r.uniform(0.4, 0.9)
        return row

    def bend(n: int, r: np.random.Generator) -> list[float]:
        row = stand(r)
        if n % 2:
            row[_H], row[_LEAN] = r.uniform(0.72, 0.99), r.uniform(0.5, 2.0)
            row[_TWIST], row[_SIDE] = r.normal(0, 0.4), r.normal(0, 0.2)
        row[_PELVIS] = r.uniform(0.35, 0.9)
        return row

    stride = rng.uniform(0.35, 0.95) * rng.choice([-1, 1])

    def lunge(n: int, r: np.random.Generator) -> list[float]:
        row = stand(r)
        row[_H] = r.uniform(0.45, 0.75) if n % 2 else r.uniform(0.75, 0.9)
        row[_B] = -stride * r.uniform(0.4, 0.65)
        row[_LEAN] = r.normal(0.15, 0.25)
        return row

    def kneel(n: int, r: np.random.Generator) -> list[float]:
        row = stand(r)
        row[_H] = r.uniform(0.0, 0.45)
        row[_B] = -r.uniform(0.05, 0.42)
        row[_LEAN] = r.uniform(-0.1, 1.7 if n % 2 else 0.4)
        row[_LEFT[2]] = r.uniform(0.0, 0.75) if n % 3 == 0 else 0.0
        return row

    def lie(_: int, r: np.random.Generator) -> list[float]:
        row = stand(r)
        row[_H], row[_B] = r.uniform(0.35, 0.99), r.normal(0, 0.15)
        row[_LEAN] = r.normal(0.1, 0.3)
        row[_TWIST], row[_SIDE] = r.normal(0, 0.3), r.normal(0, 0.15)
        for out, up, ahead in (_LEFT, _RIGHT):
            row[out], row[up], row[ahead] = r.normal(0, 0.1), r.uniform(0, 0.3), r.normal(0.1, 0.2)
        return row

    def lift(n: int, r: np.random.Generator) -> list[float]:
        row = stand(r)
        row[_ASIDE] = -0.09
        if n % 2:
            row[_LEFT[1]], row[_LEFT[2]] = r.uniform(0.05, 0.75), r.uniform(-0.35, 0.55)
            row[_LEAN] = r.normal(0.1, 0.3)
        row[_ROLL] = r.normal(0, 0.1)
        return row

    def twist(_: int, r: np.random.Generator) -> list[float]:
        row = stand(r)
        row[_H], row[_LEAN] = r.uniform(0.75, 0.98), r.uniform(-0.1, 0.7)
        row[_TWIST], row[_SIDE] = r.normal(0, 0.65), r.normal(0, 0.2)
        row[_ASIDE] = r.normal(0, 0.07)
        return row

    def leap(_: int, r: np.random.Generator) -> list[float]:
        row = stand(r)
        row[_H], row[_B] = r.uniform(0.75, 0.99), r.normal(0, 0.05)
        row[_LEAN], row[_PELVIS] = r.normal(0.15, 0.45), r.uniform(0.3, 1.0)
        row[_TWIST], row[_SIDE], row[_ROLL] = r.normal(0, 0.45), r.normal(0, 0.25), r.normal(0, 0.2)
        for out, up, ahead in (_LEFT, _RIGHT):
            row[out], row[ahead] = r.normal(0.1, 0.2), r.normal(0.05, 0.35)
            row[up] = max(0.0, r.normal(0.15, 0.25))
        return row

    table: dict[str, tuple[Callable[..., list[float]], dict[str, object]]] = {
        "squat": (squat, {}),
        "sit": (sit, {"pauses": (0.4, 1.3)}),
        "bend": (bend, {"pauses": (0.5, 1.8)}),
        "lunge": (lunge, {"stride": stride, "back_heel": 0.12}),
        "kneel": (kneel, {"pauses": (0.6, 2.0), "back_heel": 0.02}),
        "lie": (lie, {"pauses": (0.6, 2.5)}),
        "lift a leg": (lift, {"pauses": (0.3, 1.2)}),
        "leap": (leap, {"pauses": (0.15, 0.9)}),
        "tumble": (leap, {"pauses": (0.2, 1.0)}),
        "twist": (twist, {"pauses": (0.25, 1.2), "width": (0.12, 0.4)}),
    }
    key, how = table[kind]
    return _Style(key, rng, **how)  # type: ignore[arg-type]


def _key_frames(count: int, rng: np.random.Generator, least_s: float, most_s: float) -> Array:
    gaps = rng.uniform(least_s, most_s, int(count / (least_s * RATE)) + 3) * RATE
    at = np.cumsum(gaps) - gaps[0] - rng.uniform(0, gaps[0])
    return at[: np.searchsorted(at, count) + 1]


def smooth(
    keys: Array, rows: Array | None, count: int, draw: Callable[..., Array] | None = None
) -> Array:
    """Values (N, ...) that go from key to key with no jerk at either; rows: theirs, or drawn."""
    if rows is None:
        assert draw is not None
        rows = np.cumsum(draw(size=len(keys)))
    at = np.clip(np.searchsorted(keys, np.arange(count), side="right") - 1, 0, len(keys) - 2)
    s = np.clip((np.arange(count) - keys[at]) / (keys[at + 1] - keys[at]), 0.0, 1.0)
    s = (s**3 * (10 - 15 * s + 6 * s**2)).reshape(-1, *[1] * (rows.ndim - 1))
    return np.asarray(rows[at] * (1 - s) + rows[at + 1] * s)


def _balanced(rows: Array) -> Array:
    """How far the hips are behind the ankles where the weight is over the feet."""
    ahead = _UPPER_WEIGHT * _UPPER_MIDDLE * TRUNK_M * np.sin(rows[:, _LEAN])
    back = ahead - 0.04 * (1 - rows[:, _H] * 0.5)
    knees = _THIGH_WEIGHT * 0.5 * (1 - rows[:, _H]) * THIGH_M
    return np.asarray(np.clip((back + knees) / (_UPPER_WEIGHT + _THIGH_WEIGHT), -0.25, 0.42))


def _arms(row: Array, rng: np.random.Generator) -> Array:
    """Directions of upper arm and forearm, right then left, (4, 3): out, up, ahead of the trunk."""
    if rng.random() < 0.3:
        return _hands_at(*_places_of_hands(rng), rng)
    both, how = rng.random() < 0.6, rng.integers(6)
    first = _arm(how, row[_LEAN], rng)
    if both:
        shaken = first + rng.normal(0, 0.08, (2, 3))
        return np.concatenate([first, shaken / np.linalg.norm(shaken, axis=1, keepdims=True)])
    return np.concatenate([first, _arm(rng.integers(6), row[_LEAN], rng)])


def _arm(how: int, lean: float, rng: np.random.Generator) -> Array:
    """Hanging, stretched ahead, bent at the side, overhead, aside, or anyhow."""
    upper, bend = (
        (np.array([0.15, -np.cos(lean), np.sin(lean)]), rng.uniform(0, 0.5)),
        (np.array([0.1, rng.normal(-0.1, 0.3), 1.0]), rng.uniform(0, 0.7)),
        (np.array([0.5, -1.0, rng.normal(0.0, 0.4)]), rng.uniform(0.6, 2.2)),
        (np.array([rng.uniform(0, 0.6), 1.0, rng.normal(0.1, 0.2)]), rng.uniform(0, 1.2)),
        (np.array([1.0, rng.normal(0, 0.3), rng.normal(0.1, 0.3)]), rng.uniform(0, 1.6)),
        (rng.normal([0.3, -0.3, 0.4], 0.7), rng.uniform(0, 2.3)),
    )[how]
    upper = _unit(upper + rng.normal(0, 0.12, 3))
    towards = np.array([rng.normal(-0.5, 0.5), rng.normal(0.4, 0.6), 0.8])
    aside = _unit(towards - (towards @ upper) * upper)
    return np.array([upper, np.cos(bend) * upper + np.sin(bend) * aside])


def _places_of_hands(rng: np.random.Generator) -> tuple[Array, Array]:
    """Right and left hand from between the shoulders (left, up, ahead), m: together or on a bar or
    a club, on the hips, at the head."""
    kind = rng.random()
    if kind < 0.7:
        middle = np.array([rng.normal(0, 0.12), rng.uniform(-0.5, 0.3), rng.uniform(0.15, 0.5)])
        apart = _unit(rng.normal([1.0, 0, 0], 0.4)) * rng.uniform(0.02, 0.25)
        return middle - apart / 2, middle + apart / 2
    place = (0.2, -0.42, 0.03) if kind < 0.85 else (0.1, 0.2, 0.08)
    right, left = np.array(place) * [-1, 1, 1], np.array(place)
    return right + rng.normal(0, 0.04, 3), left + rng.normal(0, 0.04, 3)


def _hands_at(right: Array, left: Array, rng: np.random.Generator) -> Array:
    """Directions as of `_arms` of arms whose hands are there, or as near as they reach."""
    elbows, found = rng.normal([0.5, -1.0, -0.2], 0.3), []
    for sign, hand in ((-1, right), (1, left)):
        way = np.array([sign * hand[0] - SHOULDER_M, hand[1], hand[2]])
        reach = np.clip(np.linalg.norm(way), 0.12, 0.99 * (UPPER_ARM_M + FOREARM_M))
        along = _unit(way)
        aside = _unit(elbows - (elbows @ along) * along)
        cosine = (UPPER_ARM_M**2 + reach**2 - FOREARM_M**2) / (2 * UPPER_ARM_M * reach)
        cosine = np.clip(cosine, -1.0, 1.0)
        upper = cosine * along + np.sqrt(1 - cosine**2) * aside
        found += [upper, _unit(along * reach - UPPER_ARM_M * upper)]
    return np.array(found)


def _body(track: Array, arms: Array, heads: Array, style: _Style) -> Array:
    """Joints (N, 19, 3) of all values."""
    count = len(track)
    p = np.zeros((count, len(JOINTS), 3))
    at = {name: n for n, name in enumerate(JOINTS)}
    height = track[:, _H] * LEG_M
    pelvis = np.column_stack([track[:, _ASIDE], ANKLE_M + height, -track[:, _B]])
    lean, share = track[:, _LEAN], track[:, _PELVIS]
    R_pelvis = _about_z(track[:, _ROLL]) @ _about_x(lean * share)
    R_chest = _about_x(lean) @ _about_z(track[:, _SIDE]) @ _about_y(track[:, _TWIST])
    half = _about_x(lean * (0.4 + 0.6 * share)) @ _about_z(track[:, _SIDE] * 0.5)
    p[:, 0] = pelvis
    p[:, at["chest"]] = pelvis + _turned(half, (0, 0.62 * TRUNK_M, 0))
    p[:, at["neck"]] = p[:, at["chest"]] + _turned(R_chest, (0, 0.38 * TRUNK_M, 0))
    R_head = (
        R_chest @ _about_x(heads[:, 0] - 0.5 * lean) @ _about_y(heads[:, 1]) @ _about_z(heads[:, 2])
    )
    p[:, at["head"]] = p[:, at["neck"]] + _turned(R_head, (0, 0.17, 0.02))
    p[:, at["head_top"]] = p[:, at["neck"]] + _turned(R_head, (0, 0.27, 0.02))
    # x is to the body's left: facing z, y up
    for sign, side, arm in ((-1, "r", 0), (1, "l", 2)):
        shoulder = p[:, at["neck"]] + _turned(R_chest, (sign * SHOULDER_M, -0.02, 0))
        ways = arms[:, arm : arm + 2] * [sign, 1, 1]
        ways = ways / np.linalg.norm(ways, axis=2, keepdims=True)
        elbow = shoulder + UPPER_ARM_M * np.einsum("nij,nj->ni", R_chest, ways[:, 0])
        wrist = elbow + FOREARM_M * np.einsum("nij,nj->ni", R_chest, ways[:, 1])
        for name, value in (("shoulder", shoulder), ("elbow", elbow), ("wrist", wrist)):
            p[:, at[f"{name}_{side}"]] = value
        left = sign > 0
        hip = pelvis + _turned(R_pelvis, (sign * HIP_M, 0, 0))
        out, up, ahead = (track[:, n] for n in (_LEFT if left else _RIGHT))
        ahead = ahead + (style.stride if left else 0.0)
        back = (style.stride > 0) != left
        heel = style.back_heel if back and style.back_heel else 0.0
        aside = sign * (style.half_width + out)
        ankle = np.column_stack([aside, ANKLE_M + heel + up, ahead])
        turn = sign * style.toes_out[int(left)]
        knee, ankle = _two_links(hip, ankle, sign * style.knees_out[int(left)])
        p[:, at[f"hip_{side}"]], p[:, at[f"knee_{side}"]] = hip, knee
        p[:, at[f"ankle_{side}"]] = ankle
        drop = 0.06 + 0.7 * heel
        way = np.array([np.sin(turn) * FOOT_M, -drop, np.cos(turn) * FOOT_M])
        p[:, at[f"toe_{side}"]] = ankle + way * FOOT_M / np.linalg.norm(way)
    return p


def _two_links(hip: Array, ankle: Array, out: float) -> tuple[Array, Array]:
    """Knees of legs between hips and ankles (N, 3), bent towards ahead and outward; ankles beyond
    reach come nearer."""
    way = ankle - hip
    length = np.linalg.norm(way, axis=1, keepdims=True)
    reach = np.clip(length, 0.18, 0.999 * LEG_M)
    along = way / length
    ankle = hip + along * reach
    toward = np.array([np.sin(out), 0.35, np.cos(out)])
    bend = toward - (along @ toward)[:, None] * along
    bend /= np.maximum(np.linalg.norm(bend, axis=1, keepdims=True), 1e-6)
    cosine = (THIGH_M**2 + reach**2 - SHIN_M**2) / (2 * THIGH_M * reach)
    cosine = np.clip(cosine, -1.0, 1.0)
    return hip + THIGH_M * (cosine * along + np.sqrt(1 - cosine**2) * bend), ankle


def _lying(joints: Array, count: int, rng: np.random.Generator) -> Array:
    """The same body on its back, its belly or a side, or rolling from one to another."""
    keys = _key_frames(count, rng, 1.5, 4.0)
    roll = smooth(keys, rng.integers(0, 4) * np.pi / 2 + rng.normal(0, 0.5, len(keys)), count)
    pitch = -np.pi / 2 + smooth(keys, rng.normal(0, 0.2, len(keys)), count)
    R = _about_x(pitch) @ _about_y(roll)
    return np.asarray((joints - joints[:, :1]) @ np.swapaxes(R, -1, -2))


def _tumbling(joints: Array, count: int, rng: np.random.Generator) -> Array:
    """The same body turning over in every way."""
    keys = _key_frames(count, rng, 0.4, 1.5)
    turns = np.cumsum(rng.normal(0, 1.2, (len(keys), 3)), axis=0) + rng.uniform(-3, 3, 3)
    pitch, yaw, roll = smooth(keys, turns, count).T
    R = _about_x(pitch) @ _about_z(roll) @ _about_y(0.5 * yaw)
    return np.asarray((joints - joints[:, :1]) @ np.swapaxes(R, -1, -2))


def _unit(v: Array) -> Array:
    return np.asarray(v / np.linalg.norm(v))


def _turned(R: Array, v: tuple[float, float, float]) -> Array:
    return np.asarray(R @ np.array(v, dtype=float))


def _about(angle: Array, first: int, second: int) -> Array:
    R = np.zeros((len(angle), 3, 3))
    R[:, range(3), range(3)] = 1.0
    c, s = np.cos(angle), np.sin(angle)
    R[:, first, first], R[:, second, second] = c, c
    R[:, first, second], R[:, second, first] = -s, s
    return R


def _about_x(angle: Array) -> Array:
    """y towards z: positive leans ahead."""
    return _about(angle, 1, 2)


def _about_y(angle: Array) -> Array:
    return _about(angle, 2, 0)


def _about_z(angle: Array) -> Array:
    return _about(angle, 0, 1)
