"""Files that a page imports: brought, recognised, imported as somebody chose. One at a time."""

from __future__ import annotations

import asyncio
from dataclasses import asdict
from pathlib import Path
from typing import Any, Literal

from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route

from keypose.app.document.library.names import clean_name
from keypose.app.jobs.exchange import ImportWork, RecogniseWork
from keypose.app.jobs.side_process import WorkState
from keypose.app.jobs.wire import failure_message
from keypose.app.orders.imports import IMPORTS, ImportOrder
from keypose.app.server.headers import read_body
from keypose.app.server.long_work import LongWork
from keypose.app.store.imported import ImportOutcome, ImportTarget
from keypose.app.store.store import Store
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.keypoint_files import LARGEST_KEYPOINT_BYTES

TOO_LARGE = f"More than {LARGEST_KEYPOINT_BYTES // 2**20} MB cannot be imported."


class Imports(LongWork):
    """The routes of imports, and the one that is under way."""

    def __init__(self, store: Store) -> None:
        super().__init__(store, "import")
        self._file = Path()
        self._stage: Literal["reading", "importing"] = "reading"
        self._outcome: ImportOutcome | str | None = None
        self._taking: asyncio.Task[None] | None = None

    def routes(self) -> list[Route]:
        return [*super().routes(), Route("/imports/{id}", self._begin, methods=["POST"])]

    async def begin(self, request: Request) -> dict[str, str]:
        """Receive the file, whole; what it holds is looked at from then on."""
        if self._stage == "importing":
            self.require_idle()
        target = self.store.import_target()
        folder = await self.folder_anew()
        try:
            self._file = await _received(request, folder)
        except BaseException:
            await self.close()
            raise
        self._stage, self._outcome = "reading", None
        return await self.start(RecogniseWork(target.content, self._file, target.video))

    async def _begin(self, request: Request) -> Response:
        process = self.under_way(request)
        if process is None or process.state.state == "running":
            return self.gone()
        return await self.answer(self._import(request))

    async def _import(self, request: Request) -> dict[str, str]:
        """Import it as somebody chose; once more, where that was not possible before."""
        order: ImportOrder = await self.order_in(request, "kind", IMPORTS)
        target = self.store.import_target()
        self._stage, self._outcome = "importing", None
        begun = await self.start(ImportWork(target.content, self._file, target.video, order))
        self._taking = asyncio.ensure_future(self._take(target))
        return begun

    async def _take(self, target: ImportTarget) -> None:
        """Take what was made of it into the session, unless somebody has cancelled."""
        process = self.process
        assert process is not None
        state = await asyncio.to_thread(process.wait)
        if state.state != "done" or process is not self.process:
            return
        try:
            self._outcome = self.store.take_import(target, state.result, self._file.name)
        except Exception as error:  # noqa: BLE001 — or the page would wait for ever
            self._outcome = failure_message(error)

    def described(self, state: WorkState) -> dict[str, Any]:
        """An import is done once the session has it."""
        told: dict[str, Any] = {"stage": self._stage, "state": state.state}
        told |= {"words": state.words, "done": state.done, "of": state.of}
        if isinstance(self._outcome, ImportOutcome):
            return told | asdict(self._outcome)
        if self._outcome is not None:
            return told | {"state": "failed", "words": self._outcome}
        if state.state != "done":
            return told
        if self._stage == "reading":
            return told | {"found": asdict(state.result)}
        return told | {"state": "running"}


async def _received(request: Request, folder: Path) -> Path:
    """The file that is sent, in this folder."""
    name = clean_name(request.query_params.get("name", ""))
    content = await read_body(request, LARGEST_KEYPOINT_BYTES, TOO_LARGE)
    if not content:
        raise FormatError(f"{name} is empty.")
    await asyncio.to_thread((folder / name).write_bytes, content)
    return folder / name
