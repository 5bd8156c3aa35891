"""Orders of which bodies of a session a command is about."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from keypose.app.orders.order import option
from keypose.app.orders.values import Name

_WORDS: Final = "which body is meant of a session that has several, by its id or name; default: "


def _body(default: str) -> Any:
    return option(Name("NAME"), f"{_WORDS}{default}", once=True)


@dataclass(frozen=True)
class OneBody:
    """The body that a command is about: the first where nothing is said."""

    body: str | None = _body("the first")


@dataclass(frozen=True)
class EachBody:
    """The body that a command is about: each where nothing is said."""

    body: str | None = _body("all")
