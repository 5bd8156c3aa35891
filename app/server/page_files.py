"""Serve the page's own files: hundreds, which a browser keeps and which load as quickly as few."""

from __future__ import annotations

import asyncio
import hashlib
import posixpath
import re
from pathlib import Path

from starlette.exceptions import HTTPException
from starlette.responses import FileResponse, Response
from starlette.staticfiles import StaticFiles
from starlette.types import Scope

_KEPT = "private, max-age=31536000, immutable"
_SERVED = frozenset({".css", ".js", ".svg", ".woff2"})
"""What a page is made of, by its endings; the index is answered as the page."""
_SHEET_LINK = re.compile(r'<link rel="stylesheet" href="[^"]*?/(style/[^"]+)" />\s*')
_SHEET_IMPORT = re.compile(r'@import url\("([^"]+)"\);')
_SHEETS = "style/all.css"
"""Beside the sheets that it is made of, so that what they lead to is found."""
_MODULE = re.compile(r'<script type="module" src="[^"]*?/([^"/]+)"></script>')
_MODULE_IMPORT = re.compile(r"""\b(?:from|import)\s*['"](\.{1,2}/[^'"]+\.js)['"]""")


def _whole_sheet(sheet: Path) -> str:
    """A style sheet with those that it imports in their place."""

    def imported(match: re.Match[str]) -> str:
        return _whole_sheet(sheet.parent / match[1])

    return _SHEET_IMPORT.sub(imported, sheet.read_text(encoding="utf-8"))


class PageFiles(StaticFiles):
    """The files of a folder, below the version of all of them: a browser keeps what it has and asks
    for none of it again until a file has changed. Then all addresses are others, so that no file of
    the version before is mixed with new ones.

    The files lead to one another by relative paths. One that is asked for without a version is kept
    by nobody without asking. Style sheets, which a browser waits for before it shows anything, come
    as one. The page names all modules, so that none is asked for only when another has been read.
    """

    def __init__(self, folder: Path, mount: str) -> None:
        """mount: where the files are served."""
        super().__init__(directory=folder)
        self._folder = folder
        self._mount = mount
        self._version = self._examined()
        self._page = ""
        self._answers: dict[str, Response] = {}

    def page(self) -> str:
        """The page, whose addresses are those of the files as they are now."""
        version = self._examined()
        if version != self._version or not self._page:
            self._version, self._answers = version, {}
            text = self._with_modules(self._with_one_sheet(self._index()))
            self._page = text.replace(f'"{self._mount}/', f'"{self._mount}/{version}/')
        return self._page

    async def get_response(self, path: str, scope: Scope) -> Response:
        """The file, or that it has not changed; nothing of a version that is no more.

        A browser that comes for the first time asks for hundreds: what was read once in a version
        is answered from memory, which takes the server a fraction of the time.
        """
        if path in self._answers and scope["method"] == "GET":
            return self._answers[path]
        version, _, rest = path.partition("/")
        is_kept = version == self._version
        if is_kept and rest == _SHEETS:
            headers = {"Cache-Control": _KEPT}
            sheet = await asyncio.to_thread(self._sheets)
            return self._answers.setdefault(path, Response(sheet, 200, headers, "text/css"))
        file = rest if is_kept else path
        if posixpath.splitext(file)[1] not in _SERVED:  # READMEs and Python lie there too
            raise HTTPException(404)
        response = await super().get_response(file, scope)
        response.headers["Cache-Control"] = _KEPT if is_kept else "no-cache"
        if not (is_kept and isinstance(response, FileResponse)):
            return response
        return self._answers.setdefault(path, _from_memory(response))

    def _with_one_sheet(self, text: str) -> str:
        """The page's text with one link in the place of those to its style sheets."""
        sheets = _SHEET_LINK.search(text)
        if sheets is None:
            return text
        link = f'<link rel="stylesheet" href="{self._mount}/{_SHEETS}" />\n    '
        rest = _SHEET_LINK.sub("", text[sheets.end() :])
        return f"{text[: sheets.start()]}{link}{rest}"

    def _with_modules(self, text: str) -> str:
        """The page's text with a link to every module that its own leads to."""
        entry = _MODULE.search(text)
        if entry is None:
            return text
        links = (
            f'<link rel="modulepreload" href="{self._mount}/{name}" />\n    '
            for name in self._led_to(entry[1])
        )
        return f"{text[: entry.start()]}{''.join(links)}{text[entry.start() :]}"

    def _led_to(self, entry: str) -> list[str]:
        """The modules that one imports, and those that they do, each once."""
        modules = [entry]
        for name in modules:  # which grows meanwhile
            text = (self._folder / name).read_text(encoding="utf-8")
            led_to = (
                posixpath.join(posixpath.dirname(name), to) for to in _MODULE_IMPORT.findall(text)
            )
            for each in map(posixpath.normpath, led_to):
                if each not in modules and (self._folder / each).is_file():
                    modules.append(each)
        return modules[1:]

    def _index(self) -> str:
        return (self._folder / "index.html").read_text(encoding="utf-8")

    def _sheets(self) -> str:
        """All style sheets of the page, one after the other."""
        return "".join(_whole_sheet(self._folder / s) for s in _SHEET_LINK.findall(self._index()))

    def _examined(self) -> str:
        """Another one as soon as a file is another one, by names, sizes and times."""
        files = sorted(path for path in self._folder.rglob("*.*") if path.is_file())
        stats = [(path.relative_to(self._folder).as_posix(), path.stat()) for path in files]
        made_of = [(name, stat.st_size, stat.st_mtime_ns) for name, stat in stats]
        return hashlib.sha256(repr(made_of).encode()).hexdigest()[:16]


def _from_memory(response: FileResponse) -> Response:
    """The same answer, to be given as often as it is asked for."""
    return Response(Path(response.path).read_bytes(), headers=dict(response.headers))
