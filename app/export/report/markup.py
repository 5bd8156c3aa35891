"""Markup that cannot be broken by what stands in it: every text is escaped where it is put in."""

from __future__ import annotations

import html
import unicodedata
from collections.abc import Iterable
from typing import TypeAlias

VOID = ("img", "meta", "br", "path", "rect", "line", "circle", "polyline", "use")
"""Elements without an end."""


class Html(str):
    """Text that is markup already."""

    __slots__ = ()


_NO_TEXT = ("Cc", "Cs", "Cn")

Child: TypeAlias = "str | Html | None"
"""None stands for nothing."""


def element(name: str, /, *children: Child, **attributes: str | float | None) -> Html:
    """An element. Attributes are named as in `class_`, `http_equiv`; one that is None is absent."""
    attributes_text = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{html.escape(_plain(value))}"'
        for key, value in attributes.items()
        if value is not None
    )
    if name in VOID and not children:
        return Html(f"<{name}{attributes_text}/>")
    return Html(f"<{name}{attributes_text}>{joined(children)}</{name}>")


def joined(children: Iterable[Child]) -> Html:
    """Pieces one after the other."""
    return Html("".join(_safe(child) for child in children if child is not None))


def _safe(child: str) -> str:
    return child if isinstance(child, Html) else html.escape(_printable(child))


def _plain(value: str | float) -> str:
    if isinstance(value, str):
        return _printable(value)
    return f"{value:.2f}".rstrip("0").rstrip(".")


def _printable(text: str) -> str:
    """Without control characters and halves of characters, which no page may hold."""
    return "".join(
        "\ufffd" if unicodedata.category(c) in _NO_TEXT and c not in "\n\t" else c for c in text
    )
