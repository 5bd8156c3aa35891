"""What all sections are made of."""

from __future__ import annotations

from typing import Any, TypeAlias

from app.store.state import Outlook
from tracker.session.schema import Session

Json: TypeAlias = Any
"""Whatever JSON can say."""


def doc_of(outlook: Outlook) -> Session | None:
    """The document as it stands, if one is open."""
    return outlook.edit.doc if outlook.edit else None
