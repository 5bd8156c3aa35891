"""Serve the page's own files and the library behind the page."""

from __future__ import annotations

import asyncio
import hashlib
from pathlib import Path

from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, JSONResponse, Response
from starlette.routing import Route
from starlette.staticfiles import StaticFiles
from starlette.types import Scope

from keypose.app.document.library import Library, Upload
from keypose.app.server.headers import headers_for
from keypose.tracker.errors import KeyposeError

MOST_AT_A_TIME = 2
"""Pictures of files that are decoded."""

ENOUGH = {"private": "private, max-age=86400", "none": "no-store"}


class LibraryRoutes:
    """The library's routes."""

    def __init__(self, library: Library) -> None:
        self._library = library
        self._decoding = asyncio.Semaphore(MOST_AT_A_TIME)

    def routes(self) -> list[Route]:
        """Return where the page asks for all this."""
        return [
            Route("/library", self._contents),
            Route("/folder", self._folder),
            Route("/thumb/{id}.jpg", self._thumb),
            Route("/file.jpg", self._file_thumb),
            Route("/upload", self._upload, methods=["POST"]),
        ]

    async def _contents(self, _: Request) -> Response:
        contents = await asyncio.to_thread(self._library.contents)
        headers = {**headers_for("data"), "Cache-Control": ENOUGH["none"]}
        return JSONResponse(contents, headers=headers)

    async def _folder(self, request: Request) -> Response:
        try:
            at = request.query_params.get("at", "")
            listing = await asyncio.to_thread(self._library.folder, at)
        except KeyposeError as error:
            return _words(str(error), 404)
        headers = {**headers_for("data"), "Cache-Control": ENOUGH["none"]}
        return JSONResponse(listing, headers=headers)

    async def _file_thumb(self, request: Request) -> Response:
        """Few at a time: a folder may hold hundreds of films, and somebody is working."""
        at = request.query_params.get("at", "")
        async with self._decoding:
            content = await asyncio.to_thread(self._library.file_thumb, at)
        if content is None:
            return _words("There is no such picture.", 404)
        headers = {**headers_for("data"), "Cache-Control": ENOUGH["private"]}
        return Response(content, media_type="image/jpeg", headers=headers)

    async def _thumb(self, request: Request) -> Response:
        try:
            content = await asyncio.to_thread(self._library.thumb, request.path_params["id"])
        except asyncio.CancelledError:  # the program ends: nobody waits for it any more
            content = None
        if content is None:
            return _words("There is no such picture.", 404)
        headers = {**headers_for("data"), "Cache-Control": ENOUGH["private"]}
        return Response(content, media_type="image/jpeg", headers=headers)

    async def _upload(self, request: Request) -> Response:
        try:
            size = _content_length(request)
            name = request.query_params.get("name", "")
            with await asyncio.to_thread(self._library.upload, name, size) as upload:
                return await _received(request, upload)
        except KeyposeError as error:
            return _words(str(error), 400)
        except ClientDisconnect:
            return _words("The upload was interrupted.", 400)


async def _received(request: Request, upload: Upload) -> Response:
    """Written piece by piece, so that its size does not matter to the memory."""
    async for chunk in request.stream():
        await asyncio.to_thread(upload.write, chunk)
    name = await asyncio.to_thread(upload.finish)
    return JSONResponse({"id": name}, headers=headers_for("data"))


def _content_length(request: Request) -> int | None:
    length = request.headers.get("content-length", "")
    return int(length) if length.isascii() and length.isdigit() and len(length) < 16 else None


def _words(words: str, status: int) -> Response:
    return JSONResponse({"words": words}, status, headers_for("data"))


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
