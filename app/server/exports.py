"""Long exports of the page: begun, asked about, cancelled, fetched. One at a time."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

from starlette.requests import Request
from starlette.responses import FileResponse, Response
from starlette.routing import Route

from keypose.app.export.drawable import require_frame, require_tint
from keypose.app.export.motion_formats import FORMATS
from keypose.app.jobs.exchange import Export, ExportWork, suffix_of
from keypose.app.jobs.side_process import WorkState
from keypose.app.orders.drawing import DRAWN, Drawn
from keypose.app.server.headers import headers_for, json_answer
from keypose.app.server.long_work import LongWork
from keypose.app.store.store import Store
from keypose.tracker.errors import FormatError
from keypose.tracker.session.schema import Session
from keypose.tracker.video.encode import can_write_films

FILM_REMEDY = "pip install --force-reinstall av"


def require_drawable(order: Export, session: Session) -> None:
    """KeyposeError where it cannot be drawn of this session."""
    if isinstance(order, Drawn):
        require_tint(session, order.tint)
    frames = getattr(order, "frames", None)
    if isinstance(frames, tuple):
        require_frame(session, frames[1])
    elif isinstance(frames, int):
        require_frame(session, frames)


class Exports(LongWork):
    """The routes of long exports, and the one that is under way."""

    def __init__(self, store: Store) -> None:
        super().__init__(store, "export")
        self._name, self._out = "", Path()

    def routes(self) -> list[Route]:
        return [
            *super().routes(),
            Route("/exports", self._possible),
            Route("/exports/{id}/file", self._file),
        ]

    async def begin(self, request: Request) -> dict[str, str]:
        order: Export = await self.order_in(request, "what", DRAWN)
        self.require_idle()
        path = await self.store.saved_path()
        edit = self.store.app_state.edit
        if edit is None:
            raise FormatError("Open a video first.")
        require_drawable(order, edit.doc)
        suffix = suffix_of(order)
        self._out = await self.folder_anew() / f"export{Path(suffix).suffix}"
        self._name = f"{self.store.name}{suffix}"
        return await self.start(ExportWork(order, path, self._out))

    def described(self, state: WorkState) -> dict[str, Any]:
        """Once it is done, with what should be known of its files."""
        words = state.result if state.state == "done" else state.words
        return {"state": state.state, "done": state.done, "of": state.of, "words": words}

    async def _possible(self, _: Request) -> Response:
        return json_answer({"missing": missing_here()})

    async def _file(self, request: Request) -> Response:
        process = self.under_way(request)
        if process is None or process.state.state != "done" or not self._out.is_file():
            return self.gone()
        headers = {**headers_for("data"), "Cache-Control": "no-store"}
        return FileResponse(
            self._out, headers=headers, filename=self._name, content_disposition_type="inline"
        )


def missing_here() -> dict[str, str]:
    """What cannot be exported by this installation, with the command that mends it."""
    missing = {
        name: f"pip install 'keypose[{name}]'"
        for name, kind in FORMATS.items()
        if kind.library is not None and importlib.util.find_spec(kind.library[1]) is None
    }
    if not can_write_films():
        missing["film"] = FILM_REMEDY
    return missing
