"""People, or animals, as files of keypoints list them: frame by frame, not yet checked."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Any

import numpy as np

from keypose.tracker.errors import ChoiceError, FormatError, listed
from keypose.tracker.geometry.rotations import Array

MOST_NUMBERS = 10_000_000
"""Keypoints over all frames and individuals of a table."""
LONGEST_IDENTITY = 60
"""Letters."""
MOST_LISTED = 12
"""Names of individuals in a sentence."""


@dataclass(frozen=True)
class People:
    """The people of a file, not yet checked.

    frames: by frame the numbers of each person, u, v and confidence in turn.
    names:  of the keypoints, where the file gives them.
    layout: the one layout that this kind of file has, or None.
    sizes:  width and height of the pictures, where the file gives them.
    fps:    the video's, where the file gives it.
    program: which one's files look like this.
    ids:    by frame the identity of each person there, empty of one that the file gives none.
    """

    frames: Mapping[int, Sequence[Any]]
    names: tuple[str, ...] | None = None
    layout: str | None = None
    sizes: frozenset[tuple[float, float]] = frozenset()
    fps: float | None = None
    program: str = ""
    ids: Mapping[int, Sequence[str]] = field(default_factory=dict)

    @property
    def individuals(self) -> tuple[str, ...]:
        """The people whom the file tells apart, as they first appear; none where somebody has no
        identity, or a frame has one twice."""
        each = [self.ids.get(frame, ()) for frame in sorted(self.frames)]
        are_apart = all(all(ids) and len(set(ids)) == len(ids) for ids in each)
        return tuple(dict.fromkeys(chain.from_iterable(each))) if are_apart else ()

    def of_individual(self, file: str, wanted: str | None) -> People:
        """One of the people alone, all where none is asked for; FormatError where the file does not
        tell people apart, or has not this one."""
        if wanted is None:
            return self
        if not self.individuals:
            raise FormatError(f"{file} does not tell individuals apart: leave out the individual.")
        chosen = chosen_individual(file, self.individuals, wanted)
        frames = {
            frame: [
                person
                for person, own in zip(persons, self.ids[frame], strict=True)
                if own == chosen
            ]
            for frame, persons in self.frames.items()
        }
        return replace(self, frames=frames, ids={})

    @property
    def most_at_once(self) -> int:
        """How many there are in the frame that has the most."""
        shown = (sum(p not in (None, []) for p in persons) for persons in self.frames.values())
        return max(shown, default=0)


def chosen_individual(file: str, individuals: Sequence[str], wanted: str | None) -> str:
    """The individual to read; FormatError where that is not said or not there.

    Of several animals none is taken unasked: the surest one changes from frame to frame.
    """
    shown = listed(list(individuals[:MOST_LISTED]))
    if wanted is None:
        if len(individuals) == 1:
            return individuals[0]
        words = f"{file} has {len(individuals)} individuals, {shown}."
        raise ChoiceError(words, "individual", individuals)
    if wanted not in individuals:
        raise FormatError(f"{file} has no individual {wanted!r}; it has {shown}.")
    return wanted


def identity(*claims: Any) -> str:
    """The first of a file's claims that says who somebody is, a number or text, maybe alone in a
    list; empty where none does, as −1 does not."""
    for claim in claims:
        value = claim[0] if isinstance(claim, list) and len(claim) == 1 else claim
        if isinstance(value, str) and value:
            return value[:LONGEST_IDENTITY]
        if isinstance(value, int) and not isinstance(value, bool) and value >= 0:
            return str(value)
    return ""


def person_numbers(file: str, uv: Array, confidence: Array) -> list[list[float]]:
    """By frame the numbers of one person, u, v and confidence in turn, as `People` has them.

    uv (N, L, 2), NaN where not found.  confidence (N, L), NaN where the file gives none: what a
    person labelled has a place and no score, and is seen.
    """
    if uv.shape[0] * uv.shape[1] > MOST_NUMBERS:
        raise FormatError(f"{file} has {len(uv)} frames of {uv.shape[1]} keypoints: too many.")
    if np.isinf(uv).any() or np.isinf(confidence).any():
        raise FormatError(f"{file} has a keypoint that is not a finite number.")
    is_detected = np.asarray(np.isfinite(uv).all(-1))
    sure = np.where(is_detected, np.where(np.isnan(confidence), 1.0, confidence), 0.0)
    place = np.where(is_detected[..., None], uv, 0.0)
    rows = np.concatenate([place, sure[..., None]], axis=-1).reshape(len(uv), -1)
    return [[float(x) for x in row] for row in rows]


def frame_numbers(names: Sequence[str]) -> dict[str, int]:
    """The frame of each picture or file: of the numbers in names, those at the last place where all
    names differ, or else the last ones. A name without a number is of the frame of its place."""
    names = list(dict.fromkeys(names))
    numbers = [_numbers(name) for name in names]
    places = range(-1, -min(map(len, numbers), default=0) - 1, -1)
    at = next((at for at in places if len({n[at] for n in numbers}) == len(names)), -1)
    return {name: n[at] if n else i for i, (name, n) in enumerate(zip(names, numbers, strict=True))}


def _numbers(name: str) -> list[int]:
    if name.isdecimal():
        return [int(name[-9:])]
    stem = re.sub(r"\.\D\w*$", "", name.removesuffix("_keypoints.json").removesuffix(".0"))
    return [int(digits[-9:]) for digits in re.findall(r"\d+", stem)]
