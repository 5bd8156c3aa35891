"""The named ways to track a segment, as data."""

from __future__ import annotations

from dataclasses import dataclass, replace

from keypose.tracker.session.settings import Initial, TrackSettings


@dataclass(frozen=True)
class Paper:
    """DRIFT as printed: interpolation, least squares with a hard cut, the printed score.

    patience: passes without a new best score after which the cycle ends.
    initial, left_out: where a segment starts from, as in the settings.
    """

    passes: int = 8
    inner: int = 5
    patience: int = 3
    density: float = 1.3
    initial: Initial = "auto"
    left_out: tuple[str, ...] = ()


@dataclass(frozen=True)
class Refinement:
    """How to refine: solves at most, and one surface point of how many is followed."""

    solves: int
    stride: int


@dataclass(frozen=True)
class Keypose:
    """Ours: followed from both keyframes, robust passes, then the whole segment at once.

    stride: one surface point of so many is followed, the one with the strongest gradient.
    finest: pyramid level at which following from the keyframes ends; chain_inner its solves.
    inner, stop: solves of a frame pair at most, and the step (rad, m) that ends them.
    judged: whether trajectories are scored and observed; without, the last one is taken.
    density: surface points as a share of the usual number.
    templates: whether limbs may be looked for by templates where the chains disagree.
    initial, left_out: where a segment starts from, as in the settings.
    """

    passes: int
    stride: int
    chain_inner: int
    refinement: Refinement
    finest: int = 0
    inner: int = 5
    stop: float = 1e-3
    judged: bool = True
    density: float = 1.0
    templates: bool = False
    initial: Initial = "auto"
    left_out: tuple[str, ...] = ()


Method = Paper | Keypose

FULL = Keypose(3, 4, 6, Refinement(solves=6, stride=2), inner=4, templates=True)
WITH_KEYPOINTS = replace(FULL, stride=2, refinement=Refinement(solves=4, stride=1), density=0.5)
"""Keypoints keep hold of limbs, so that half the points do; by brightness alone limbs are lost."""
PREVIEW = Keypose(1, 3, 2, Refinement(solves=2, stride=3), finest=1, judged=False, density=0.5)


def method_of(settings: TrackSettings, *, with_keypoints: bool = False) -> Method:
    """The method that settings name, by brightness alone or with keypoints."""
    initial, left_out = settings.initial, settings.left_out
    if settings.method == "paper":
        return Paper(settings.passes or Paper.passes, initial=initial, left_out=left_out)
    full = WITH_KEYPOINTS if with_keypoints else FULL
    base = full if settings.quality == "full" else PREVIEW
    passes = settings.passes or base.passes
    return replace(base, passes=passes, initial=initial, left_out=left_out)


def expected_steps(settings: TrackSettings) -> int:
    """Trajectories a segment is expected to yield: starts, passes, refinement."""
    method = method_of(settings)
    if isinstance(method, Paper):
        return method.passes + 1
    return method.passes + 3 + method.templates
