"""Long exports of the page: begun, asked about, cancelled, fetched. One at a time."""

from __future__ import annotations

import asyncio
import importlib.util
import secrets
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError
from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, Response
from starlette.routing import Route

from keypose.app.export.drawable import require_frame, require_tint
from keypose.app.export.motion_formats import FORMATS
from keypose.app.jobs.exchange import Export, ExportWork, suffix_of
from keypose.app.jobs.side_process import SideProcess, WorkState
from keypose.app.orders.drawing import FilmOrder, PicturesOrder, SheetOrder
from keypose.app.orders.order import read_order
from keypose.app.server.headers import headers_for, json_answer, read_body
from keypose.app.store.store import Store
from keypose.tracker.errors import FormatError, KeyposeError, one_sentence
from keypose.tracker.scratch import Scratch
from keypose.tracker.session.schema import Session
from keypose.tracker.video.encode import can_write_films

LARGEST_ORDER = 1 << 14
TOO_LONG = "The order of an export is too long."
FILM_REMEDY = "pip install --force-reinstall av"

ORDERS: Mapping[str, type[Export]] = {
    "film": FilmOrder, "sheet": SheetOrder, "pictures": PicturesOrder,
}  # fmt: skip
TEXTS: TypeAdapter[dict[str, str]] = TypeAdapter(dict[str, str])


def read_export(content: bytes) -> Export:
    """The order in a request; ValidationError or FormatError where it is none."""
    texts = TEXTS.validate_json(content)
    what = texts.pop("what", "")
    if what not in ORDERS:
        raise FormatError(f"There is no export {what[:40]!r}; choose from {', '.join(ORDERS)}.")
    return read_order(ORDERS[what], texts)


def require_drawable(order: Export, session: Session) -> None:
    """KeyposeError where it cannot be drawn of this session."""
    require_tint(session, order.tint)
    frames = getattr(order, "frames", None)
    if isinstance(frames, tuple):
        require_frame(session, frames[1])
    elif isinstance(frames, int):
        require_frame(session, frames)


class Exports:
    """The routes of long exports, and the one that is under way."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._id = ""
        self._name = ""
        self._process: SideProcess | None = None
        self._scratch: Scratch | None = None
        self._out = Path()
        self._beginning = asyncio.Lock()

    def routes(self) -> list[Route]:
        """Return where the page asks for all this."""
        return [
            Route("/exports", self._possible),
            Route("/exports", self._begin, methods=["POST"]),
            Route("/exports/{id}", self._state),
            Route("/exports/{id}", self._cancel, methods=["DELETE"]),
            Route("/exports/{id}/file", self._file),
        ]

    async def close(self) -> None:
        """End what is under way, and leave no files."""
        process, self._process = self._process, None
        if process is not None:
            await asyncio.to_thread(process.cancel)
        scratch, self._scratch = self._scratch, None
        if scratch is not None:
            await asyncio.to_thread(scratch.close)

    async def _possible(self, _: Request) -> Response:
        return json_answer({"missing": missing_here()})

    async def _begin(self, request: Request) -> Response:
        try:
            order = read_export(await read_body(request, LARGEST_ORDER, TOO_LONG))
            async with self._beginning:
                return await self._start(order)
        except ValidationError as error:
            return json_answer({"words": one_sentence(error)}, 400)
        except (KeyposeError, ClientDisconnect, OSError) as error:
            return json_answer({"words": str(error)}, 400)

    async def _start(self, order: Export) -> Response:
        if self._process is not None and self._process.state.state == "running":
            words = "Another export is under way. Wait for it or cancel it."
            return json_answer({"words": words}, 409)
        path = await self._store.saved_path()
        edit, opened = self._store.app_state.edit, self._store.opened
        if edit is None or opened is None:
            raise FormatError("Open a video first.")
        require_drawable(order, edit.doc)
        await self.close()
        self._scratch = await asyncio.to_thread(Scratch, "export")
        suffix = suffix_of(order)
        self._out = self._scratch.path / f"export{Path(suffix).suffix}"
        work = ExportWork(order, path, self._out)
        self._process = await asyncio.to_thread(SideProcess, work)
        self._id = secrets.token_hex(8)
        self._name = f"{self._store.name}{suffix}"
        return json_answer({"id": self._id})

    def _under_way(self, request: Request) -> SideProcess | None:
        return self._process if request.path_params["id"] == self._id else None

    async def _state(self, request: Request) -> Response:
        process = self._under_way(request)
        return _gone() if process is None else json_answer(_state_fields(process.state))

    async def _cancel(self, request: Request) -> Response:
        process = self._under_way(request)
        if process is None:
            return _gone()
        await asyncio.to_thread(process.cancel)
        state = _state_fields(process.state)
        await self.close()
        return json_answer(state)

    async def _file(self, request: Request) -> Response:
        process = self._under_way(request)
        if process is None or process.state.state != "done" or not self._out.is_file():
            return _gone()
        headers = {**headers_for("data"), "Cache-Control": "no-store"}
        return FileResponse(
            self._out, headers=headers, filename=self._name, content_disposition_type="inline"
        )


def missing_here() -> dict[str, str]:
    """Return what cannot be exported by this installation, with the command that mends it."""
    missing = {
        name: f"pip install 'keypose[{name}]'"
        for name, kind in FORMATS.items()
        if kind.library is not None and importlib.util.find_spec(kind.library[1]) is None
    }
    if not can_write_films():
        missing["film"] = FILM_REMEDY
    return missing


def _state_fields(state: WorkState) -> dict[str, Any]:
    """The state of an export, for the page; done, with what should be known of its files."""
    words = state.result if state.state == "done" else state.words
    return {"state": state.state, "done": state.done, "of": state.of, "words": words}


def _gone() -> Response:
    return json_answer({"words": "This export is over."}, 404)
