"""The page around a report: one file that holds its style and its letters, light or dark."""

from __future__ import annotations

import base64
from functools import cache
from pathlib import Path

from keypose import static
from keypose.app.export.report.markup import Html, element

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
