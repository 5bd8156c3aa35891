"""The page's files: kept by browsers, and never used stale."""

from __future__ import annotations

import asyncio
from pathlib import Path

from starlette.responses import Response

from keypose.app.server.page_files import PageFiles


def asked(files: PageFiles, **headers: str) -> Response:
    given = [(name.replace("_", "-").encode(), value.encode()) for name, value in headers.items()]
    scope = {"type": "http", "method": "GET", "path": "/page.js", "headers": given}
    return asyncio.run(files.get_response("page.js", scope))


def test_a_browser_asks_before_it_uses_a_file_again(tmp_path: Path) -> None:
    (tmp_path / "page.js").write_text("one")
    files = PageFiles(directory=tmp_path)
    first = asked(files)
    assert first.headers["cache-control"] == "no-cache"
    known = first.headers["etag"]
    unchanged = asked(files, if_none_match=known)
    assert (unchanged.status_code, unchanged.headers["cache-control"]) == (304, "no-cache")
    (tmp_path / "page.js").write_text("another")
    assert asked(files, if_none_match=known).status_code == 200
