"""The page's own files, each at an address of this version of them."""

from __future__ import annotations

import hashlib
from pathlib import Path

from starlette.responses import FileResponse, Response
from starlette.staticfiles import StaticFiles
from starlette.types import Scope

_KEPT = "private, max-age=31536000, immutable"


class PageFiles(StaticFiles):
    """The files of a folder, below the version of all of them: a browser keeps what it has and asks
    for none of it again until a file has changed. Then all addresses are others, so that no file of
    the version before is mixed with new ones.

    The files lead to one another by relative paths. One that is asked for without a version is kept
    by nobody without asking.
    """

    def __init__(self, folder: Path, mount: str) -> None:
        """mount: where the files are served."""
        super().__init__(directory=folder)
        self._folder = folder
        self._mount = mount
        self._version = self._examined()
        self._answers: dict[str, Response] = {}

    def page(self) -> str:
        """The page, whose addresses are those of the files as they are now."""
        version = self._examined()
        if version != self._version:
            self._version, self._answers = version, {}
        text = (self._folder / "index.html").read_text(encoding="utf-8")
        return text.replace(f'"{self._mount}/', f'"{self._mount}/{self._version}/')

    async def get_response(self, path: str, scope: Scope) -> Response:
        """The file, or that it has not changed; nothing of a version that is no more.

        A browser that comes for the first time asks for hundreds: what was read once in a version
        is answered from memory, which takes the server a fraction of the time.
        """
        if path in self._answers and scope["method"] == "GET":
            return self._answers[path]
        version, _, rest = path.partition("/")
        is_kept = version == self._version
        response = await super().get_response(rest if is_kept else path, scope)
        response.headers["Cache-Control"] = _KEPT if is_kept else "no-cache"
        if not (is_kept and isinstance(response, FileResponse)):
            return response
        return self._answers.setdefault(path, _from_memory(response))

    def _examined(self) -> str:
        """Another one as soon as a file is another one, by names, sizes and times."""
        files = sorted(path for path in self._folder.rglob("*.*") if path.is_file())
        stats = [(path.relative_to(self._folder).as_posix(), path.stat()) for path in files]
        made_of = [(name, stat.st_size, stat.st_mtime_ns) for name, stat in stats]
        return hashlib.sha256(repr(made_of).encode()).hexdigest()[:16]


def _from_memory(response: FileResponse) -> Response:
    """The same answer, to be given as often as it is asked for."""
    return Response(Path(response.path).read_bytes(), headers=dict(response.headers))
