"""Find what pins do to a motion beside what was seen of it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.pins import Pin
from keypose.tracker.session.results import SpaceFinding
from keypose.tracker.solver.projection import image_points
from keypose.tracker.space.pinned import KNEES

HarmKind: TypeAlias = Literal["picture", "knee"]

MOST_SEEN_PX = 8.0
MOST_SEEN_SHARE = 0.02
"""By which a pin may move a joint of its limb in the picture: pixels, or a share of the body's
height there where that is more."""
MOST_BENT_RAD: Final = np.radians(10.0)
"""By which a pin may bend or straighten the knee of its leg."""
RELEASES: Final[Mapping[HarmKind, float]] = {"picture": 1.0, "knee": 1.5}
"""From which share of these on a contact that was proposed is released. Knees are tracked less
surely: where they squat, pins move them by 11° to where they are."""
USUAL: Final = 0.9
"""The share of a pin's frames in which it moves less: single frames were tracked wrongly."""


@dataclass(frozen=True)
class Harm:
    """What a pin does to a motion: a joint is seen elsewhere, or a knee is bent otherwise.

    amount: pixels of the film that it contradicts most, or radians, of all but a tenth of its
    frames.  share: of what is allowed.
    part, frame: where it is most.
    """

    pin: Pin
    kind: HarmKind
    amount: float
    share: float
    part: str
    frame: int

    @property
    def is_much(self) -> bool:
        """Whether the pin is not to be kept in silence."""
        return self.share > 1.0

    @property
    def is_too_much(self) -> bool:
        """Whether a contact that was proposed is released."""
        return self.share > RELEASES[self.kind]


@dataclass(frozen=True, eq=False)
class InPicture:
    """A motion as tracked, and as it was solved for, before a film's camera.

    heights_px (N,): of the body in the picture.  shows (N,): whether the film shows it; None where
    it does throughout.
    """

    skeleton: Skeleton
    camera: Camera
    tracked: Trajectory
    solved: Trajectory
    heights_px: Array
    shows: NDArray[np.bool_] | None = None

    @cached_property
    def most_px(self) -> Array:
        """(N,) by how much a joint may be seen elsewhere."""
        return np.maximum(MOST_SEEN_PX, MOST_SEEN_SHARE * self.heights_px)

    @cached_property
    def moved_px(self) -> Array:
        """(N, P) by how much every joint is seen elsewhere."""
        uv = [
            image_points(self.camera, motion.transforms(self.skeleton)[..., :3, 3])
            for motion in (self.tracked, self.solved)
        ]
        moved = np.linalg.norm(uv[1] - uv[0], axis=-1)
        return np.asarray(moved if self.shows is None else moved * self.shows[:, None])


@dataclass(frozen=True, eq=False)
class Compared(InPicture):
    """The same in several films.  films: those besides the first, in whose camera's frame the
    motions are."""

    films: Sequence[InPicture] = ()

    @cached_property
    def bent_rad(self) -> Array:
        """(N, P) by how much every part is turned otherwise in its joint."""
        turn = np.swapaxes(self.tracked.Rs_parent_part, -1, -2) @ self.solved.Rs_parent_part
        cos = (np.trace(turn, axis1=-2, axis2=-1) - 1) / 2
        return np.asarray(np.arccos(np.clip(cos, -1.0, 1.0)))


def harms(compared: Compared, pins: Sequence[Pin]) -> tuple[Harm, ...]:
    """What every pin does in the picture, and to a knee; the pins lie within the motion."""
    return tuple(harm for pin in pins for harm in _of_pin(compared, pin))


def harm_findings(compared: Compared, pins: Sequence[Pin]) -> Iterator[SpaceFinding]:
    """What pins do that is not to be kept in silence."""
    for harm in harms(compared, pins):
        if harm.is_much:
            yield SpaceFinding(
                kind="bent" if harm.kind == "knee" else "pulled",
                part=harm.pin.part,
                first_frame=harm.pin.first_frame,
                last_frame=harm.pin.last_frame,
                go=harm.frame,
                amount=harm.amount,
            )


def _of_pin(compared: Compared, pin: Pin) -> Iterator[Harm]:
    skeleton, first = compared.skeleton, compared.tracked.first_frame
    rows = slice(pin.first_frame - first, pin.last_frame + 1 - first)
    limb = _limb(skeleton, skeleton.body.index(pin.part))
    of_films = [
        _worst(compared, pin, "picture", of[rows][:, limb], limb, most_px)
        for of, most_px in _shares(compared)
    ]
    yield max(of_films, key=lambda harm: harm.share)  # in the film that contradicts it most
    knees = [part for part in limb if skeleton.body.names[part] in KNEES]
    if knees:
        bent = compared.bent_rad[rows] / MOST_BENT_RAD
        most = np.full(len(compared.tracked), MOST_BENT_RAD)
        yield _worst(compared, pin, "knee", bent[:, knees], knees, most)


def _shares(compared: Compared) -> Iterator[tuple[Array, Array]]:
    """(N, P) of what joints may be seen elsewhere by, and (N,) that, in every film."""
    for picture in (compared, *compared.films):
        yield picture.moved_px / picture.most_px[:, None], picture.most_px


def _worst(
    compared: Compared,
    pin: Pin,
    kind: HarmKind,
    shares: Array,
    parts: Sequence[int],
    most: Array,
) -> Harm:
    """shares (n, K): of what is allowed, most (N,), at a pin's frames."""
    usual = np.quantile(shares, USUAL, axis=0)
    k = int(usual.argmax())
    row = int(shares[:, k].argmax())
    at = pin.first_frame - compared.tracked.first_frame + row
    name = compared.skeleton.body.names[parts[k]]
    share = float(usual[k])
    return Harm(pin, kind, share * float(most[at]), share, name, pin.first_frame + row)


def _limb(skeleton: Skeleton, part: int) -> list[int]:
    """A part and those that carry it, but for the root."""
    limb = [part]
    while skeleton.parents[limb[-1]] > 0:
        limb.append(int(skeleton.parents[limb[-1]]))
    return limb


def worst_of_each(pin_harms: Sequence[Harm]) -> tuple[Harm, ...]:
    """The worst harm of every pin, the worst first."""
    ordered = sorted(pin_harms, key=lambda harm: -harm.share)
    return tuple(
        harm for k, harm in enumerate(ordered) if harm.pin not in [h.pin for h in ordered[:k]]
    )


def worst_apart(pin_harms: Sequence[Harm], apart: int) -> tuple[Harm, ...]:
    """Of harms the worst, and those more than so many frames from any that is worse: what lies
    beside it may be its doing."""
    kept: list[Harm] = []
    for harm in worst_of_each(pin_harms):
        a, b = harm.pin.span
        near = any(a - apart <= w.pin.last_frame and b + apart >= w.pin.first_frame for w in kept)
        if not near:
            kept.append(harm)
    return tuple(kept)
