"""The last solve of a session's motion, see `keypose.tracker.space.solve`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, joined
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.operations.bonds import held_points
from keypose.tracker.operations.track import keyed_parts
from keypose.tracker.session.between_views import T_film_first
from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.session.pins import Pin, pins_within, sole_of
from keypose.tracker.session.results import PinResult
from keypose.tracker.session.schema import Session
from keypose.tracker.space.contacts import proposed_pins
from keypose.tracker.space.findings import MotionInSpace, space_findings
from keypose.tracker.space.harm import Compared, InPicture, harm_findings
from keypose.tracker.space.pinned import PinnedPoint
from keypose.tracker.space.repeated import Moments
from keypose.tracker.space.result import SpaceResult
from keypose.tracker.space.solve import (
    FilmInSpace,
    SpaceProblem,
    SpaceSolution,
    heights_before,
    heights_px,
    solve_space,
)
from keypose.tracker.storage.fingerprints import Span
from keypose.tracker.storage.stretches import SegmentRun, keyframes_within

CONTRADICTS_M = 0.01
"""A pin that is farther off at an exact keyframe contradicts it."""


@dataclass(frozen=True, eq=False)
class Asked:
    """What the solve of a stretch is given.  held: what its pins hold, as they are in the problem.
    moments: where the film repeats pictures."""

    problem: SpaceProblem
    held: tuple[_Held, ...]
    moments: Moments | None


def asked(session: Session, stretch: SegmentRun) -> Asked:
    """What a session asks of the solve of a stretch."""
    skeleton = Skeleton.of(session.subject.body)
    first, last = stretch.span
    keyframes = keyframes_within(session, first, last)
    held = _held(session, stretch.pins)
    keyed = [k for k in keyed_parts(session, skeleton) if first < k.frame < last]
    tracked = joined([segment.trajectory for segment in stretch.segments])
    fixed = [*(keyframe.frame for keyframe in keyframes), *(each.frame for each in keyed)]
    moments = Moments.of(session.view.video.repeats, first, last, fixed)
    path = session.film_camera.path_over(tracked)
    problem = SpaceProblem(
        skeleton=skeleton,
        camera=session.view.camera.without_distortion(),
        motion=tracked if moments is None else _changed_in_world(path, tracked, moments.evened),
        observability=np.concatenate(
            [segment.diagnostics.observability for segment in stretch.segments]
        ),
        keyframes=[keyframe.frame for keyframe in keyframes],
        frames_per_second=_frames_per_second(keyframes),
        soft=[keyframe.frame for keyframe in keyframes if keyframe.soft],
        seen=[keyframe.frame for keyframe in keyframes if keyframe.soft == "depth"],
        keyed_parts=keyed,
        pins=[each.point for each in held],
        smooth=bool(session.settings.smooth),
        up_world=session.world.up,
        floor_m=session.world.floor_m,
        path=path,
        films=films_in_space(session, first, last),
    )
    return Asked(problem, tuple(held), moments)


def films_in_space(session: Session, first: int, last: int) -> tuple[FilmInSpace, ...]:
    """The films of a session but the first, over frames of that."""
    frames, films = np.arange(first, last + 1), []
    for view in session.views[1:]:
        own = view.film_clock.frames_at(frames)
        shows = (own >= 0) & (own <= view.video.frame_count - 1)
        Ts = np.stack([T_film_first(session, view, frame) for frame in frames.tolist()])
        films.append(FilmInSpace(view.camera.without_distortion(), Ts, shows))
    return tuple(films)


def solved(
    session: Session, stretch: SegmentRun, cancelled: Callable[[], bool] | None = None
) -> SpaceResult:
    """The motion of a stretch in space; where it is cancelled that which was found until then."""
    asked_for = asked(session, stretch)
    if stretch.bonds:
        held = held_points(session, stretch.bonds, _free(session, stretch, cancelled))
        asked_for = replace(asked_for, problem=replace(asked_for.problem, held=held))
    problem, moments, skeleton = asked_for.problem, asked_for.moments, asked_for.problem.skeleton
    exact = sorted(set(problem.keyframes) - set(problem.soft))
    space_solution = solve_space(problem, cancelled)
    pins = tuple(_pin_results(stretch.pins, asked_for.held, space_solution, exact))
    up = None if session.world.up_world is None else session.world.up
    in_world = problem.in_world(space_solution.motion)
    rate = problem.frames_per_second
    still = stances(session, in_world, up)
    free = tuple(pin for pin in still if not any(pin.overlaps(held) for held in stretch.pins))
    body = session.subject.body
    feet = [pin for pin in stretch.pins if sole_of(body.parts[body.index(pin.part)])]
    judged = MotionInSpace(
        skeleton,
        problem.camera,
        in_world,
        problem.motion_in_world,
        rate,
        stances=[*feet, *free],
        pinned=[True] * len(feet) + [False] * len(free),
        keyframes=exact,
        soft=problem.soft,
        up_world=up,
        floor_m=space_solution.floor_m if session.world.floor_m is None else session.world.floor_m,
        path=problem.path,
    )
    motion = space_solution.motion
    if moments is not None:
        motion = _changed_in_world(problem.path, motion, moments.shown)
    findings = (
        *space_findings(judged),
        *harm_findings(compared(problem, space_solution), stretch.pins),
    )
    return SpaceResult(stretch.key, motion, pins, free, findings, space_solution.floor_m)


def _free(
    session: Session, stretch: SegmentRun, cancelled: Callable[[], bool] | None
) -> dict[str, Trajectory]:
    """The motions in space of a stretch's body and of those beside it, by id, as they are without
    bonds."""
    alone = {session.subject.id: replace(stretch, bonds=(), beside={})}
    for body_id, segments in stretch.beside.items():
        there = session.about(body_id)
        span = segments[0].first, segments[-1].last
        alone[body_id] = SegmentRun("", tuple(segments), pins_within(there.subject.pins, span))
    return {
        body_id: solve_space(asked(session.about(body_id), run).problem, cancelled).motion
        for body_id, run in alone.items()
    }


def compared(problem: SpaceProblem, space_solution: SpaceSolution) -> Compared:
    """What was solved for beside what was tracked."""
    skeleton, before, after = problem.skeleton, problem.motion, space_solution.motion
    films = []
    for film in problem.films:
        shows, _, (there, solved) = film.shown(skeleton, before, after)
        heights = heights_before(skeleton, film.camera, there)
        films.append(InPicture(skeleton, film.camera, there, solved, heights, shows))
    heights = heights_px(problem, skeleton)
    return Compared(skeleton, problem.camera, before, after, heights, films=films)


def stances(session: Session, motion: Trajectory, up_world: Array | None) -> tuple[Pin, ...]:
    """Pins to propose for feet that stand still in a motion in the world. None where the way of its
    camera has no scale: there what stands still cannot be told from what moves."""
    skeleton, rate = Skeleton.of(session.subject.body), frames_per_second(session, motion)
    pins = proposed_pins(skeleton, motion, rate, up_world, session.film_camera.eyes(motion))
    spans = unscaled_spans(session)
    return tuple(
        pin
        for pin in pins
        if not any(pin.first_frame <= b and pin.last_frame >= a for a, b in spans)
    )


def unscaled_spans(session: Session) -> list[Span]:
    """Over which frames nothing tells how far the camera went."""
    motion = session.view.camera_motion
    camera_findings = () if motion is None else motion.unscaled
    return [
        (camera_finding.first_frame, camera_finding.last_frame)
        for camera_finding in camera_findings
    ]


def _changed_in_world(
    path: CameraPath | None, motion: Trajectory, change: Callable[[Trajectory], Trajectory]
) -> Trajectory:
    """A motion that a camera saw, changed in the world: where a picture is repeated, so is the
    place of the camera."""
    if path is None:
        return change(motion)
    return change(motion.carried(path.Ts_world_camera)).carried(path.Ts_camera_world)


def frames_per_second(session: Session, motion: Trajectory) -> float:
    """The frame rate of a motion between keyframes; where that varies the mean."""
    return _frames_per_second(keyframes_within(session, motion.first_frame, motion.last_frame))


def _frames_per_second(keyframes: Sequence[Keyframe]) -> float:
    keyframe, last = keyframes[0], keyframes[-1]
    return (last.frame - keyframe.frame) / (last.time_s - keyframe.time_s)


@dataclass(frozen=True, eq=False)
class _Held:
    """A point that pins hold, and which of them do."""

    pins: tuple[Pin, ...]
    point: PinnedPoint


def _held(session: Session, pins: Sequence[Pin]) -> list[_Held]:
    """The points that pins hold; on the floor only where up is known: a wrong floor moves feet.

    What two pins that follow one another have in common is one point, as of a foot that goes on
    standing on its toe alone.
    """
    body, upright = session.subject.body, session.world.up_world is not None
    held_points: list[_Held] = []
    for pin in sorted(pins, key=lambda pin: pin.first_frame):
        part = body.index(pin.part)
        for place in pin.points(body):
            above = pin.above_floor_m(body, place) if pin.floor and upright else None
            point = PinnedPoint(part, place, *pin.span, above)
            before = next((held for held in held_points if _goes_on(held, pin, point)), None)
            if before is None:
                held_points.append(_Held((pin,), point))
                continue
            longer = replace(before.point, last_frame=pin.last_frame)
            held_points[held_points.index(before)] = _Held((*before.pins, pin), longer)
    return held_points


def _goes_on(before: _Held, pin: Pin, point: PinnedPoint) -> bool:
    """Whether a pin of other points of the same part holds this one right after another."""
    pinned_point = before.point
    return (
        (pinned_point.part, pinned_point.p_part, pinned_point.above_floor_m)
        == (point.part, point.p_part, point.above_floor_m)
        and pinned_point.last_frame + 1 == point.first_frame
        and before.pins[-1].landmarks != pin.landmarks
    )


def _pin_results(
    pins: Sequence[Pin], held: Sequence[_Held], space_solution: SpaceSolution, exact: Sequence[int]
) -> Iterator[PinResult]:
    """Report of every pin the point that strays most. exact: frames of keyframes that are met
    exactly.
    """
    for pin in pins:
        worst = max(
            (
                distance[pin.first_frame - each.point.first_frame :][: _count(pin)]
                for each, distance in zip(held, space_solution.off_m, strict=True)
                if any(owner is pin for owner in each.pins)
            ),
            key=np.max,
        )
        frame = pin.first_frame + int(np.argmax(worst))
        against = _contradicted(pin, worst, exact)
        yield PinResult(
            part=pin.part,
            landmarks=pin.landmarks,
            first_frame=pin.first_frame,
            last_frame=pin.last_frame,
            off_m=float(worst.max()),
            usual_off_m=float(np.median(worst)),
            frame=frame,
            keyframe=next(iter(against), None),
            others=tuple(sorted(against[1:])),
        )


def _count(pin: Pin) -> int:
    return pin.last_frame - pin.first_frame + 1


def _contradicted(pin: Pin, off_m: Array, exact: Sequence[int]) -> list[int]:
    """The exact keyframes at which a pin is far off, the worst first."""
    at = {frame: off_m[frame - pin.first_frame] for frame in exact if _holds(pin, frame)}
    far = [frame for frame in at if at[frame] > CONTRADICTS_M]
    return sorted(far, key=lambda frame: -at[frame])


def _holds(pin: Pin, frame: int) -> bool:
    return pin.first_frame <= frame <= pin.last_frame
