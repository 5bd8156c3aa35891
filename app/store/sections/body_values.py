"""The body with all that can be changed about it, as JSON."""

from __future__ import annotations

from keypose.app.posing import (
    axis_labels,
    handles,
    part_label,
    part_sizes,
    short_label,
)
from keypose.app.posing import lanes as lane_groups
from keypose.app.store.sections.json_value import Json, doc_of
from keypose.app.store.state import AppState
from keypose.tracker.body.body import OBJECTS, PRESETS, Body, Part, preset
from keypose.tracker.body.clavicles import can_have_clavicles, has_clavicles, without_clavicles
from keypose.tracker.body.modify import height
from keypose.tracker.body.shapes import KINDS
from keypose.tracker.keypoints.on_body import is_persons


def body(app_state: AppState) -> Json:
    """The body's parts with all that can be changed about them."""
    doc = doc_of(app_state)
    if doc is None:
        return None
    given = doc.body
    return {
        "name": given.name,
        "preset": given.name if given.name in PRESETS else None,
        "edited": given.name in PRESETS
        and without_clavicles(given).parts != preset(given.name).parts,
        "clavicles": _clavicles(given),
        "height_cm": round(100 * height(given), 2),
        "is_persons": is_persons(given),
        "dof_count": sum(len(part.tracked) for part in given.parts),
        "dof_total": 3 + 3 * len(given.parts),
        "presets": [
            {"name": name, "label": part_label(name), "is_object": name in OBJECTS}
            for name in PRESETS
        ],
        "shapes": [{"kind": kind, "label": part_label(kind)} for kind in KINDS],
        "lanes": [{"label": label, "parts": list(parts)} for label, parts in lane_groups(given)],
        "parts": [_part(given, part) for part in given.parts],
        "handles": [
            {
                "name": handle.name,
                "kind": handle.kind,
                "part": handle.part,
                "anchor": handle.anchor,
                "label": handle.label,
                "limb": list(handle.limb),
            }
            for handle in handles(given)
        ],
    }


def _clavicles(given: Body) -> bool | None:
    """Whether it has them; None where it cannot."""
    return True if has_clavicles(given) else False if can_have_clavicles(given) else None


def _part(given: Body, part: Part) -> Json:
    mirror = given.mirror_of(part.name)
    return {
        "name": part.name,
        "label": part_label(part.name),
        "short": short_label(part.name),
        "parent": part.parent,
        "side": side_of(given, part.name),
        "mirror": None if mirror == part.name else mirror,
        "tracked": list(part.tracked),
        "words": axis_labels(given, part.name),
        "limits": {axis: part.limits_deg.get(axis) for axis in ("x", "y", "z")},
        "joint_cm": [round(100 * value, 2) for value in part.joint_m],
        "landmarks": list(part.landmarks),
        "shape": part.shape.kind,
        "corners_cm": _corners_cm(part),
        "sizes": [
            {
                "key": size.key,
                "label": size.label,
                "role": size.role,
                "cm": round(size.cm, 2),
                "min": size.min,
                "max": size.max,
                "at_cm": [round(100 * v, 2) for v in size.at_m],
            }
            for size in part_sizes(given, part.name)
        ],
    }


def _corners_cm(part: Part) -> Json:
    """Of a box, in its part's frame; none of others."""
    corners = part.shape.corners()
    return [] if corners is None else (100 * corners).round(3).tolist()


def side_of(given: Body, name: str) -> str:
    """L, R or C, as the colours go: the first of a mirror pair is the left one."""
    for left, right in given.mirror_pairs:
        if name in (left, right):
            return "L" if name == left else "R"
    return "C"
