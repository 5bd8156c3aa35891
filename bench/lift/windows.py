"""Random windows of motion as a random camera and a network of keypoints would show them."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bench.lift.poses import JOINTS, own_motions
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.lifting import (
    LIFTED,
    MIDDLE,
    OFFSETS_S,
    POINTS,
    encoded,
    turned,
    turns,
)

RATE = 30
_OF_CAPTURE = {
    "hip": "hip",
    "knee": "knee",
    "ankle": "ankle",
    "foot_index": "toe",
    "shoulder": "shoulder",
    "elbow": "elbow",
    "wrist": "wrist",
}


def _capture_name(name: str) -> str:
    side, _, joint = name.partition("_")
    return f"{_OF_CAPTURE[joint]}_{side[0]}" if joint else name


TAKEN = [JOINTS.index(_capture_name(name)) for name in LIFTED]
"""Joints of a capture, in the order of what is lifted."""
SEEN = TAKEN[: len(POINTS)]
SWAPPED = [0, 5, 6, 7, 8, 1, 2, 3, 4, 9, 10, 11, 12, 16, 17, 18, 13, 14, 15]
PARENT = [-1, 0, 1, 2, 3, 0, 5, 6, 7, 0, 9, 10, 11, 10, 13, 14, 10, 16, 17]
GROUP = [-1, 0, 1, 2, 3, 0, 1, 2, 3, 4, 4, 5, 5, 6, 7, 8, 6, 7, 8]
"""Lengths that change together: hips, thigh, shin, foot, trunk, head, shoulders, upper arm and
forearm."""
REFERENCE_M = np.array([0.095, 0.42, 0.41, 0.135, 0.51, 0.175, 0.185, 0.295, 0.25], np.float32)
"""Their lengths in an adult of 172 cm: half of what lies between the hips, and of what lies between
the shoulders, the trunk from the hips' middle to the shoulders', the head from the neck to the
middle of the ears. Captures' own skeletons differ by a quarter, most have forearms of 19 cm.
Thigh, shin and forearm after D. Winter, *Biomechanics and Motor Control of Human Movement*, figure
4.1 (0.245, 0.246 and 0.146 of the height); the trunk's lengths are between that and those of models
that are fitted to markers, wider and longer by some per cent."""
ADULT = np.array([[0.8, 0.9, 0.9, 0.85, 0.88, 0.85, 0.85, 0.88, 0.88],
                  [1.2, 1.12, 1.12, 1.5, 1.13, 1.2, 1.12, 1.12, 1.12]], np.float32)  # fmt: skip
CHILD = np.array([[0.8, 0.75, 0.75, 0.8, 0.95, 1.2, 0.8, 0.75, 0.75],
                  [1.15, 0.97, 0.97, 1.3, 1.2, 1.8, 1.05, 0.98, 0.98]], np.float32)  # fmt: skip
"""Least and most of each, over these."""
CHILDREN = 0.1
"""Share of windows."""
OFF_M = np.zeros(19, np.float32)
"""How far from the joint a network of keypoints sees it: standard deviation along each axis of the
body, the same through a window."""
_OFF_M = {
    "hip": 0.022,
    "knee": 0.014,
    "ankle": 0.014,
    "toe": 0.02,
    "head": 0.03,
    "shoulder": 0.024,
    "elbow": 0.014,
    "wrist": 0.016,
}
for _n in SEEN:
    OFF_M[_n] = _OFF_M[JOINTS[_n].split("_")[0]]
WIDER_M = 0.03
"""How much wider or narrower hips and shoulders are seen, standard deviation."""


def held_out(subject: str, clip: str) -> bool:
    """Whether a clip is left out of the training: a person, a kind, and clips meant for tests."""
    return subject in ("cmu_02", "acrnn_martial") or clip.startswith("test_")


@dataclass(frozen=True)
class Motions:
    """Joints (N, 19, 3) of clips, the hips' middle (N, 3), and of each row that may be the middle
    of a window its index, first and last of its clip, the clip's number, and how often it is drawn,
    cumulated."""

    joints: Array
    root: Array
    rows: Array
    first: Array
    last: Array
    clip: Array
    drawn: Array

    @classmethod
    def of(cls, joints: Array, root: Array, starts: Array, weights: Array) -> Motions:
        """Clips begin at starts, and end at the next; weights: of a row of each, 0 to leave out."""
        kept = [n for n in range(len(starts) - 1) if weights[n] > 0]
        sizes = [int(starts[n + 1] - starts[n]) for n in kept]
        rows = np.concatenate([np.arange(starts[n], starts[n + 1]) for n in kept])
        first = np.repeat([starts[n] for n in kept], sizes)
        last = np.repeat([starts[n + 1] - 1 for n in kept], sizes)
        weight = np.repeat([weights[n] for n in kept], sizes)
        clip = np.repeat(kept, sizes)
        return cls(joints, root, rows, first, last, clip, np.cumsum(weight / weight.sum()))


@dataclass(frozen=True)
class Capture:
    """The file of captures."""

    joints: Array
    root: Array
    starts: Array
    subjects: list[str]
    clips: list[str]

    @classmethod
    def read(cls, path: Path) -> Capture:
        """Read `mocap_30hz.npz`."""
        with np.load(path) as file:
            joints = file["P"].astype(np.float32)
            root = file["root"].astype(np.float32)
            starts, names = file["start"], tuple(map(str, file["names"]))
            subjects, clips = ([str(x) for x in file[key]] for key in ("subject", "clip"))
        if names != JOINTS:
            raise SystemExit(f"{path} has other joints than expected")
        if len(starts) == len(clips):
            starts = np.append(starts, len(joints))
        joints -= joints[:, :1]
        joints -= (joints[:, 1:2] + joints[:, 5:6]) / 2
        joints = of_reference(joints, starts)
        return cls(joints, root, starts, subjects, clips)

    def motions(self, kept: list[bool]) -> Motions:
        """Those of kept clips; of much of one person a window is drawn less often."""
        sizes = np.diff(self.starts)
        of_subject = {
            s: sum(n for n, other in zip(sizes, self.subjects, strict=True) if other == s)
            for s in set(self.subjects)
        }
        weights = np.array([of_subject[s] ** -0.5 for s in self.subjects]) * kept
        return Motions.of(self.joints, self.root, self.starts, weights)


def own(clips: int, seed: int) -> Motions:
    """Motions of our own."""
    joints, starts, _ = own_motions(clips, np.random.default_rng(seed))
    root = joints[:, 0].copy()
    joints = of_reference(joints - joints[:, :1], starts)
    return Motions.of(joints, root, starts, np.ones(clips))


def of_reference(joints: Array, starts: Array) -> Array:
    """The same motion (N, 19, 3) about the hips' middle, of bodies with the reference's lengths."""
    joints = joints.copy()
    joints[:, 0] = 0.0
    joints[:, 11] = joints[:, 10] + 0.65 * (joints[:, 12] - joints[:, 10])  # skeletons differ there
    factor = np.empty((len(joints), len(REFERENCE_M)), np.float32)
    for n in range(len(starts) - 1):
        clip = slice(starts[n], starts[n + 1])
        factor[clip] = REFERENCE_M / _lengths(joints[clip])
    return _stretched(joints, factor)


def _lengths(p: Array) -> Array:
    """Of a clip (N, 19, 3), as `REFERENCE_M`."""

    def way(a: Array, b: Array) -> float:
        return float(np.median(np.linalg.norm(a - b, axis=-1)))

    def sides(a: int, b: int) -> float:
        return (way(p[:, a], p[:, b]) + way(p[:, a + 4 - (a > 12)], p[:, b + 4 - (b > 12)])) / 2

    trunk = way((p[:, 13] + p[:, 16]) / 2, p[:, 0])
    return np.array([
        way(p[:, 1], p[:, 5]) / 2, sides(1, 2), sides(2, 3), sides(3, 4), trunk,
        way(p[:, 10], p[:, 11]), way(p[:, 13], p[:, 16]) / 2, sides(13, 14), sides(14, 15),
    ])  # fmt: skip


def _stretched(joints: Array, factor: Array) -> Array:
    """Joints (N, ..., 19, 3) of bodies whose lengths are so many times (N, 9) as long."""
    factor = factor.reshape(len(joints), *[1] * (joints.ndim - 3), -1, 1)
    out = np.empty_like(joints)
    out[..., 0, :] = joints[..., 0, :]
    for n in range(1, len(JOINTS)):
        bone = joints[..., n, :] - joints[..., PARENT[n], :]
        out[..., n, :] = out[..., PARENT[n], :] + bone * factor[..., GROUP[n], :]
    return out


@dataclass(frozen=True)
class How:
    """What windows are like; shares of them."""

    mixed_arms: float = 0.35
    mixed_legs: float = 0.15
    up_known: float = 0.6
    up_off_rad: float = 0.05
    any_camera: float = 0.1
    alone: float = 0.1
    noise: float = 1.0
    own_share: float = 0.33
    children: float = CHILDREN


@dataclass(frozen=True, eq=False)
class Batch:
    """inputs of the network, joints (B, 16, 3) in body sizes in turned axes, body sizes (B,),
    the number of each one's clip (B,); what is seen, which of it is, and what is up, as the network
    is asked."""

    inputs: Array
    joints: Array
    size_m: Array
    clip: Array
    points: Array
    shown: Array
    up: Array


def body_size(p: Array) -> Array:
    """Leg and trunk of joints (..., 19, 3), m."""

    def way(a: int, b: int) -> Array:
        return np.asarray(np.linalg.norm(p[..., a, :] - p[..., b, :], axis=-1))

    legs = (way(1, 2) + way(2, 3) + way(5, 6) + way(6, 7)) / 2
    trunk = (p[..., 13, :] + p[..., 16, :] - p[..., 1, :] - p[..., 5, :]) / 2
    return np.asarray(legs + np.linalg.norm(trunk, axis=-1))


def batch(
    sources: list[tuple[Motions, int]],
    rng: np.random.Generator,
    how: How = How(),
) -> Batch:
    """Windows, so many of each source."""
    parts = [_windows(motions, count, rng) for motions, count in sources]
    joints, root, inside, clip = (np.concatenate([part[k] for part in parts]) for k in range(4))
    if how.mixed_arms or how.mixed_legs:
        joints = _mixed(joints, rng, how)
    flip = rng.random(len(joints)) < 0.5
    joints[flip] = joints[flip][:, :, SWAPPED]
    joints[flip, ..., 0] *= -1
    root[flip, ..., 0] *= -1
    joints = _resized(joints, rng, how)
    return _seen(joints, root, inside, clip, rng, how)


def _windows(
    motions: Motions, count: int, rng: np.random.Generator
) -> tuple[Array, Array, Array, Array]:
    """Joints (B, 9, 19, 3) from the hips' middle, that (B, 9, 3), what is within the clip (B, 9),
    and the clip (B,)."""
    drawn = np.searchsorted(motions.drawn, rng.random(count))
    rows = np.minimum(drawn, len(motions.rows) - 1)
    tempo = rng.uniform(0.75, 1.3, (len(rows), 1))
    at = motions.rows[rows][:, None] + OFFSETS_S * RATE * tempo
    first, last = motions.first[rows][:, None], motions.last[rows][:, None]
    inside = (at >= first) & (at <= last)
    at = np.clip(at, first, last)
    before = np.floor(at).astype(int)
    after = np.minimum(before + 1, last)
    share = (at - before).astype(np.float32)[..., None]

    def between(values: Array) -> Array:
        s = share.reshape(*share.shape[:2], *[1] * (values.ndim - 1))
        return np.asarray(values[before] * (1 - s) + values[after] * s)

    return between(motions.joints), between(motions.root), inside, motions.clip[rows]


def _axes(lateral: Array, up: Array) -> Array:
    up = up / np.maximum(np.linalg.norm(up, axis=-1, keepdims=True), 1e-6)
    lateral = lateral - (lateral * up).sum(-1, keepdims=True) * up
    lateral /= np.maximum(np.linalg.norm(lateral, axis=-1, keepdims=True), 1e-6)
    return np.stack([lateral, up, np.cross(lateral, up)], -2)


def _mixed(joints: Array, rng: np.random.Generator, how: How) -> Array:
    """Arms and legs of other windows on some trunks."""
    up = joints[:, :, 10] - joints[:, :, 0]
    pelvis = _axes(joints[:, :, 1] - joints[:, :, 5], up)
    chest = _axes(joints[:, :, 13] - joints[:, :, 16], up)
    out = joints.copy()
    limbs = (
        (how.mixed_arms, chest, ((13, (14, 15)), (16, (17, 18)))),
        (how.mixed_legs, pelvis, ((1, (2, 3, 4)), (5, (6, 7, 8)))),
    )
    for share, axes, sides in limbs:
        other = rng.permutation(len(joints))
        for root, limb in sides:
            to = np.nonzero(rng.random(len(joints)) < share)[0]
            source = other[to]
            away = joints[source][:, :, limb] - joints[source][:, :, root, None]
            local = away @ np.swapaxes(axes[source], -1, -2)
            out[to[:, None], :, limb] = (local @ axes[to] + joints[to][:, :, root, None]).transpose(
                0, 2, 1, 3
            )
    return out


def _resized(joints: Array, rng: np.random.Generator, how: How) -> Array:
    """Bodies of other proportions and sizes."""
    rows = len(joints)
    child = rng.random((rows, 1)) < how.children
    share = rng.random((rows, 9), dtype=np.float32)
    factor = np.where(
        child, CHILD[0] + share * (CHILD[1] - CHILD[0]), ADULT[0] + share * (ADULT[1] - ADULT[0])
    )
    factor = factor * rng.uniform(0.85, 1.1, (rows, 1))
    return _stretched(joints, factor.astype(np.float32))


def _camera(rows: int, rng: np.random.Generator, how: How) -> tuple[Array, Array]:
    """Rotations (B, 3, 3) from the world, y up, to cameras that look at the person, and how far
    away they are, m."""
    yaw = rng.uniform(0, 2 * np.pi, rows)
    down = np.radians(rng.uniform(-15, 32, rows))
    roll = np.radians(rng.normal(0, 3, rows))
    roll = np.where(rng.random(rows) < how.any_camera, rng.uniform(-np.pi, np.pi, rows), roll)
    down = np.where(rng.random(rows) < how.any_camera, rng.uniform(-1.5, 1.5, rows), down)
    ahead = np.stack([np.cos(down) * np.sin(yaw), -np.sin(down), np.cos(down) * np.cos(yaw)], -1)
    right = np.stack([-np.cos(yaw), np.zeros(rows), np.sin(yaw)], -1)
    below = np.cross(ahead, right)
    c, s = np.cos(roll)[:, None], np.sin(roll)[:, None]
    R = np.stack([c * right + s * below, c * below - s * right, ahead], 1)
    away = np.exp(rng.uniform(np.log(2.0), np.log(16.0), rows))
    return R.astype(np.float32), away.astype(np.float32)


def _off_joints(joints: Array, rng: np.random.Generator, how: How) -> Array:
    """Where a network of keypoints sees joints (B, 9, 19, 3)."""
    rows = len(joints)
    lateral = joints[:, :, 1] - joints[:, :, 5]
    lateral = lateral * np.array([1, 0, 1], np.float32)
    body = _axes(lateral, joints[:, :, 10] - joints[:, :, 0])
    off = rng.standard_normal((rows, 19, 3), dtype=np.float32) * OFF_M[:, None] * how.noise
    seen = joints + off[:, None] @ body
    for right, left in ((1, 5), (13, 16)):
        wider = rng.standard_normal((rows, 1, 1), dtype=np.float32) * WIDER_M * how.noise / 2
        way = joints[:, :, right] - joints[:, :, left]
        way = way / np.maximum(np.linalg.norm(way, axis=-1, keepdims=True), 1e-3)
        seen[:, :, right] += wider * way
        seen[:, :, left] -= wider * way
    return np.asarray(seen)


def _seen(
    joints: Array, root: Array, inside: Array, clip: Array, rng: np.random.Generator, how: How
) -> Batch:
    """What the network is shown of windows, and what it is to answer."""
    rows = len(joints)
    R, away = _camera(rows, rng, how)
    size = body_size(joints[:, MIDDLE])
    # a camera that goes along keeps some of the way
    stays = np.where(rng.random((rows, 1, 1)) < 0.35, rng.random((rows, 1, 1)), 1.0)
    way = (root - root[:, MIDDLE : MIDDLE + 1]) * stays.astype(np.float32)
    to_camera = np.swapaxes(R, -1, -2)
    ahead = away[:, None, None] * np.array([0, 0, 1], np.float32)
    p_way = way @ to_camera + ahead
    p_way[..., 2] = np.maximum(p_way[..., 2], 0.9)
    Q = _off_joints(joints, rng, how) @ to_camera[:, None] + p_way[:, :, None]
    X = joints @ to_camera[:, None]
    Q[..., 2] = np.maximum(Q[..., 2], 0.4)
    uv = (Q[..., :2] / Q[..., 2:])[:, :, SEEN]
    shown = np.broadcast_to(inside[:, :, None], uv.shape[:3]).copy()
    if how.noise:
        uv = uv + _shaken(uv.shape, X, size / p_way[:, MIDDLE, 2], rng) * how.noise
        _exchange(uv, rng)
        _drop(shown, rng)
    hips = (uv[:, :, 0] + uv[:, :, 4]) / 2
    Rs = turns(hips)
    points = turned(uv, Rs)
    alone = rng.random(rows) < how.alone
    shown[alone] &= (np.arange(len(OFFSETS_S)) == MIDDLE)[:, None]
    now = np.swapaxes(Rs[:, MIDDLE], -1, -2)
    y = (X[:, MIDDLE] - X[:, MIDDLE, :1])[:, TAKEN] / size[:, None, None] @ now
    up = _up(np.einsum("nij,nj->ni", Rs[:, MIDDLE], R[..., 1]), rng, how)
    inputs = encoded(points, shown, up)
    return Batch(inputs, y.astype(np.float32), size, clip, points, shown, up)


def _up(up: Array, rng: np.random.Generator, how: How) -> Array:
    """What is up, a little wrong, or unknown."""
    rows = len(up)
    off = up + rng.normal(0, how.up_off_rad, up.shape) * rng.uniform(0, 1.5, (rows, 1))
    off /= np.linalg.norm(off, axis=1, keepdims=True)
    return np.asarray(np.where(rng.random((rows, 1)) < how.up_known, off, 0.0))


def _shaken(shape: tuple[int, ...], X: Array, tall: Array, rng: np.random.Generator) -> Array:
    """Errors of a network of keypoints: white ones, and slow ones; more of what is farther away
    and likely to be hidden."""
    rows, _, points, _ = shape
    far = X[:, :, SEEN, 2] > 0.1
    amount = rng.uniform(0.4, 1.6, (rows, 1, 1)) * (1 + 0.6 * far) * tall[:, None, None] * 1.25
    slow = rng.standard_normal((rows, 3, points, 2), dtype=np.float32)
    at = (OFFSETS_S * RATE / 28 + 0.5) * 2
    before = np.minimum(at.astype(int), 1)
    s = (at - before).astype(np.float32)[:, None, None]
    drift = slow[:, before] * (1 - s) + slow[:, before + 1] * s
    white = rng.standard_normal(shape, dtype=np.float32)
    return np.asarray((white * 0.0045 + drift * 0.0055) * amount[..., None].astype(np.float32))


def _exchange(uv: Array, rng: np.random.Generator) -> None:
    """Sides of legs or arms that are mistaken for one another, in some moments."""
    for n in np.nonzero(rng.random(len(uv)) < 0.04)[0]:
        first = rng.integers(0, len(OFFSETS_S))
        moments = slice(first, first + rng.integers(1, 4))
        right, left = (
            (slice(0, 4), slice(4, 8)) if rng.random() < 0.7 else (slice(9, 12), slice(12, 15))
        )
        kept = uv[n, moments, right].copy()
        uv[n, moments, right] = uv[n, moments, left]
        uv[n, moments, left] = kept


_HIDDEN = (
    [1, 2, 3], [2, 3], [5, 6, 7], [6, 7], [10, 11], [13, 14], [11], [14], [8], [3, 7], [0], [4],
    [0, 4], [2, 3, 6, 7], [1, 2, 3, 5, 6, 7], [10, 11, 13, 14], [3], [7], [8],
)  # fmt: skip


def _drop(shown: Array, rng: np.random.Generator) -> None:
    """What is hidden in some moments, or always; frames that are missing, and where films end."""
    moments = len(OFFSETS_S)
    for n in np.nonzero(rng.random(len(shown)) < 0.2)[0]:
        first = rng.integers(0, moments) if rng.random() < 0.6 else 0
        hidden = slice(first, first + rng.integers(1, moments + 1))
        shown[n, hidden, _HIDDEN[rng.integers(len(_HIDDEN))]] = False
    for n in np.nonzero(rng.random(len(shown)) < 0.03)[0]:  # a network that knows no feet
        shown[n, :, [3, 7]] = False
    for n in np.nonzero(rng.random(len(shown)) < 0.08)[0]:
        side = rng.integers(3)
        if side == 0:
            shown[n, : rng.integers(1, MIDDLE + 1)] = False
        elif side == 1:
            shown[n, rng.integers(MIDDLE + 1, moments) :] = False
        else:
            missing = rng.random(moments) < 0.4
            missing[MIDDLE] = False
            shown[n, missing] = False
