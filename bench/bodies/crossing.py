"""Two rendered people who pass each other, tracked in the film of both and each in one alone.

How much of a loss is the hidden pixels themselves is told by a third run: alone, with the same
regions ignored that the program ignores in the film of both.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np

from bench.bodies.film import SEEDS, Actor, Film, disturbed, hidden_shares, rendered_film, tracked
from bench.bodies.people import FRAMES, passing_by, speaking_before
from bench.bodies.promises import Promise
from bench.table import Report, Table
from bench.tracking import keyframes_every
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.operations.occlusion import ignored_regions
from keypose.tracker.session.settings import IgnoreMask

FILMS: Final[Mapping[str, Callable[[], tuple[Actor, Actor]]]] = {
    "passing": passing_by,
    "speaking": speaking_before,
}
"""Of each film the one behind and the one before them."""
INTERVALS: Final = (24, 36)
LEAST_HIDDEN_FRAMES: Final = 20
MOST_RATIO: Final = 1.2


@dataclass(frozen=True, eq=False)
class Passing:
    """A film of two, and one of each alone."""

    both: Film
    alone: Mapping[str, Film]

    @classmethod
    def rendered(cls, name: str) -> Passing:
        actors = FILMS[name]()
        alone = {actor.id: rendered_film(f"{name}-{actor.id}", (actor,)) for actor in actors}
        return cls(rendered_film(name, actors), alone)


@dataclass(frozen=True)
class Off:
    """Mean distances of joints between keyframes, cm: in the film of both, alone, and alone where
    what is hidden in the film of both is ignored.

    exchanged: frames in which the joints are nearer to those of the other one in the picture.
    """

    both: float
    alone: float
    hidden: float
    exchanged: int


def crossing(report: Report) -> list[Promise]:
    columns = ("both cm", "alone cm", "same hidden", "ratio", "to hidden", "exchanged")
    report.note("same hidden: alone, and ignored what the program ignores in the film of both")
    table = report.table("two who pass each other, beside each alone", *columns, wide=("ratio",))
    promises: list[Promise] = []
    exchanged = 0
    for name in FILMS:
        films = Passing.rendered(name)
        far, near = films.both.actors
        hidden = int((hidden_shares(far, near, films.both.camera) > 0).sum())
        words = "finds" if films.both.stands_still else "does not find"
        report.note(f"{name}: hidden over {hidden} frames; it {words} that the camera stands still")
        promises.append(Promise.at_least(f"{name}: frames hidden", hidden, LEAST_HIDDEN_FRAMES))
        for kind, seeds in (("exact", (None,)), ("disturbed", SEEDS)):
            ratios = []
            for interval in INTERVALS:
                for actor in films.both.actors:
                    rows = [_off(films, actor, interval, seed) for seed in seeds]
                    ratios.append(_write(table, f"{name} {interval} {kind} {actor.id}", rows))
                    exchanged += sum(row.exchanged for row in rows)
            worst = f"{name}, {kind}: beside alone"
            promises.append(Promise.at_most(worst, max(ratios), MOST_RATIO))
    return [*promises, Promise.at_most("frames nearer to the other", exchanged, 0)]


def _write(table: Table, name: str, rows: list[Off]) -> float:
    """One line, and its ratio: of means over all disturbances, whose own spread stands beside."""
    both, alone, hidden = (
        float(np.mean([getattr(row, which) for row in rows]))
        for which in ("both", "alone", "hidden")
    )
    ratios = [row.both / row.alone for row in rows]
    spread = f"{both / alone:.2f} ({min(ratios):.2f}–{max(ratios):.2f})"
    exchanged = sum(row.exchanged for row in rows)
    table.row(name, both, alone, hidden, spread, both / hidden, exchanged)
    return both / alone


def _off(films: Passing, actor: Actor, interval: int, seed: int | None) -> Off:
    frames = keyframes_every(interval, 0, FRAMES - 1)
    keyposes = disturbed(films.both, films.both.keyposes(frames), seed)
    session = films.both.session(keyposes).about(actor.id)
    motions = [segment.trajectory for segment in tracked(session, films.both.video)]
    film, own = films.alone[actor.id], {actor.id: keyposes[actor.id]}
    alone = _alone(film, own)
    hidden = _alone(film, own, ignored_regions(session))
    other = next(each for each in films.both.actors if each is not actor)
    exchanged = sum(exchanged_frames(m, actor, other, films.both.camera) for m in motions)
    return Off(_cm(motions, actor), _cm(alone, actor), _cm(hidden, actor), exchanged)


def _alone(
    film: Film, keyposes: Mapping[str, Mapping[int, Pose]], ignored: tuple[IgnoreMask, ...] = ()
) -> list[Trajectory]:
    session = film.session(keyposes).changed({"ignore_masks": ignored})
    return [segment.trajectory for segment in tracked(session, film.video)]


def _cm(motions: list[Trajectory], actor: Actor) -> float:
    """The mean distance of joints from the truth, strictly between keyframes."""
    off = [
        np.linalg.norm(motion.joints(actor.skeleton) - _rows(actor.joints, motion), axis=-1)[1:-1]
        for motion in motions
    ]
    return 100 * float(np.concatenate(off).mean())


def exchanged_frames(motion: Trajectory, own: Actor, other: Actor, lens: Camera) -> int:
    """In how many frames the joints of a motion lie nearer to the other's than to their own, in the
    picture and in the mean. Both bodies have the same joints."""
    uv = lens.project(motion.joints(own.skeleton))
    own_px, other_px = (
        np.linalg.norm(uv - lens.project(_rows(actor.joints, motion)), axis=-1).mean(axis=1)
        for actor in (own, other)
    )
    return int((other_px < own_px).sum())


def _rows(joints: Array, motion: Trajectory) -> Array:
    """The truth at the frames of a motion."""
    return joints[motion.first_frame : motion.last_frame + 1]
