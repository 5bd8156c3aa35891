"""Where a body can be taken hold of, and how its parts are grouped."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from keypose.app.posing.labels import joint_label, part_label
from keypose.tracker.body.body import Body, Part
from keypose.tracker.body.limb_groups import chains, kind_of, limb_groups
from keypose.tracker.body.skeleton import Skeleton, once_per_body
from keypose.tracker.errors import BodyError


@dataclass(frozen=True)
class BodyHandle:
    """A point of the body that can be dragged.

    part:   the part that is shown as held.
    anchor: the joint or landmark at which the handle stands.
    limb:   the parts that belong together there, from the trunk outward.
    movers: those of them, or of the trunk, that turn when it is dragged, in the same order.
    """

    name: str
    kind: Literal["root", "end", "middle", "head", "corner"]
    part: str
    anchor: str
    label: str
    limb: tuple[str, ...]
    movers: tuple[str, ...]


@once_per_body
def handles(body: Body) -> tuple[BodyHandle, ...]:
    """The root, of every limb the end and the joints between, and the corners of the trunk.

    A hand and a foot are dragged by their joint, and keep their direction in what carries them. A
    limb of two parts is dragged by its tip. The head takes neck and chest with it. A clavicle turns
    when the shoulder is dragged, and stays when elbow or hand are. A shoulder without one, and a
    hip, are corners: they take the trunk with them.
    """
    skeleton = Skeleton.of(body)
    root = body.parts[0].name
    body_handles = [BodyHandle("root", "root", root, root, "Body", (root,), (root,))]
    for limb in chains(skeleton):
        if limb[-1] == "head":
            body_handles.append(_head(skeleton, limb))
        elif not _carries_more(skeleton, limb):
            body_handles += _of_limb(body, limb)
    return (*body_handles, *_corners(skeleton, body_handles))


def _corners(skeleton: Skeleton, body_handles: list[BodyHandle]) -> list[BodyHandle]:
    """Where the left and right limbs hang on the trunk, of a body that has a head."""
    body = skeleton.body
    head = next((handle for handle in body_handles if handle.kind == "head"), None)
    if head is None:
        return []
    trunk = (body.parts[0].name, *head.movers)
    corners = []
    for handle in body_handles:
        first = handle.limb[0]
        on = body.parts[body.index(first)].parent
        hinged = handle.kind == "end" and handle.movers[0] == first
        if hinged and on in trunk and body.mirror_of(first) != first:
            label = joint_label(first)
            name = label.lower().replace(" ", "_")
            corners.append(BodyHandle(name, "corner", on, first, label, trunk, trunk))
    return corners


def handle_named(body: Body, name: str) -> BodyHandle:
    """The handle of this name; BodyError lists the names there are."""
    body_handles = handles(body)
    for handle in body_handles:
        if handle.name == name:
            return handle
    names = ", ".join(handle.name for handle in body_handles)
    raise BodyError(f"The body has no handle {name!r}; its handles are {names}.")


def handle_at_far_end(body: Body, part: str) -> BodyHandle | None:
    """The handle that carries a part's far end: of the upper arm the elbow's, of the hand the
    wrist's. None where there is none, as for the chest."""
    body.index(part)
    body_handles = [handle for handle in handles(body) if handle.kind not in ("root", "corner")]
    children = {p.name for p in body.parts if p.parent == part}
    for handle in body_handles:
        if handle.anchor in children and part in handle.limb:
            return handle
    of_limb = [handle for handle in body_handles if part in handle.limb and handle.kind != "middle"]
    return of_limb[0] if of_limb else None


def lanes(body: Body) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """The groups of parts for lists, each with its label."""
    return tuple((part_label(name), parts) for name, parts in limb_groups(body))


def _carries_more(skeleton: Skeleton, limb: tuple[str, ...]) -> bool:
    """Whether other limbs hang on this one, as on the chest."""
    inside = skeleton.below[:, skeleton.body.index(limb[0])].sum()
    return bool(inside > len(limb))


def _head(skeleton: Skeleton, _limb: tuple[str, ...]) -> BodyHandle:
    """The head by its top; all between it and the root follows."""
    body = skeleton.body
    parts = body.parts
    above: list[str] = []
    i = body.index("head")
    while skeleton.parents[i] >= 0:
        above.insert(0, parts[i].name)
        i = int(skeleton.parents[i])
    tip = _tip(parts[body.index("head")])
    movers = tuple(above) if tip else tuple(above[:-1]) or tuple(above)
    return BodyHandle("head", "head", "head", tip or "head", "Head", tuple(above), movers)


def _of_limb(body: Body, limb: tuple[str, ...]) -> list[BodyHandle]:
    """The end of one limb, then the joints between, from the end toward the trunk."""
    last = body.parts[body.index(limb[-1])]
    tip = _tip(last)
    girdle = int(len(limb) > 1 and kind_of(limb[0]) == "clavicle")
    to_tip = len(limb) - girdle < 3 and tip is not None
    if not to_tip and len(limb) < 2:
        return []
    anchor = tip if to_tip and tip else last.name
    movers = limb[girdle:] if to_tip else limb[girdle:-1] or limb[:girdle]
    label = part_label(tip if to_tip and tip else last.name)
    body_handles = [BodyHandle(last.name, "end", last.name, anchor, label, limb, movers)]
    for k in range(len(movers) - 1, -girdle, -1):
        name = limb[girdle + k]
        label = joint_label(name)
        key = label.lower().replace(" ", "_")
        moved = movers[:k] or limb[:girdle]
        body_handles.append(BodyHandle(key, "middle", name, name, label, limb, moved))
    return body_handles


def _tip(part: Part) -> str | None:
    """The landmark farthest from the part's joint."""
    if not part.landmarks:
        return None
    return max(part.landmarks, key=lambda name: sum(c * c for c in part.landmarks[name]))
