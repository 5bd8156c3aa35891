"""What all sections are made of."""

from __future__ import annotations

from typing import Any, TypeAlias

from keypose.app.state.app_state import AppState
from keypose.tracker.session.schema import Session

Json: TypeAlias = Any
"""Whatever JSON can say."""


def doc_of(app_state: AppState) -> Session | None:
    """The document as it stands, if one is open."""
    return app_state.edit.doc if app_state.edit else None
