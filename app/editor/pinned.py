"""Say what is pinned at a frame, by which points, what is proposed, and how long a pin lasts."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.shown import part_at
from keypose.app.editor.state import EditorState
from keypose.app.posing import handles, part_label
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import part_transforms
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.pins import Pin, sole_of
from keypose.tracker.session.results import PinResult
from keypose.tracker.session.schema import Session


def default_landmarks(body: Body, part: str) -> tuple[str, ...]:
    """Heel and toe of a foot; of anything else none, which is its joint."""
    return sole_of(body.parts[body.index(part)]) if part in body.names else ()


def corner_near(
    state: EditorState, part: str, frame: int, uv: tuple[float, float]
) -> tuple[float, float, float]:
    """The vertex of a part, in its frame, that is seen nearest to a pixel; the nearer of two.
    Refused where the camera sees none."""
    body, T = state.doc.subject.body, part_at(state, part, frame)
    vertices = np.asarray(body.parts[body.index(part)].shape.mesh().vertices)
    p = vertices @ T[:3, :3].T + T[:3, 3]
    off = np.linalg.norm(state.doc.film_camera.at(frame).project(p) - uv, axis=1) + p[:, 2]
    if not np.isfinite(off).any():
        raise ActionRefused(f"{part_label(part)} cannot be seen at frame {frame}.")
    x, y, z = vertices[int(np.nanargmin(off))].tolist()
    return x, y, z


def shares_points(pin: Pin, other: Pin) -> bool:
    """Whether two pins hold a point in common, whatever their frames."""
    span = {"first_frame": pin.first_frame, "last_frame": pin.last_frame}
    return pin.overlaps(other.model_copy(update=span))


def pins_at(session: Session, frame: int) -> tuple[Pin, ...]:
    """The pins that hold something at a frame."""
    return tuple(pin for pin in session.subject.pins if pin.first_frame <= frame <= pin.last_frame)


def pinned_ends(session: Session, frame: int) -> frozenset[str]:
    """Names of the handles, hands and feet, that are pinned at a frame."""
    parts = {pin.part for pin in pins_at(session, frame)}
    body_handles = handles(session.subject.body) if parts else ()
    return frozenset(
        handle.name for handle in body_handles if handle.kind == "end" and handle.part in parts
    )


def open_proposals(state: EditorState) -> tuple[Pin, ...]:
    """What is proposed and neither pinned in some way nor dismissed."""
    answered = (*state.doc.subject.pins, *state.dismissed_pins)
    return tuple(
        pin
        for pin in state.proposals
        if not any(pin.overlaps(answered_pin) for answered_pin in answered)
    )


def pin_result(state: EditorState, pin: Pin) -> PinResult | None:
    """How well this very pin holds where the motion is solved for; None before."""
    pin_results = [
        result for stretch in state.results.space(state.settled) for result in stretch.pins
    ]
    own = [
        result
        for result in pin_results
        if (result.part, result.landmarks) == (pin.part, pin.landmarks)
        and pin.first_frame <= result.first_frame
        and result.last_frame <= pin.last_frame
    ]
    return max(own, key=lambda result: (result.keyframe is not None, result.off_m), default=None)


LEAST_FRAMES = 5
STILL_M_S = 0.30
"""Below this speed a point stands still; motion along the view is counted less, as it is known
less well."""
DEPTH_SHARE = 0.15
AWAY_M = 0.08
"""A point that drifts this far from where it stood is not where it stood, however slowly."""
SMOOTHED_S = 0.05


def range_to_pin(state: EditorState, pin: Pin, frame: int) -> tuple[int, int]:
    """First and last frame around one at which the pin's points stand still.

    Where nothing is tracked there: the interval between the keyframes around it.
    """
    return still_range(state, pin, frame) or _interval(state, frame)


def still_range(
    state: EditorState, pin: Pin, frame: int, reach: int | None = None
) -> tuple[int, int] | None:
    """The tracked frames around one at which the pin's points stand still; None where it is not
    tracked. reach: how many frames away it is looked at most."""
    count = state.frame_count
    start = 0 if reach is None else max(frame - reach, 0)
    stop = count if reach is None else min(frame + reach + 1, count)
    points = _tracked_points(state, pin, start, stop)
    if not np.isfinite(points[frame - start]).all():
        return None
    eyes = _eyes(state.doc, start, stop)
    steps_s = np.diff(state.times_s[start:stop])
    first, last = _still_around(points, eyes, steps_s, frame - start)
    return start + first, start + last


def _tracked_points(state: EditorState, pin: Pin, start: int, stop: int) -> Array:
    """(stop − start, points, 3) in the world, metres; NaN where nothing is tracked."""
    held = np.array(pin.points(state.doc.subject.body))
    part = state.doc.subject.body.index(pin.part)
    points = np.full((stop - start, len(held), 3), np.nan)
    for (first, last), segment_result in state.fitting.items():
        begin, end = max(first, start), min(last + 1, stop)
        if begin >= end:
            continue
        rows, path = slice(begin - first, end - first), segment_result.trajectory
        Ts = part_transforms(state.skeleton, path.Rs_parent_part[rows], path.ps_camera_root[rows])
        Ts = state.doc.film_camera.parts_to_world(Ts[:, part], np.arange(begin, end))
        ps_world = held @ Ts[:, :3, :3].transpose(0, 2, 1) + Ts[:, None, :3, 3]
        ps_world[~segment_result.tracked[rows]] = np.nan
        points[begin - start : end - start] = ps_world
    return points


def _eyes(doc: Session, start: int, stop: int) -> Array:
    """(stop − start, 3) where the camera is in the world, metres."""
    path = doc.camera_path
    if path is None:
        return np.zeros((stop - start, 3))
    return path.between(start, stop - 1).Ts_world_camera[:, :3, 3]


def _still_around(points: Array, eyes: Array, steps_s: Array, frame: int) -> tuple[int, int]:
    if not len(steps_s):
        return frame, frame
    slow, near = _is_slow(points, eyes, steps_s), _is_near(points, eyes, frame)
    first = last = frame
    while first > 0 and slow[first - 1] and near[first - 1]:
        first -= 1
    while last < len(slow) and slow[last] and near[last + 1]:
        last += 1
    return first, last


def _is_slow(points: Array, eyes: Array, steps_s: Array) -> NDArray[np.bool_]:
    """(F − 1,) whether all points are slow from one frame to the next."""
    steps = np.diff(points, axis=0)
    speed = _across(steps, points[1:] - eyes[1:, None]).max(axis=1) / steps_s
    half = int(SMOOTHED_S / float(np.median(steps_s)) / 2)
    window = min(2 * half + 1, len(speed))
    return np.asarray(np.convolve(speed, np.full(window, 1 / window), "same") < STILL_M_S)


def _is_near(points: Array, eyes: Array, frame: int) -> NDArray[np.bool_]:
    """(F,) whether all points are about where they are at one frame."""
    return np.asarray(_across(points - points[frame], points - eyes[:, None]).max(axis=1) < AWAY_M)


def _across(steps: Array, rays: Array) -> Array:
    """(N, points) lengths of steps at points, seen along rays; along those they count less."""
    rays = rays / np.linalg.norm(rays, axis=-1, keepdims=True)
    along = (steps * rays).sum(axis=-1)
    across = np.linalg.norm(steps - along[..., None] * rays, axis=-1)
    return np.asarray(across + DEPTH_SHARE * np.abs(along))


def _interval(state: EditorState, frame: int) -> tuple[int, int]:
    """The frames from the keyframe at a frame or before it to the next; the frame alone
    outside of them.
    """
    keys = state.keys
    before = [key for key in keys if key <= frame]
    after = [key for key in keys if key > frame]
    if before and not after and before[-1] == frame and len(before) > 1:
        return before[-2], frame
    return (before[-1], after[0]) if before and after else (frame, frame)
