"""The last solve of a session's motion, see `keypose.tracker.space.solve`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import joined
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.session.pins import Pin, sole_of
from keypose.tracker.session.results import PinResult
from keypose.tracker.session.schema import Session
from keypose.tracker.space.contacts import proposed_pins
from keypose.tracker.space.findings import MotionInSpace, space_findings
from keypose.tracker.space.result import SpaceResult
from keypose.tracker.space.solve import PinnedPoint, SpaceProblem, SpaceSolution, solve_space
from keypose.tracker.storage.stretches import SegmentRun, keyframes_within
from keypose.tracker.storage.tracking import keyed_parts

UP = (0.0, -1.0, 0.0)
CONTRADICTS_M = 0.01
"""A pin that is farther off at an exact keyframe contradicts it."""


def solved(
    session: Session, stretch: SegmentRun, cancelled: Callable[[], bool] | None = None
) -> SpaceResult:
    """The motion of a stretch in space; where it is cancelled that which was found until then."""
    skeleton = Skeleton.of(session.body)
    first, last = stretch.span
    keyframes = keyframes_within(session, first, last)
    exact = [keyframe.frame for keyframe in keyframes if not keyframe.soft]
    problem = SpaceProblem(
        skeleton=skeleton,
        camera=session.camera.without_distortion(),
        motion=joined([segment.trajectory for segment in stretch.segments]),
        observability=np.concatenate(
            [segment.diagnostics.observability for segment in stretch.segments]
        ),
        keyframes=[keyframe.frame for keyframe in keyframes],
        frames_per_second=_frames_per_second(keyframes),
        soft=[keyframe.frame for keyframe in keyframes if keyframe.soft],
        keyed_parts=[k for k in keyed_parts(session, skeleton) if first < k.frame < last],
        pins=[point for _, point in _pinned_points(session, stretch.pins)],
        smooth=bool(session.settings.smooth),
        up_camera=up_of(session),
        floor_m=session.floor_m,
    )
    found = solve_space(problem, cancelled)
    pins = tuple(_pin_results(session, stretch.pins, found, exact))
    up = None if session.up_camera is None else up_of(session)
    still = proposed_pins(skeleton, found.motion, problem.frames_per_second, up)
    free = tuple(pin for pin in still if not any(pin.overlaps(held) for held in stretch.pins))
    body = session.body
    feet = [pin for pin in stretch.pins if sole_of(body.parts[body.index(pin.part)])]
    judged = MotionInSpace(
        skeleton,
        problem.camera,
        found.motion,
        problem.motion,
        problem.frames_per_second,
        stances=[*feet, *free],
        pinned=[True] * len(feet) + [False] * len(free),
        keyframes=exact,
        soft=problem.soft,
        up_camera=up,
        floor_m=found.floor_m if session.floor_m is None else session.floor_m,
    )
    return SpaceResult(stretch.key, found.motion, pins, free, space_findings(judged), found.floor_m)


def up_of(session: Session) -> Array:
    """The unit vector up in the camera frame."""
    up = np.array(session.up_camera or UP, dtype=np.float64)
    return np.asarray(up / np.linalg.norm(up))


def _frames_per_second(keyframes: Sequence[Keyframe]) -> float:
    """Return the frame rate; of a film whose rate varies the mean."""
    one, other = keyframes[0], keyframes[-1]
    return (other.frame - one.frame) / (other.time_s - one.time_s)


def _pinned_points(session: Session, pins: Sequence[Pin]) -> Iterator[tuple[Pin, PinnedPoint]]:
    """List pinned points; on the floor only where up is known: a wrong floor would move feet."""
    upright = session.up_camera is not None
    for pin in pins:
        part = session.body.index(pin.part)
        for point in pin.points(session.body):
            yield pin, PinnedPoint(part, point, *pin.span, pin.floor and upright)


def _pin_results(
    session: Session, pins: Sequence[Pin], found: SpaceSolution, exact: Sequence[int]
) -> Iterator[PinResult]:
    """Report of every pin the point that strays most. exact: frames of keyframes that are met
    exactly.
    """
    off = [
        (pin, distance)
        for (pin, _), distance in zip(_pinned_points(session, pins), found.off_m, strict=True)
    ]
    for pin in pins:
        worst = max((d for owner, d in off if owner is pin), key=np.max)
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


def _contradicted(pin: Pin, off_m: Array, exact: Sequence[int]) -> list[int]:
    """The exact keyframes at which a pin is far off, the worst first."""
    at = {frame: off_m[frame - pin.first_frame] for frame in exact if _holds(pin, frame)}
    far = [frame for frame in at if at[frame] > CONTRADICTS_M]
    return sorted(far, key=lambda frame: -at[frame])


def _holds(pin: Pin, frame: int) -> bool:
    return pin.first_frame <= frame <= pin.last_frame
