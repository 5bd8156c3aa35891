"""Estimate what is up in a session, by all that its film and its motion show."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, joined
from keypose.tracker.geometry.up import (
    MOST_APART,
    Disagreement,
    UpEstimate,
    UpEvidence,
    apart_by,
    combined,
)
from keypose.tracker.operations.solve_space import stances
from keypose.tracker.session.pins import Pin, pins_apart, pins_within, sole_of
from keypose.tracker.session.schema import Session
from keypose.tracker.solver.sigmas import LEAN_RAD
from keypose.tracker.space.level import HELD_LEVEL, evidence_of_standing
from keypose.tracker.storage.fingerprints import Span
from keypose.tracker.storage.stretches import stretches
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.video.upright_lines import UprightLines

SET_RAD: Final = np.radians(1.0)
"""Of up that somebody set: a horizon is drawn to a few pixels, if it is seen."""


MOST_SIGMA_RAD: Final = np.radians(15.0)
"""Of the surest source. Less sure, it says no more than how cameras are held."""
MOST_SLOPE_RAD: Final = np.radians(15.0)
"""Of a floor that feet are taken to stand on level, by how the body is upright."""
SLOPE_SIGMAS: Final = 2.0
"""Standard deviations of where feet stand that a slope is at least."""


def estimated_up(
    session: Session, motions: Mapping[Span, Trajectory], up_evidence: UpEvidence | None = None
) -> UpEstimate | None:
    """Up in the world by all sources that agree, and those that disagree; what somebody set stays
    as it is. None where nothing shows it.

    motions: as tracked, in the world.  up_evidence: what upright lines of the film show, in the
    world, where they were looked for.
    """
    evidence = (
        *(() if up_evidence is None else (up_evidence,)),
        *evidence_of_motion(session, motions),
    )
    if not session.has_up_of_hand:
        up_estimate = _without_stairs(combined(evidence, HELD_LEVEL))
        return (
            up_estimate
            if up_estimate is not None and up_estimate.used[0].sigma_rad < MOST_SIGMA_RAD
            else None
        )
    chosen = UpEvidence.of(session.world.up, _set_rad(session), "set")
    off = [
        Disagreement(source, apart_by(source, chosen.up, chosen.precision)) for source in evidence
    ]
    apart = tuple(disagreement for disagreement in off if disagreement.sigmas >= MOST_APART)
    return UpEstimate(chosen.up, chosen.precision, (chosen,), apart)


def _set_rad(session: Session) -> float:
    """The standard deviation of up as somebody set it, or chose it of what was found; sessions once
    did not say it of feet that a person levelled."""
    world = session.world
    return world.up_sigma_rad or (LEAN_RAD if world.up_from else SET_RAD)


def _without_stairs(up_estimate: UpEstimate | None) -> UpEstimate | None:
    """The estimate without feet that disagree with how the body is upright, or that stand on a
    slope by it: stairs and hills show as one floor, and feet are the surer the farther up they go.
    Upright lines that agree with the feet bear them out."""
    if up_estimate is None or "lines" in up_estimate.sources:
        return up_estimate
    apart = {disagreement.evidence.source: disagreement for disagreement in up_estimate.apart}
    used = {up_evidence.source: up_evidence for up_evidence in up_estimate.used}
    person = used.get("person") or (apart["person"].evidence if "person" in apart else None)
    if "feet" not in used or person is None:
        return up_estimate
    feet = used.pop("feet")
    rest = combined(tuple(used.values()) if "person" in used else (person,), HELD_LEVEL)
    assert rest is not None
    slope_rad, sigma_rad = feet.off_where_surest(rest.up)
    is_slope = slope_rad > max(MOST_SLOPE_RAD, SLOPE_SIGMAS * sigma_rad)
    if "person" in used and not is_slope:
        return up_estimate
    others = tuple(one for one in up_estimate.apart if one.evidence is not person)
    off = Disagreement(feet, apart_by(feet, rest.up, rest.precision))
    return replace(rest, apart=(*others, off))


def evidence_of_lines(session: Session, lines: Mapping[int, UprightLines]) -> UpEvidence | None:
    """What upright lines show, in the world, by the frame of a camera that moves in which they are
    seen. They are those of one place, and lean alike: many frames are no surer than one."""
    path = session.camera_path
    line_evidence = [
        upright_lines.evidence
        if path is None
        else upright_lines.evidence.turned(path.Ts_world_camera[frame, :3, :3])
        for frame, upright_lines in lines.items()
    ]
    up_estimate = combined(line_evidence)
    if up_estimate is None:
        return None
    return UpEvidence(up_estimate.up, up_estimate.precision / len(up_estimate.used), "lines")


def evidence_of_motion(
    session: Session, motions: Mapping[Span, Trajectory]
) -> tuple[UpEvidence, ...]:
    """What the longest motion shows. How a person stands shows nothing where drafts were balanced
    over their feet for an up that was known: it would only repeat that. A camera that moves nobody
    knows how turns all that is seen by it, which then shows nothing."""
    if not motions or session.has_unknown_motion:
        return ()
    longest = max(motions.values(), key=len)
    standing = evidence_of_standing(
        Skeleton.of(session.subject.body), longest, _soles(session, longest), lens_spread(session)
    )
    drafted = session.subject.drafted
    is_balanced = drafted is not None and drafted.up_camera is not None
    return tuple(
        up_evidence for up_evidence in standing if up_evidence.source != "person" or not is_balanced
    )


def _soles(session: Session, motion: Trajectory) -> list[Pin]:
    """Feet that stand whole within a motion: those that are pinned, and others that seem to."""
    body = session.subject.body
    span = motion.first_frame, motion.last_frame
    pinned = [
        pin
        for pin in pins_within(session.subject.pins, span)
        if sole_of(body.parts[body.index(pin.part)]) and pin.landmarks[1:]
    ]
    proposed = [
        pin
        for pin in stances(session, motion, None)
        if pin.landmarks[1:] and not any(pin.overlaps(pinned_already) for pinned_already in pinned)
    ]
    return list(pins_apart([*pinned, *proposed]))


def motions_of(session: Session, fitting: Mapping[Span, SegmentResult]) -> dict[Span, Trajectory]:
    """What was tracked, by stretches, in the world."""
    film_camera = session.film_camera
    return {
        run.span: film_camera.motion_to_world(joined([each.trajectory for each in run.segments]))
        for run in stretches(session, fitting)
    }


def lens_spread(session: Session) -> float:
    """The standard deviation of the focal length as a share of it: usual lenses lie within two."""
    return (session.view.depth_share or 0.0) / 2
