"""The preset's proportions scaled to the person's, as far as landmarks show.

Height and distance show only together in a picture, so the body keeps its height. What the network
does give is how long bones are beside each other: its landmarks in space have the person's bones up
to one common factor. Where enough frames show a bone, its median length there is believed, drawn
toward the preset's proportions, and never beyond what people differ by. Widths of the hips stay:
the network puts hips where no joint is. So does thickness, which landmarks do not show.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from keypose.tracker.body.body import Body
from keypose.tracker.body.modify import height, joint_moved, resized, with_height
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.fitting.draft.limbs import SIDES, Joints, place_of
from keypose.tracker.fitting.draft.observed import Observed
from keypose.tracker.geometry.rotations import Array

SURE = 0.7
"""Visibility of both ends of a bone that is measured."""
FEWEST = 12
"""Frames from which a length is known."""
USUAL: Final = 0.08
"""Standard deviation of people's proportions about the preset's."""
DOUBT, SHOULDER_DOUBT = 0.04, 0.15
"""Those of the network's, which puts shoulders mostly too near each other."""
LARGEST: Final = 0.15
"""By which a length is changed at most, beside the others."""
_TRUNK, _SHOULDERS = "trunk", "shoulders"


def with_proportions(body: Body, observed: Observed) -> Body:
    """The body with trunk, shoulders, arms and legs in the person's proportions, and its height."""
    joints = Joints.of(Skeleton.of(body))
    ratios = _ratios(joints, observed)
    known = [ratio for ratio in ratios.values() if ratio is not None]
    if not known:
        return body
    common = float(np.median(known))
    factors = {
        name: _toward_preset(ratio / common, SHOULDER_DOUBT if name == _SHOULDERS else DOUBT)
        for name, ratio in ratios.items()
        if ratio is not None
    }
    return with_height(_scaled(body, joints, factors), height(body))


def _toward_preset(factor: float, doubt: float) -> float:
    share = USUAL**2 / (USUAL**2 + doubt**2)
    return float(np.exp(np.clip(share * np.log(factor), -LARGEST, LARGEST)))


def _scaled(body: Body, joints: Joints, factors: dict[str, float]) -> Body:
    names = body.names
    for left, right in zip(joints.limbs[::2], joints.limbs[1::2], strict=True):
        for one, other in ((left.upper, right.upper), (left.lower, right.lower)):
            factor = factors.get(names[one.part], 1.0)
            for part in (one.part, other.part):
                body = resized(body, names[part], length_factor=factor, linked=False)
    chest = names[joints.parts[place_of("left", "shoulder")]]
    body = resized(body, chest, length_factor=factors.get(_TRUNK, 1.0))
    for arm in joints.limbs[:2]:
        x, y, z = body.parts[arm.upper.part].joint_m
        shoulder = (x * factors.get(_SHOULDERS, 1.0), y, z)
        body = joint_moved(body, names[arm.upper.part], shoulder, linked=False)
    return body


def _ratios(joints: Joints, observed: Observed) -> dict[str, float | None]:
    """By part, and of trunk and shoulders, its length in the landmarks over the body's; None where
    too few frames show it."""
    names = joints.skeleton.body.names
    ratios = {}
    for left, right in zip(joints.limbs[::2], joints.limbs[1::2], strict=True):
        for one, other in ((left.upper, right.upper), (left.lower, right.lower)):
            seen = [_lengths(observed, bone.near, bone.far) for bone in (one, other)]
            ratios[names[one.part]] = _median(np.concatenate(seen), joints.seen_length_m(one))
    ratios[_TRUNK] = _trunk(joints, observed)
    a, b = (place_of(side, "shoulder") for side in SIDES)
    ours = float(np.linalg.norm(joints.rest[a] - joints.rest[b]))
    ratios[_SHOULDERS] = _median(_lengths(observed, a, b), ours)
    return ratios


def _trunk(joints: Joints, observed: Observed) -> float | None:
    """From the middle of the hips to that of the shoulders."""
    hips, shoulders = ([place_of(side, name) for side in SIDES] for name in ("hip", "shoulder"))
    sure = observed.usable & (observed.visibility[:, hips + shoulders].min(axis=1) >= SURE)
    p = observed.p_hips[sure]
    own = np.linalg.norm(p[:, shoulders].mean(1) - p[:, hips].mean(1), axis=-1)
    ours = np.linalg.norm(joints.rest[shoulders].mean(0) - joints.rest[hips].mean(0))
    return _median(own, float(ours))


def _lengths(observed: Observed, near: int, far: int) -> Array:
    sure = observed.usable & (observed.visibility[:, [near, far]].min(axis=1) >= SURE)
    p = observed.p_hips[sure]
    return np.asarray(np.linalg.norm(p[:, far] - p[:, near], axis=-1))


def _median(lengths: Array, ours: float) -> float | None:
    return float(np.median(lengths)) / ours if len(lengths) >= FEWEST else None
