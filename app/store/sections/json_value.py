"""What all sections are made of, and whether one has to be made anew."""

from __future__ import annotations

from typing import Any, TypeAlias

from keypose.app.store.state import AppState
from keypose.tracker.session.schema import Session

Json: TypeAlias = Any
"""Whatever JSON can say."""


def doc_of(app_state: AppState) -> Session | None:
    """The document as it stands, if one is open."""
    return app_state.edit.doc if app_state.edit else None


def unchanged(old: tuple[Any, ...] | None, new: tuple[Any, ...]) -> bool:
    """Compare by identity what is large and immutable, by value plain numbers and words."""
    if old is None or len(old) != len(new):
        return False
    return all(
        a is b or (isinstance(a, int | float | str) and a == b)
        for a, b in zip(old, new, strict=True)
    )
