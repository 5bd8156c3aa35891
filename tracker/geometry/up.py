"""Combine all that says which way is up, each with its doubt, and find what disagrees."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Final, Literal, TypeAlias

import numpy as np

from keypose.tracker.geometry.rotations import Array

UpSource: TypeAlias = Literal["lines", "person", "feet", "level", "set"]
"""What says which way is up: upright lines of the picture, how a person stands, where feet stand,
that cameras are held level, and what somebody set."""
MOST_APART: Final = 3.0
"""Standard deviations that two sources may lie apart: 99 of 100 that are right do not."""
LEAST_PRECISION: Final = 1e-6
"""Rad⁻² of a direction about which a source says nothing."""
LEAST_SHARE: Final = 0.05
"""Of the precision of all that agree, which a source has at least that is named."""
STEPS: Final = 6
"""The problem is linear but for the unit length."""


@dataclass(frozen=True, eq=False)
class UnsureUp:
    """What is up, as far as it is known.

    up: unit vector (3,).  precision: (3, 3), rad⁻², of how far it is off, symmetric; up itself lies
    in its null space, and so does what is not known.
    """

    up: Array
    precision: Array

    @property
    def sigma_rad(self) -> float:
        """The standard deviation where it is largest; huge where a direction is not shown."""
        return _sigma_rad(self.up, self.precision)

    def sigma_along(self, direction: Array) -> float:
        """The standard deviation of how far up leans along a vector (3,), times its length."""
        across = _across(self.up)
        precision_across = across @ self.precision @ across.T + LEAST_PRECISION * np.eye(2)
        along = across @ direction
        return math.sqrt(float(along @ np.linalg.solve(precision_across, along)))


@dataclass(frozen=True, eq=False)
class UpEvidence(UnsureUp):
    """One source of up, in the frame of what it is combined with."""

    source: UpSource

    @classmethod
    def of(cls, up: Array, sigma_rad: float, source: UpSource) -> UpEvidence:
        """The same standard deviation all around."""
        up = np.asarray(up, dtype=np.float64)
        return cls(up, (np.eye(3) - np.outer(up, up)) / sigma_rad**2, source)

    @classmethod
    def with_covariance(cls, up: Array, covariance: Array, source: UpSource) -> UpEvidence:
        """covariance: (3, 3), rad²; what it has along up does not count."""
        across = _across(up)
        precision = across.T @ np.linalg.inv(across @ covariance @ across.T) @ across
        return cls(np.asarray(up), precision, source)

    def off_where_surest(self, up: Array) -> tuple[float, float]:
        """By how much up (3,) is off along the direction that this shows surest, and the standard
        deviation of what it shows there, radians."""
        precisions, directions = np.linalg.eigh(self.precision)
        off_rad = math.asin(min(abs(float(directions[:, -1] @ up)), 1.0))
        return off_rad, 1 / math.sqrt(max(float(precisions[-1]), LEAST_PRECISION))

    def turned(self, R: Array) -> UpEvidence:
        """The same in another frame, in which this one is turned by R (3, 3)."""
        return UpEvidence(R @ self.up, R @ self.precision @ R.T, self.source)

    def seen_by_lens(self, spread: float) -> UpEvidence:
        """The same, of a lens whose focal length is off by a share with this standard deviation:
        what is seen through one twice as long looks tilted by half as much.
        """
        along = self.up[2] * (np.array([0.0, 0.0, 1.0]) - self.up[2] * self.up)
        across = _across(self.up)
        precision_across = across @ self.precision @ across.T + LEAST_PRECISION * np.eye(2)
        covariance = across.T @ np.linalg.inv(precision_across) @ across
        covariance += spread**2 * np.outer(along, along)
        return UpEvidence.with_covariance(self.up, covariance, self.source)


@dataclass(frozen=True, eq=False)
class Disagreement:
    """A source that disagrees with all that agree.  sigmas: how far apart they are, as a multiple
    of the standard deviation of that."""

    evidence: UpEvidence
    sigmas: float


@dataclass(frozen=True, eq=False)
class UpEstimate(UnsureUp):
    """Up by all sources that agree.  used: these, the surest first.  apart: those that do not."""

    used: tuple[UpEvidence, ...]
    apart: tuple[Disagreement, ...] = ()

    @property
    def sources(self) -> tuple[UpSource, ...]:
        """What it rests on: those that agree and weigh something beside each other."""
        whole = sum(float(np.trace(up_evidence.precision)) for up_evidence in self.used)
        heavy = [each for each in self.used if np.trace(each.precision) >= LEAST_SHARE * whole]
        return tuple(each.source for each in heavy)


def combined(evidence: Sequence[UpEvidence], prior: UpEvidence | None = None) -> UpEstimate | None:
    """Up by the most sources that agree, of as many the surest; None without any.

    prior: what is likely where nothing is seen. It counts where it agrees, and is no reason to
    leave a source out.
    """
    for count in range(len(evidence), 0, -1):
        agreeing = [subset for subset in combinations(evidence, count) if _agree(subset)]
        if agreeing:
            used = min(agreeing, key=lambda subset: _sigma_rad(*_mean(subset)))
            break
    else:
        return None
    up, precision = _mean(used)
    if prior is not None and apart_by(prior, up, precision) < MOST_APART:
        up, precision = _mean((*used, prior))
    apart = [
        Disagreement(one, apart_by(one, up, precision))
        for one in evidence
        if not any(one is each for each in used)
    ]
    surest = tuple(sorted(used, key=lambda up_evidence: up_evidence.sigma_rad))
    return UpEstimate(up, precision, surest, tuple(apart))


def up_of_one(evidence: UpEvidence, prior: UpEvidence | None = None) -> UpEstimate:
    """Up by one source, and where it does not show it as it was known before."""
    both = (evidence,) if prior is None else (evidence, prior)
    return UpEstimate(*_mean(both), (evidence,))


def apart_by(evidence: UpEvidence, up: Array, precision: Array) -> float:
    """How far a source is from an estimate that it has no part in, in standard deviations of
    that."""
    across = _across(up)
    off = across @ (evidence.up - up)
    covariance = sum(
        np.linalg.inv(across @ each @ across.T + LEAST_PRECISION * np.eye(2))
        for each in (evidence.precision, precision)
    )
    return math.sqrt(float(off @ np.linalg.solve(covariance, off)))


def _agree(evidence: Sequence[UpEvidence]) -> bool:
    return all(
        apart_by(up_evidence, *_mean(rest)) < MOST_APART
        for up_evidence, rest in _each_beside_the_rest(evidence)
    )


def _each_beside_the_rest(
    evidence: Sequence[UpEvidence],
) -> Iterator[tuple[UpEvidence, tuple[UpEvidence, ...]]]:
    for number, up_evidence in enumerate(evidence):
        rest = (*evidence[:number], *evidence[number + 1 :])
        if rest:
            yield up_evidence, rest


def _mean(evidence: Sequence[UpEvidence]) -> tuple[Array, Array]:
    """The direction that all are least off from, and its precision."""
    precision = sum((each.precision for each in evidence), np.zeros((3, 3)))
    pull = sum((each.precision @ each.up for each in evidence), np.zeros(3))
    surest = min(evidence, key=lambda up_evidence: up_evidence.sigma_rad)
    up = least_off(precision, pull, surest.up)
    away = np.eye(3) - np.outer(up, up)
    return up, np.asarray(away @ precision @ away)


def least_off(precision: Array, pull: Array, start: Array) -> Array:
    """The unit vector u (3,) of least uᵀ precision u − 2 uᵀ pull, by Gauss–Newton on the sphere.

    precision: (3, 3), rad⁻².  pull: (3,).  start: unit vector that is about there.
    """
    up = start
    for _ in range(STEPS):
        across = _across(up)
        power = across @ precision @ across.T + LEAST_PRECISION * np.eye(2)
        up = up + np.linalg.solve(power, across @ (pull - precision @ up)) @ across
        up = up / np.linalg.norm(up)
    return np.asarray(up)


def _across(up: Array) -> Array:
    """(2, 3) unit vectors across up."""
    return np.asarray(np.linalg.svd(np.asarray(up)[None])[2][1:])


def _sigma_rad(up: Array, precision: Array) -> float:
    across = _across(up)
    least = float(np.linalg.eigvalsh(across @ precision @ across.T)[0])
    return 1 / math.sqrt(max(least, LEAST_PRECISION))
