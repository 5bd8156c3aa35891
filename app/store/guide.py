"""The guide through the first pose: which of its steps an action does, in whatever way."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from keypose.app.editor.copy_paste import PastePose
from keypose.app.editor.keyframes import AddKey
from keypose.app.editor.message import Editing, Look
from keypose.app.editor.posing import Angles, Drag, Face, Root, TakeTracked
from keypose.app.editor.update import BeginGuide, CancelStroke, EndStroke, Go
from keypose.app.posing import handles
from keypose.app.posing.gesture import End, Ring, Surface
from keypose.app.state.app_state import Guide
from keypose.tracker.body.body import Body

ENOUGH_ENDS = 4
"""Hands and feet."""


@dataclass(frozen=True)
class _DuringGesture(Guide):
    """The guide as before a gesture that is under way, and as it is `then`, once that ends."""

    stroke: str = ""
    then: Guide = field(default_factory=Guide)


def guide_after(guide: Guide, action: Editing, body: Body) -> Guide:
    """The guide with the steps this action does ticked off; those of a gesture once it ends."""
    if isinstance(action, BeginGuide):
        return Guide(guide.first)
    if isinstance(guide, _DuringGesture):
        if _is_under_way(guide.stroke, action):
            return guide
        before = Guide(guide.first, guide.done, guide.pulled)
        if _stroke_of(action) != guide.stroke:
            guide = guide.then
        elif isinstance(action, EndStroke | CancelStroke):
            return guide.then if isinstance(action, EndStroke) else before
        else:
            guide = before
    then = _with_progress(guide, action, body)
    stroke = _stroke_of(action)
    if stroke is None or then is guide:
        return then
    return _DuringGesture(guide.first, guide.done, guide.pulled, stroke, then)


def _is_under_way(stroke: str, action: Editing) -> bool:
    """Whether this gesture is still under way after the action."""
    if isinstance(action, EndStroke | CancelStroke):
        return action.stroke != stroke
    return isinstance(action, Look) and not isinstance(action, Go)


def _stroke_of(action: Editing) -> str | None:
    return getattr(action, "stroke", None)


def _with_progress(guide: Guide, action: Editing, body: Body) -> Guide:
    if isinstance(action, Drag) and action.at == action.from_:
        return guide  # back where it began
    pulled = guide.pulled | _pulled_ends(action)
    done = guide.done | _steps(action, body.parts[0].name)
    if len(pulled) >= min(ENOUGH_ENDS, _ends_of(body)):
        done |= {"limbs"}
    same = done == guide.done and pulled == guide.pulled
    return guide if same else replace(guide, done=done, pulled=pulled)


def _ends_of(body: Body) -> int:
    return max(1, sum(handle.kind == "end" for handle in handles(body)))


def _pulled_ends(action: Editing) -> frozenset[str]:
    if isinstance(action, Drag) and isinstance(action.handle, End):
        return frozenset({action.handle.name})
    return frozenset()


def _steps(action: Editing, root: str) -> frozenset[str]:
    if isinstance(action, Drag):
        return _dragged(action, root)
    if isinstance(action, Root):
        return frozenset({"hips"} if action.z is None else {"height"})
    if isinstance(action, Face) or (isinstance(action, Angles) and action.part == root):
        return frozenset({"facing"})
    if isinstance(action, PastePose | TakeTracked):
        return frozenset({"limbs"})
    if isinstance(action, AddKey):
        return frozenset({"key"})
    return frozenset()


def _dragged(action: Drag, root: str) -> frozenset[str]:
    """The whole body's distance is its size in the picture; of the limbs, depth is depth."""
    handle, aside = action.handle, action.view in ("top", "side")
    if handle.kind == "root" or (isinstance(handle, Surface) and handle.tool == "move"):
        return frozenset({"height"} if action.depth or aside else {"hips"})
    if isinstance(handle, Ring) and handle.part == root:
        return frozenset({"facing"})
    if isinstance(handle, End) and (action.depth or aside):
        return frozenset({"depth"})
    return frozenset()
