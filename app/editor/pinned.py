"""What is pinned: at a frame, by which points, and what is proposed."""

from __future__ import annotations

import numpy as np

from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.posing import handles
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.session.pins import Pin, sole_of
from keypose.tracker.session.results import PinResult
from keypose.tracker.session.schema import Session


def default_landmarks(body: Body, part: str) -> tuple[str, ...]:
    """Heel and toe of a foot; of anything else none, which is its joint."""
    return sole_of(body.parts[body.index(part)]) if part in body.names else ()


def corner_near(
    state: EditorState, part: str, frame: int, uv: tuple[float, float]
) -> tuple[float, float, float]:
    """The vertex of a part, in its frame, that is seen nearest to a pixel; the nearer of two."""
    i = state.doc.body.index(part)
    vertices = np.asarray(state.doc.body.parts[i].shape.mesh().vertices)
    T = pose_transforms(state.skeleton, shown_pose(state, frame).pose)[i]
    p = vertices @ T[:3, :3].T + T[:3, 3]
    off = np.linalg.norm(state.doc.camera.project(p) - uv, axis=1) + p[:, 2]
    x, y, z = vertices[int(np.nanargmin(off))].tolist()
    return x, y, z


def shares_points(one: Pin, other: Pin) -> bool:
    """Whether two pins hold a point in common, whatever their frames."""
    span = {"first_frame": one.first_frame, "last_frame": one.last_frame}
    return one.overlaps(other.model_copy(update=span))


def pins_at(session: Session, frame: int) -> tuple[Pin, ...]:
    """The pins that hold something at a frame."""
    return tuple(pin for pin in session.pins if pin.first_frame <= frame <= pin.last_frame)


def pinned_ends(session: Session, frame: int) -> frozenset[str]:
    """Names of the handles, hands and feet, that are pinned at a frame."""
    parts = {pin.part for pin in pins_at(session, frame)}
    known = handles(session.body) if parts else ()
    return frozenset(
        handle.name for handle in known if handle.kind == "end" and handle.part in parts
    )


def open_proposals(state: EditorState) -> tuple[Pin, ...]:
    """What is proposed and neither pinned in some way nor dismissed."""
    answered = (*state.doc.pins, *state.dismissed_pins)
    return tuple(
        pin for pin in state.proposals if not any(pin.overlaps(known) for known in answered)
    )


def pin_result(state: EditorState, pin: Pin) -> PinResult | None:
    """How well this very pin holds where the motion is solved for; None where it is not yet."""
    found = [one for stretch in state.results.space(state.settled) for one in stretch.pins]
    own = [
        one
        for one in found
        if (one.part, one.landmarks) == (pin.part, pin.landmarks)
        and pin.first_frame <= one.first_frame
        and one.last_frame <= pin.last_frame
    ]
    return max(own, key=lambda one: (one.keyframe is not None, one.off_m), default=None)
