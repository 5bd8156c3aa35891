"""Serve the library behind the page."""

from __future__ import annotations

import asyncio

from starlette.requests import ClientDisconnect, Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

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
        """Where the page asks for all this."""
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
