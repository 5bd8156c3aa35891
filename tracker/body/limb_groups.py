"""Group a body's parts by limb: trunk, arms and legs of a person, else its unbranched chains."""

from __future__ import annotations

import numpy as np

from keypose.tracker.body.body import Body
from keypose.tracker.body.skeleton import Skeleton

SIDES = ("left", "right")
_ARM = {"clavicle", "upper_arm", "forearm", "hand"}
_LEG = {"thigh", "shin", "foot"}


def kind_of(name: str) -> str:
    """A part's name without its side: "forearm"."""
    return "_".join(word for word in name.split("_") if word not in SIDES)


def limb_groups(body: Body) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """The groups of parts that are looked at together, each with its name.

    Of a person trunk, right_arm, left_arm, right_leg and left_leg; of another body the root and
    each limb, by the words that its parts' names share.
    """
    if {"chest", "left_upper_arm", "right_thigh"} <= set(body.names):
        return _persons(body)
    groups = [(body.parts[0].name,), *chains(Skeleton.of(body))]
    return tuple((_shared_name(group), group) for group in groups)


def chains(skeleton: Skeleton) -> list[tuple[str, ...]]:
    """The unbranched chains a body is made of, without the root, in the parts' order."""
    names, limbs = skeleton.body.names, skeleton.limbs
    order = dict.fromkeys(limbs[1:].tolist())
    return [tuple(names[i] for i in np.flatnonzero(limbs == limb)) for limb in order]


def _persons(body: Body) -> tuple[tuple[str, tuple[str, ...]], ...]:
    names = ("trunk", "right_arm", "left_arm", "right_leg", "left_leg")
    groups: dict[str, list[str]] = {name: [] for name in names}
    for name in body.names:
        kind = kind_of(name)
        limb = "arm" if kind in _ARM else "leg" if kind in _LEG else ""
        groups.get(f"{name.split('_')[0]}_{limb}", groups["trunk"]).append(name)
    return tuple((name, tuple(parts)) for name, parts in groups.items() if parts)


def _shared_name(group: tuple[str, ...]) -> str:
    """The words that all names share, else the first and the last name."""
    if len(group) == 1:
        return group[0]
    words = [name.split("_") for name in group]
    shared = [word for word in words[0] if all(word in name_words for name_words in words)]
    return "_".join(shared) if shared else " and ".join((group[0], group[-1]))
