"""Escape every text into markup, and put the page around a report."""

from __future__ import annotations

import base64
import html
import unicodedata
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import TypeAlias

from keypose import static

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


_STATIC = Path(static.__file__).parent
_LIGHT = "@media print, not (prefers-color-scheme: dark)"
_POLICY = "default-src 'none'; img-src data:; font-src data:; style-src 'unsafe-inline'"
"""A browser fetches nothing and runs nothing, whatever stands in the page."""


def html_page(title: str, body: Html) -> bytes:
    """The whole file. It needs no other one, and looks like the program's own page."""
    head = element(
        "head",
        element("meta", charset="utf-8"),
        element("meta", http_equiv="Content-Security-Policy", content=_POLICY),
        element("meta", name="viewport", content="width=device-width, initial-scale=1"),
        element("meta", name="color-scheme", content="light dark"),
        element("title", title),
        Html(f"<style>{_style()}</style>"),
    )
    page = element("html", head, element("body", element("main", body)), lang="en")
    return f"<!doctype html>\n{page}\n".encode()


def logo() -> Html:
    """The program's mark."""
    return Html((_STATIC / "logo.svg").read_text("utf-8").strip())


@cache
def _style() -> Html:
    """Letters, colours and sizes are the page's; light on paper and unless dark is wished for."""
    letters = base64.b64encode((_STATIC / "fonts" / "inter.woff2").read_bytes()).decode()
    tokens = (_STATIC / "style" / "tokens.css").read_text("utf-8")
    tokens = tokens.replace("../fonts/inter.woff2", f"data:font/woff2;base64,{letters}")
    dark, light = tokens.split("[data-theme=light]")
    own = Path(__file__).with_name("report.css").read_text("utf-8")
    return Html(f"{dark}{_LIGHT}{{:root{light}}}\n{own}")
