"""Stand a tracked session on its floor: contacts as pins, keyframes that give way, up and floor."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import SessionError
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.up import UpEstimate, UpEvidence
from keypose.tracker.operations.find_up import estimated_up, motions_of
from keypose.tracker.operations.kept_pins import without_harm
from keypose.tracker.operations.solve_space import stances, unscaled_spans
from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.session.pins import Pin, pins_apart, pins_within, sole_of
from keypose.tracker.session.schema import Session
from keypose.tracker.space.harm import Harm
from keypose.tracker.space.level import leaning_rad
from keypose.tracker.space.soles import by_contact, foot_heights
from keypose.tracker.storage.fingerprints import Span
from keypose.tracker.storage.outdated import outdated_words
from keypose.tracker.storage.stretches import keyframes_within
from keypose.tracker.storage.tracks import Tracks
from keypose.tracker.tracking.result import SegmentResult

STEP_M = 0.25
NEARER = 0.1
"""A foot that stands so much higher than most stands on something else than the floor; unless the
floor lies behind it in the picture by such a share of its distance: depth is wrong by that."""
UPSIDE_DOWN_RAD: Final = np.radians(60.0)


@dataclass(frozen=True, eq=False)
class Standing:
    """What a session becomes, and what that changed.

    taken: contacts that were proposed and are pins now.  on_floor: pins on the floor.
    softened: frames of keyframes that give way in depth now.  raised: feet that stand higher.
    up: as it was known or found before the floor tilted.
    released: what contacts that were proposed would have done, and are no pins for it.  harms:
    what each pin does.  hanging: feet that stand still above the floor unpinned, and by
    how many metres.  tilted_rad: by how much the floor is tilted beside what was known of up.
    scaled: whether the scale of the camera's way was found.
    unscaled: frames over which that has none, and nothing was pinned.
    """

    session: Session
    taken: int
    on_floor: int
    softened: tuple[int, ...]
    raised: tuple[Pin, ...]
    up: UpEstimate
    released: tuple[Harm, ...]
    harms: tuple[Harm, ...]
    hanging: tuple[tuple[Pin, float], ...]
    tilted_rad: float
    scaled: bool
    unscaled: tuple[Span, ...]


def stand(
    session: Session,
    fitting: Mapping[Span, SegmentResult],
    up_evidence: UpEvidence | None = None,
    cancelled: Callable[[], bool] | None = None,
    motion: Tracks | None = None,
    *,
    tilts: bool = True,
) -> Standing:
    """Stand the session on its floor; SessionError in one sentence where nobody stands.

    fitting: what was tracked, by segment.  up_evidence: what upright lines of the film show
    of up, in the world.  motion: as it was saved, for why it is out of date.  tilts: whether the
    floor may, beside what is known of up, and its height is found: where another body stands both
    stay.
    """
    _require_standable(session)
    smooth = session.settings.model_copy(update={"smooth": True})
    as_found = session.view.camera_motion
    session = _with_scale(session.changed({"settings": smooth}), fitting)
    motions = motions_of(session, fitting)
    if not motions:
        raise SessionError(_why_nothing_stands(session, fitting, motion))
    _require_scale(session, motions)
    session, up = _levelled(session, motions, up_evidence)
    pinned_before = len(session.subject.pins)
    pins, raised = _on_floor(session, _contacts(session, motions), motions)
    softened = tuple(
        k.frame for span in motions for k in keyframes_within(session, *span) if not k.soft
    )
    keyframes = tuple(_softened(k) if k.frame in softened else k for k in session.subject.keyframes)
    floor_m = None if tilts else session.world.floor_m
    stood = session.changed({"pins": pins, "keyframes": keyframes, "floor_m": floor_m})
    kept = without_harm(stood, pins[pinned_before:], fitting, cancelled, tilts=tilts)
    pins = kept.session.subject.pins
    return Standing(
        session=kept.session,
        taken=len(pins) - pinned_before,
        on_floor=sum(pin.floor for pin in pins),
        softened=tuple(sorted(set(softened))),
        raised=tuple(pin for pin in raised if pin in pins),
        up=up,
        released=kept.released,
        harms=kept.harms,
        hanging=kept.hanging(),
        tilted_rad=float(np.arccos(np.clip(kept.session.world.up @ session.world.up, -1.0, 1.0))),
        scaled=session.view.camera_motion != as_found,
        unscaled=tuple(unscaled_spans(session)),
    )


def in_standing_order(
    session: Session, fittings: Mapping[str, Mapping[Span, SegmentResult]]
) -> list[str]:
    """The ids of bodies as they are to be stood on one floor, that of the first: whose distance
    several films show, then who walks farthest, shows best where it lies, and who stands still at a
    wrong distance tilts it.

    fittings: what was tracked, by segment, by the body's id.
    """

    def films(body_id: str) -> int:
        return sum(view.keypoints is not None for view in session.about(body_id).views)

    def walked_m(body_id: str) -> float:
        motions = motions_of(session.about(body_id), fittings[body_id]).values()
        return max(
            (float(np.linalg.norm(np.ptp(m.ps_camera_root, axis=0))) for m in motions), default=0.0
        )

    return sorted(fittings, key=lambda body_id: (-films(body_id), -round(walked_m(body_id), 1)))


def with_things_along(
    session: Session, standing: Collection[str]
) -> tuple[Session, tuple[str, ...]]:
    """A session in which bodies were stood, and the ids of the things that go along with those who
    hold them: their keyframes give way in depth, so that they meet where both are now.

    standing: the ids of the bodies that were stood.
    """
    along = [
        bond
        for bond in session.bonds
        if bond.holder.body in standing and bond.held.body not in standing
        if bond.moves != "holder"
    ]
    for bond in along:
        about = session.about(bond.held.body)
        spans = [span for span in about.spans if bond.overlaps(span)]
        frames = {k.frame for span in spans for k in keyframes_within(about, *span)}
        keyframes = tuple(
            _softened(k) if k.frame in frames and not k.soft else k for k in about.subject.keyframes
        )
        session = about.changed({"keyframes": keyframes}).about(session.subject.id)
    return session, tuple(dict.fromkeys(bond.held.body for bond in along))


def _why_nothing_stands(
    session: Session, fitting: Mapping[Span, SegmentResult], motion: Tracks | None
) -> str:
    """Why no segment can be stood on the floor, and what to do."""
    finished = [segment_result for segment_result in fitting.values() if segment_result.finished]
    if any(result.quality == "preview" for result in finished):
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
    from keypose.tracker.operations.find_camera import with_scale  # loads what only this needs

    return with_scale(session, fitting)


def _require_scale(session: Session, motions: Mapping[Span, Trajectory]) -> None:
    unknown = unscaled_spans(session)
    if all(any(a <= first and last <= b for a, b in unknown) for first, last in motions):
        raise SessionError(
            "How far the camera went is not known, so no foot can be said to stand still: say how "
            "far it went, or pin a foot where it stands for some time, and stand again."
        )


def _require_standable(session: Session) -> None:
    if session.view.surface is not None:
        raise SessionError("A body fitted to surfaces stands where they do.")
    if session.settings.method != "keypose":
        raise SessionError("The published method has no pins: choose the method keypose.")
    if not any(sole_of(part) for part in session.subject.body.parts):
        raise SessionError(f"The body {session.subject.body.name!r} has no feet with heel and toe.")


def _levelled(
    session: Session, motions: Mapping[Span, Trajectory], up_evidence: UpEvidence | None
) -> tuple[Session, UpEstimate]:
    """The session with what is up, and what that rests on."""
    skeleton = Skeleton.of(session.subject.body)
    longest = max(motions.values(), key=len)
    up_estimate = estimated_up(session, motions, up_evidence)
    if up_estimate is None and session.has_unknown_motion:
        raise SessionError(
            "The camera moves, and how is not known, so nothing shows what is up: find its motion "
            "or set the horizon first."
        )
    if up_estimate is None:
        raise SessionError(
            "Nobody stands upright here, and what is up is not known: set the horizon first."
        )
    if session.has_up_of_hand:
        if leaning_rad(skeleton, longest, up_estimate.up) > UPSIDE_DOWN_RAD:
            raise SessionError(
                "By what is set as up the body lies, or stands on its head: set the horizon again."
            )
        return session, up_estimate
    feet = next(
        (
            disagreement.evidence
            for disagreement in up_estimate.apart
            if disagreement.evidence.source == "feet"
        ),
        None,
    )
    if feet is not None and "lines" not in up_estimate.sources:
        slope = np.degrees(feet.off_where_surest(up_estimate.up)[0])
        raise SessionError(
            f"Feet stand on a slope of {slope:.0f}° by how the body is upright, as on stairs: set "
            "the horizon first."
        )
    return session.with_up_found(up_estimate), up_estimate


def _contacts(session: Session, motions: Mapping[Span, Trajectory]) -> tuple[Pin, ...]:
    """The session's pins and those that are proposed beside them; what turns on its toe is held
    there alone."""
    skeleton, up = Skeleton.of(session.subject.body), session.world.up
    pins = list(session.subject.pins)
    for motion in motions.values():
        for pin in stances(session, motion, up):
            if not any(pin.overlaps(pinned_already) for pinned_already in session.subject.pins):
                pins += by_contact(skeleton, motion, pin, up)
    return pins_apart(pins)


def _on_floor(
    session: Session, pins: Sequence[Pin], motions: Mapping[Span, Trajectory]
) -> tuple[tuple[Pin, ...], tuple[Pin, ...]]:
    """All pins, feet on the floor but those far above most of them; and these. SessionError where
    no foot stands."""
    skeleton, up = Skeleton.of(session.subject.body), session.world.up
    high: dict[int, float] = {}
    falls: dict[int, float] = {}
    for place, pin in enumerate(pins):
        held = [
            (motion, each)
            for span, motion in motions.items()
            for each in pins_within([pin], span)
            if each.holds_sole(session.subject.body)
        ]
        if held:
            heights = [foot_heights(skeleton, motion, each, up) for motion, each in held]
            high[place] = float(np.median(np.concatenate(heights)))
            falls[place] = _fall_m(session, *held[0], up)
    if not high:
        raise SessionError("No foot stands still anywhere: there is no floor to stand on.")
    usual = float(np.median(list(high.values())))
    raised = {
        place
        for place, height in high.items()
        if height - usual > max(STEP_M, NEARER * falls[place])
    }
    placed = tuple(
        pin.model_copy(update={"floor": place not in raised}) if place in high else pin
        for place, pin in enumerate(pins)
    )
    return placed, tuple(pins[place] for place in sorted(raised))


def _fall_m(session: Session, motion: Trajectory, pin: Pin, up: Array) -> float:
    """How far below the camera a foot stands: were it farther away by a share of its distance, and
    seen at the same place, it would be lower by that share of this."""
    row = pin.first_frame - motion.first_frame
    eyes = session.film_camera.eyes(motion)
    eye = np.zeros(3) if eyes is None else eyes[row]
    part = session.subject.body.index(pin.part)
    place = motion.transforms(Skeleton.of(session.subject.body))[row, part, :3, 3]
    return float((eye - place) @ up)


def _softened(keyframe: Keyframe) -> Keyframe:
    return keyframe.model_copy(update={"soft": "depth"})
