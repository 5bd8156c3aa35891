"""Stand a tracked session on its floor: contacts as pins, keyframes that give way, up and floor."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, joined
from keypose.tracker.errors import SessionError
from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.session.pins import Pin, pins_apart, pins_within, sole_of
from keypose.tracker.session.schema import Session
from keypose.tracker.solver.sigmas import TILT_GIVES_RAD
from keypose.tracker.space.contacts import proposed_pins
from keypose.tracker.space.level import leaning_rad, up_from_standing
from keypose.tracker.space.soles import by_contact, foot_heights
from keypose.tracker.space.solve import SpaceProblem, solve_space
from keypose.tracker.storage.fingerprints import Span
from keypose.tracker.storage.outdated import outdated_words
from keypose.tracker.storage.space import asked, frames_per_second, up_of
from keypose.tracker.storage.stretches import keyframes_within, stretches
from keypose.tracker.storage.tracks import Tracks
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.video.upright_lines import UprightLines

STEP_M: Final = 0.25
"""A foot that stands so much higher than most stands on something else than the floor."""
UPSIDE_DOWN_RAD: Final = np.radians(60.0)

UpSource: TypeAlias = Literal["known", "lines", "feet"]
"""What up rests on: what the session says, upright lines of the picture, how the person stands."""


@dataclass(frozen=True, eq=False)
class Standing:
    """What a session becomes, and what that changed.

    taken: contacts that were proposed and are pins now.  on_floor: pins on the floor.
    softened: frames of keyframes that give way in depth now.  raised: feet that stand higher.
    """

    session: Session
    taken: int
    on_floor: int
    softened: tuple[int, ...]
    raised: tuple[Pin, ...]
    up_from: UpSource


def stand(
    session: Session,
    fitting: Mapping[Span, SegmentResult],
    lines: UprightLines | None = None,
    cancelled: Callable[[], bool] | None = None,
    motion: Tracks | None = None,
) -> Standing:
    """Stand the session on its floor; SessionError in one sentence where nobody stands.

    fitting: what was tracked, by segment.  lines: upright ones of the film, for where nobody said
    what is up.  motion: as it was saved, for why it is out of date.
    """
    _require_standable(session)
    smooth = session.settings.model_copy(update={"smooth": True})
    session = _with_scale(session.changed({"settings": smooth}), fitting)
    motions = {
        run.span: session.in_world(joined([segment.trajectory for segment in run.segments]))
        for run in stretches(session, fitting)
    }
    if not motions:
        raise SessionError(_why_nothing_stands(session, fitting, motion))
    session, source = _levelled(session, motions, lines)
    pins = _contacts(session, motions)
    taken = len(pins) - len(session.subject.pins)
    pins, raised = _on_floor(session, pins, motions)
    softened = tuple(
        k.frame for span in motions for k in keyframes_within(session, *span) if not k.soft
    )
    keyframes = tuple(_softened(k) if k.frame in softened else k for k in session.subject.keyframes)
    stood = session.changed({"pins": pins, "keyframes": keyframes, "floor_m": None})
    stood = _with_floor(stood, fitting, cancelled)
    on_floor = sum(pin.floor for pin in pins)
    return Standing(stood, taken, on_floor, tuple(sorted(set(softened))), raised, source)


def _why_nothing_stands(
    session: Session, fitting: Mapping[Span, SegmentResult], motion: Tracks | None
) -> str:
    """Why no segment can be stood on the floor, and what to do."""
    finished = [found for found in fitting.values() if found.finished]
    if any(found.quality == "preview" for found in finished):
        return "The motion was tracked as a preview: track it in full first."
    if finished:
        return "Frames are missing in every tracked segment: track one that is whole first."
    if session.subject.results is None and motion is None:
        return "Nothing is tracked yet: track the motion first."
    words = None if motion is None else outdated_words(session, motion)
    fault = (words or "the tracked motion is out of date.").removesuffix(".")
    return f"{fault[0].upper()}{fault[1:]}: track it again first."


def _with_scale(session: Session, fitting: Mapping[Span, SegmentResult]) -> Session:
    """The session with how far its camera went, where that is not known yet."""
    motion = session.view.camera_motion
    if motion is None or not motion.unscaled:
        return session
    from keypose.tracker.storage.camera_motion import with_scale  # loads what only this needs

    return with_scale(session, fitting)


def _require_standable(session: Session) -> None:
    if session.view.surface is not None:
        raise SessionError("A body fitted to surfaces stands where they do.")
    if session.settings.method != "keypose":
        raise SessionError("The published method has no pins: choose the method keypose.")
    if not any(sole_of(part) for part in session.subject.body.parts):
        raise SessionError(f"The body {session.subject.body.name!r} has no feet with heel and toe.")


def _levelled(
    session: Session, motions: Mapping[Span, Trajectory], lines: UprightLines | None
) -> tuple[Session, UpSource]:
    """The session with what is up, and what that rests on."""
    skeleton = Skeleton.of(session.subject.body)
    longest = max(motions.values(), key=len)
    if session.world.up_world is not None:
        if leaning_rad(skeleton, longest, up_of(session)) > UPSIDE_DOWN_RAD:
            raise SessionError(
                "By what is set as up the body lies, or stands on its head: set the horizon again."
            )
        return session, "known"
    if lines is not None:
        return session.with_up(lines.up_camera), "lines"
    rate = frames_per_second(session, longest)
    stances = [
        pin
        for pin in proposed_pins(skeleton, longest, rate, None, session.eyes(longest))
        if pin.landmarks[1:]
    ]
    up = up_from_standing(skeleton, longest, stances)
    if up is None:
        raise SessionError(
            "Nobody stands upright here, and what is up is not known: set the horizon first."
        )
    return session.with_up(up, from_feet=True), "feet"


def _contacts(session: Session, motions: Mapping[Span, Trajectory]) -> tuple[Pin, ...]:
    """The session's pins and those that are proposed beside them; what turns on its toe is held
    there alone."""
    skeleton, up = Skeleton.of(session.subject.body), up_of(session)
    pins = list(session.subject.pins)
    for motion in motions.values():
        rate = frames_per_second(session, motion)
        for pin in proposed_pins(skeleton, motion, rate, up, session.eyes(motion)):
            if not any(pin.overlaps(known) for known in session.subject.pins):
                pins += by_contact(skeleton, motion, pin, up)
    return pins_apart(pins)


def _on_floor(
    session: Session, pins: Sequence[Pin], motions: Mapping[Span, Trajectory]
) -> tuple[tuple[Pin, ...], tuple[Pin, ...]]:
    """All pins, feet on the floor but those far above most of them; and these. SessionError where
    no foot stands."""
    skeleton, up = Skeleton.of(session.subject.body), up_of(session)
    high: dict[int, float] = {}
    for place, pin in enumerate(pins):
        heights = [
            foot_heights(skeleton, motion, held, up)
            for span, motion in motions.items()
            for held in pins_within([pin], span)
            if held.holds_sole(session.subject.body)
        ]
        if heights:
            high[place] = float(np.median(np.concatenate(heights)))
    if not high:
        raise SessionError("No foot stands still anywhere: there is no floor to stand on.")
    usual = float(np.median(list(high.values())))
    raised = {place for place, height in high.items() if height - usual > STEP_M}
    placed = tuple(
        pin.model_copy(update={"floor": place not in raised}) if place in high else pin
        for place, pin in enumerate(pins)
    )
    return placed, tuple(pins[place] for place in sorted(raised))


def _with_floor(
    session: Session,
    fitting: Mapping[Span, SegmentResult],
    cancelled: Callable[[], bool] | None,
) -> Session:
    """The session with the floor with which its longest stretch is solved for: its height, and its
    tilt, which gives way a little."""
    tracked = {span: found.as_tracked for span, found in fitting.items()}
    problems = [asked(session, run).problem for run in stretches(session, tracked)]
    longest = max((p for p in problems if any(pin.floor for pin in p.pins)), key=_frames)
    found = solve_space(replace(longest, tilt_rad=TILT_GIVES_RAD), cancelled)
    x, y, z = found.up_world.tolist()
    assert found.floor_m is not None
    return session.changed({"floor_m": round(found.floor_m, 4), "up_world": (x, y, z)})


def _frames(problem: SpaceProblem) -> int:
    return len(problem.motion)


def _softened(keyframe: Keyframe) -> Keyframe:
    return keyframe.model_copy(update={"soft": "depth"})
