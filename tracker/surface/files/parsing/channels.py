"""What an animation moves: values of a node over time.  glTF 2.0, appendix C"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final, Literal, TypeAlias

import numpy as np

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.surface.files.parsing.glb import Glb, at, damaged
from keypose.tracker.surface.files.parsing.raw import Refused

Target: TypeAlias = Literal["translation", "rotation", "scale", "weights"]

_WIDTHS: Final = {"translation": 3, "rotation": 4, "scale": 3, "weights": 1}


@dataclass(frozen=True, eq=False)
class Channel:
    """One moved property of one node.

    times_s: (K,) ascending. values: (K, W); for "CUBICSPLINE" (K, 3, W): the slope before, the
    value, the slope behind.
    """

    node: int
    target: Target
    how: str
    times_s: Array
    values: Array

    def value(self, time_s: float) -> Array:
        """(W,) at a time; before the first and after the last time it stands still."""
        right = int(np.searchsorted(self.times_s, time_s, side="right"))
        left = max(right - 1, 0)
        right = min(right, len(self.times_s) - 1)
        step = self.times_s[right] - self.times_s[left]
        if step <= 0 or time_s <= self.times_s[left]:
            return self._unit(self._plain(left))
        share = float((time_s - self.times_s[left]) / step)
        if self.how == "STEP":
            return self._plain(left)
        if self.how == "CUBICSPLINE":
            return self._unit(_spline(self.values[left], self.values[right], share, step))
        if self.target == "rotation":
            return slerp(self._plain(left), self._plain(right), share)
        return np.asarray((1 - share) * self._plain(left) + share * self._plain(right))

    def _plain(self, key: int) -> Array:
        return np.asarray(self.values[key, 1] if self.how == "CUBICSPLINE" else self.values[key])

    def _unit(self, value: Array) -> Array:
        return unit(value) if self.target == "rotation" else value


def channels_of(glb: Glb) -> list[Channel]:
    """The channels of the file's first animation; those of what it does not know are left out."""
    found = []
    for animation, channel in _first_animation(glb):
        target = channel["target"]
        sampler = at(animation["samplers"], channel["sampler"])
        if "node" in target and target.get("path") in _WIDTHS:
            at(glb.items("nodes"), target["node"])
            found.append(_channel(glb, target["node"], target["path"], sampler))
    return found


def _first_animation(glb: Glb) -> list[tuple[dict[str, Any], dict[str, Any]]]:
    return [
        (first, channel) for first in glb.items("animations")[:1] for channel in first["channels"]
    ]


def _channel(glb: Glb, node: int, target: Target, sampler: dict[str, Any]) -> Channel:
    times = glb.numbers(sampler["input"], 1)[:, 0].astype(np.float64)
    values = glb.numbers(sampler["output"], _WIDTHS[target]).astype(np.float64)
    how = sampler.get("interpolation", "LINEAR")
    if how not in ("LINEAR", "STEP", "CUBICSPLINE"):
        raise Refused("moves in a way that is not known: export it with linear interpolation.")
    if not np.isfinite(times).all() or (np.diff(times) < 0).any():
        raise Refused("has an animation whose times do not ascend: export it again.")
    sides = 3 if how == "CUBICSPLINE" else 1
    if values.size % (len(times) * sides):
        raise damaged()
    values = values.reshape((len(times), 3, -1) if sides == 3 else (len(times), -1))
    if values.shape[-1] < 1 or (target != "weights" and values.shape[-1] != _WIDTHS[target]):
        raise damaged()
    return Channel(node, target, how, times, values)


def unit(quaternion: Array) -> Array:
    """A quaternion x, y, z, w of length 1; no turn where it has none."""
    length = float(np.linalg.norm(quaternion))
    return quaternion / length if length > 0 else np.array([0.0, 0.0, 0.0, 1.0])


def slerp(a: Array, b: Array, share: float) -> Array:
    """The shorter way from one quaternion to another, at constant speed."""
    a, b = unit(a), unit(b)
    cosine = float(a @ b)
    if cosine < 0:
        b, cosine = -b, -cosine
    if cosine > 1 - 1e-9:
        return unit((1 - share) * a + share * b)
    angle = np.arccos(cosine)
    return np.asarray((np.sin((1 - share) * angle) * a + np.sin(share * angle) * b) / np.sin(angle))


def _spline(left: Array, right: Array, s: float, step: float) -> Array:
    """Hermite's cubic between two values with their slopes."""
    return np.asarray(
        (2 * s**3 - 3 * s**2 + 1) * left[1]
        + step * (s**3 - 2 * s**2 + s) * left[2]
        + (-2 * s**3 + 3 * s**2) * right[1]
        + step * (s**3 - s**2) * right[0]
    )
