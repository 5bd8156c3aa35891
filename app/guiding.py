"""The guide through the first pose: which of its steps an action does, in whatever way."""

from __future__ import annotations

from dataclasses import replace

from app.editor import actions as do
from app.outlook import Guide
from app.posing.gesture import Surface


def guide_after(guide: Guide, action: do.Editing) -> Guide:
    """The guide with the steps this action does ticked off."""
    done = guide.done | _steps(action)
    return guide if done == guide.done else replace(guide, done=done)


def _steps(action: do.Editing) -> frozenset[str]:
    if isinstance(action, do.Drag):
        return _dragged(action)
    if isinstance(action, do.Root):
        return frozenset({"hips"} if action.z is None else {"depth"})
    if isinstance(action, do.Height | do.Preset | do.Size):
        return frozenset({"height"})
    if isinstance(action, do.Angles | do.PastePose | do.TakeTracked):
        return frozenset({"limbs"})
    if isinstance(action, do.ToggleKey | do.AddKey):
        return frozenset({"key"})
    return frozenset()


def _dragged(action: do.Drag) -> frozenset[str]:
    kind = action.handle.kind
    if kind == "size":
        return frozenset({"height"})
    handle = action.handle
    whole = kind == "root" or (isinstance(handle, Surface) and handle.tool == "move")
    steps = {"hips"} if whole else {"limbs"}
    if action.view in ("top", "side") or action.depth:
        steps.add("depth")
    return frozenset(steps)
