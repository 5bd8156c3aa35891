"""What is bonded to the posed body at the present frame goes along with an edit of its pose, where
both are posed there and the bond lets it move."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from keypose.app.editor.posing import with_pose
from keypose.app.editor.shown import draft_at, end_at, find, part_at, shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.posing.carrying import moved, placed, reached
from keypose.tracker.body.pose import Pose
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.on_body import is_persons
from keypose.tracker.session.bonds import Bond, BondEnd
from keypose.tracker.session.schema import Session

_SAME_M: Final = 1e-6
"""A point that moved by less did not."""


def with_carried(before: EditorState, doc: Session) -> Session:
    """The document after an edit, with what the posed body holds, or is held by, brought along."""
    bonds = [] if doc.subject.id != before.doc.subject.id else list(_bonds(before, doc))
    if not bonds:
        return doc
    after = before.with_doc(doc)
    for body_id in dict.fromkeys(_ends(bond, doc)[1].body for bond in bonds):
        about = after.about(body_id)
        is_posed = find(about.doc.subject.keyframes, about.frame) or draft_at(about, about.frame)
        is_untouched = about.doc.subject == before.about(body_id).doc.subject
        if is_posed and is_untouched:
            to_it = [bond for bond in bonds if _ends(bond, doc)[1].body == body_id]
            after = _with_body_carried(before, after, to_it)
    return after.doc


def _bonds(before: EditorState, doc: Session) -> Iterator[Bond]:
    """Those between the posed body and another that are in force at the present frame."""
    for bond in doc.bonds:
        is_here = bond.first_frame <= before.frame <= bond.last_frame
        is_between = doc.subject.id in bond.bodies and len({*bond.bodies}) > 1
        if is_here and is_between and bond in before.doc.bonds:
            yield bond


def _ends(bond: Bond, doc: Session) -> tuple[BondEnd, BondEnd]:
    """That on the posed body, and the other one."""
    is_holder = bond.holder.body == doc.subject.id
    return (bond.holder, bond.held) if is_holder else (bond.held, bond.holder)


def _lets_go_along(bond: Bond, end: BondEnd) -> bool:
    return bond.moves in ("both", "held" if end == bond.held else "holder")


def _with_body_carried(
    before: EditorState, after: EditorState, bonds: Sequence[Bond]
) -> EditorState:
    """With one other body carried by the end that moved most; other ends of the posed body that
    hold it too reach after it."""
    travels = [_travel(before, after, _ends(bond, after.doc)[0]) for bond in bonds]
    leading = int(np.argmax([metres for _, metres in travels]))
    T, metres = travels[leading]
    end = _ends(bonds[leading], after.doc)[1]
    if metres < _SAME_M or not _lets_go_along(bonds[leading], end):
        return after
    about = after.about(end.body)
    pose = _carried(about, end, T)
    if pose is None:
        return after
    posed = after.doc.subject.id
    doc = with_pose(about, pose, in_picture=False).about(posed)
    after = after.with_doc(doc)
    for bond in bonds:
        if bond is not bonds[leading]:
            after = _with_end_reaching(before, after, bond)
    return after


def _travel(before: EditorState, after: EditorState, end: BondEnd) -> tuple[Array, float]:
    """How a part of the posed body was moved, (4, 4) in the camera frame, and its point, metres."""
    T_before, T_after = (part_at(state, end.part, state.frame) for state in (before, after))
    p_before, p_after = (placed(T, np.array(end.point_m)) for T in (T_before, T_after))
    return T_after @ np.linalg.inv(T_before), float(np.linalg.norm(p_after - p_before))


def _carried(about: EditorState, end: BondEnd, T: Array) -> Pose | None:
    """The pose of the other body with its end moved by T: a person's limb, or a thing whole; None
    of a person's trunk."""
    pose = shown_pose(about).pose
    if not is_persons(about.doc.subject.body):
        return moved(pose, T)
    place = placed(T, end_at(about, end, about.frame))
    return reached(about.skeleton, pose, end.part, np.array(end.point_m), place)


def _with_end_reaching(before: EditorState, after: EditorState, bond: Bond) -> EditorState:
    """With an end of the posed body as near to the other body as it was before the edit."""
    (own, beside), frame = _ends(bond, after.doc), after.frame
    gap = end_at(before, own, frame) - end_at(before.about(beside.body), beside, frame)
    place = end_at(after.about(beside.body), beside, frame) + gap
    pose = shown_pose(after).pose
    if float(np.linalg.norm(place - end_at(after, own, frame))) < _SAME_M:
        return after
    pose_reaching = reached(after.skeleton, pose, own.part, np.array(own.point_m), place)
    return after if pose_reaching is None else after.with_doc(with_pose(after, pose_reaching))
