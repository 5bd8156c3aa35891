"""What a person calls a session that is not open: one more step of its history."""

from __future__ import annotations

from contextlib import closing
from dataclasses import replace
from pathlib import Path

from keypose.app.document.folder_lock import locked
from keypose.tracker.errors import SessionError
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.chronicle import edit_record, mark_of, saved_record, whole_record
from keypose.tracker.storage.files import journal_path, open_session, save_session
from keypose.tracker.storage.journal import Journal

STEP = "rename"
"""What undo calls it."""


def rename_session(path: Path, title: str) -> Session:
    """Write another title into a session file and its journal; the session as it is then.

    SessionError when another Keypose has it, a newer one wrote it, or the disk refuses.
    """
    with locked(path, "close it there first"):
        opened = open_session(path)
        if opened.session.is_newer:
            raise SessionError(f"{path.name} was written by a newer Keypose: rename it there.")
        renamed = opened.session.model_copy(update={"title": title})
        if title == opened.session.title:
            return renamed
        before = opened.recovered.moment
        after = replace(
            before,
            doc=before.doc.model_copy(update={"title": title}),
            history=before.history.after(before.doc, STEP, before.frame),
            received=replace(before.received, revision=""),
        )
        follows = opened.recovered.follows and opened.journal.whole
        size = opened.journal.size if follows else 0
        with closing(Journal(journal_path(path), size)) as journal:
            if follows:
                journal.append([edit_record(before, after)])
            else:
                journal.begin_anew(whole_record(after), keep_previous=True)
            save_session(renamed, path)
            journal.append([saved_record(mark_of(renamed))], durable=False)
        return renamed
