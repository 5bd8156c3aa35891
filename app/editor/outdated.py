"""Drop poses of tracking ahead that no longer lead on from where the keyframes end."""

from __future__ import annotations

from keypose.app.editor.documents import with_drafts
from keypose.tracker.session.annotations import Ahead
from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.fingerprints import ahead_key


def up_to_date(doc: Session) -> Session:
    """Without what was followed from a keyframe that is posed otherwise now, or is no longer the
    last one, or the first, that way."""
    outdated = [record for record in doc.subject.ahead if not still_leads_on(doc, record)]
    return without_records(doc, outdated) if outdated else doc


def without_followed(doc: Session) -> Session:
    """Without anything that was tracked ahead."""
    return without_records(doc, list(doc.subject.ahead))


def still_leads_on(doc: Session, record: Ahead) -> bool:
    """Whether what was followed still leads on from where the keyframes end."""
    if not doc.subject.keyframes:
        return False
    keyframe: Keyframe = doc.subject.keyframes[-1 if record.is_forward else 0]
    return keyframe.frame == record.from_frame and record.key == ahead_key(doc, keyframe)


def without_records(doc: Session, records: list[Ahead]) -> Session:
    """Without these records and the poses they are of; the document itself where there are none."""
    if not records:
        return doc
    kept = tuple(record for record in doc.subject.ahead if record not in records)
    spans = [record.span for record in records]
    drafts = [
        draft
        for draft in doc.subject.drafts
        if not (draft.followed and any(a <= draft.frame <= b for a, b in spans))
    ]
    return with_drafts(doc.changed({"ahead": kept}), drafts)
