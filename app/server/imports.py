"""Files that a page imports: brought, recognised, imported as somebody chose. One at a time."""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, Literal

from pydantic import TypeAdapter, ValidationError
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response
from starlette.routing import Route

from keypose.app.document.library.names import clean_name
from keypose.app.jobs.exchange import ImportWork, RecogniseWork
from keypose.app.jobs.side_process import SideProcess, WorkState
from keypose.app.jobs.wire import failure_message
from keypose.app.orders.imports import ImportCamera, ImportKeypoints, ImportMotion, ImportOrder
from keypose.app.orders.order import read_order
from keypose.app.server.headers import json_answer, read_body
from keypose.app.store.imported import ImportOutcome, ImportTarget
from keypose.app.store.store import Store
from keypose.tracker.errors import FormatError, KeyposeError, one_sentence
from keypose.tracker.formats.keypoint_files import LARGEST_KEYPOINT_BYTES
from keypose.tracker.scratch import Scratch

LARGEST_ORDER = 1 << 16
TOO_LONG = "The order of an import is too long."
TOO_LARGE = f"More than {LARGEST_KEYPOINT_BYTES // 2**20} MB cannot be imported."

ORDERS: Mapping[str, type[ImportOrder]] = {
    "motion": ImportMotion, "keypoints": ImportKeypoints, "camera": ImportCamera,
}  # fmt: skip
TEXTS: TypeAdapter[dict[str, str | list[str]]] = TypeAdapter(dict[str, str | list[str]])


def read_import(content: bytes) -> ImportOrder:
    """The order in a request; ValidationError or FormatError where it is none."""
    texts = TEXTS.validate_json(content)
    kind = texts.pop("kind", "")
    if not isinstance(kind, str) or kind not in ORDERS:
        raise FormatError(f"There is no import of that kind; choose from {', '.join(ORDERS)}.")
    return read_order(ORDERS[kind], texts)


class Imports:
    """The routes of imports, and the one that is under way."""

    def __init__(self, store: Store) -> None:
        self._store = store
        self._id = ""
        self._scratch: Scratch | None = None
        self._file = Path()
        self._process: SideProcess | None = None
        self._stage: Literal["reading", "importing"] = "reading"
        self._outcome: ImportOutcome | str | None = None
        self._taking: asyncio.Task[None] | None = None
        self._beginning = asyncio.Lock()

    def routes(self) -> list[Route]:
        """Return where the page asks for all this."""
        return [
            Route("/imports", self._bring, methods=["POST"]),
            Route("/imports/{id}", self._state),
            Route("/imports/{id}", self._begin, methods=["POST"]),
            Route("/imports/{id}", self._leave, methods=["DELETE"]),
        ]

    async def close(self) -> None:
        """End what is under way, and leave no files."""
        process, self._process, self._id = self._process, None, ""
        if process is not None:
            await asyncio.to_thread(process.cancel)
        scratch, self._scratch = self._scratch, None
        if scratch is not None:
            await asyncio.to_thread(scratch.close)

    async def _bring(self, request: Request) -> Response:
        """The file, whole; what it holds is looked at from then on."""
        try:
            async with self._beginning:
                if self._stage == "importing" and self._is_running():
                    words = "Another import is under way. Wait for it or cancel it."
                    return json_answer({"words": words}, 409)
                target = self._store.import_target()
                await self.close()
                self._scratch = await asyncio.to_thread(Scratch, "import")
                try:
                    self._file = await _received(request, self._scratch.path)
                except BaseException:
                    await self.close()
                    raise
                work = RecogniseWork(target.content, self._file, target.video)
                self._stage, self._outcome = "reading", None
                self._process = await asyncio.to_thread(SideProcess, work)
                self._id = secrets.token_hex(8)
                return json_answer({"id": self._id})
        except KeyposeError as error:
            return json_answer({"words": str(error)}, 400)
        except ClientDisconnect:
            return json_answer({"words": "The file was not brought whole. Choose it again."}, 400)
        except OSError as error:
            return json_answer({"words": f"It cannot be kept: {error.strerror or error}."}, 400)

    async def _begin(self, request: Request) -> Response:
        """Import it as somebody chose; once more, where that was not possible before."""
        if request.path_params["id"] != self._id or self._is_running():
            return _gone()
        try:
            order = read_import(await read_body(request, LARGEST_ORDER, TOO_LONG))
            async with self._beginning:
                target = self._store.import_target()
                work = ImportWork(target.content, self._file, target.video, order)
                self._stage, self._outcome = "importing", None
                self._process = await asyncio.to_thread(SideProcess, work)
                self._taking = asyncio.ensure_future(self._take(self._process, target))
                return json_answer({})
        except ValidationError as error:
            return json_answer({"words": one_sentence(error)}, 400)
        except (KeyposeError, ClientDisconnect) as error:
            return json_answer({"words": str(error)}, 400)

    async def _take(self, process: SideProcess, target: ImportTarget) -> None:
        """Take what was made of it into the session, unless somebody has cancelled."""
        state = await asyncio.to_thread(process.wait)
        if state.state != "done" or process is not self._process:
            return
        try:
            self._outcome = self._store.take_import(target, state.result, self._file.name)
        except Exception as error:  # noqa: BLE001 — or the page would wait for ever
            self._outcome = failure_message(error)

    async def _state(self, request: Request) -> Response:
        process = self._process
        if request.path_params["id"] != self._id or process is None:
            return _gone()
        if self._stage == "importing":
            return json_answer(_imported(process.state, self._outcome))
        state = process.state
        answer = {"stage": "reading", "state": state.state, "words": state.words}
        return json_answer(
            answer | ({"found": asdict(state.result)} if state.state == "done" else {})
        )

    async def _leave(self, request: Request) -> Response:
        if request.path_params["id"] != self._id:
            return _gone()
        await self.close()
        return json_answer({})

    def _is_running(self) -> bool:
        return self._process is not None and self._process.state.state == "running"


def _imported(state: WorkState, outcome: ImportOutcome | str | None) -> dict[str, Any]:
    """Done once the session has it."""
    answer = {"stage": "importing", "state": state.state, "done": state.done, "of": state.of}
    if isinstance(outcome, ImportOutcome):
        return {**answer, **asdict(outcome)}
    if outcome is not None:
        return {**answer, "state": "failed", "words": outcome}
    if state.state == "done":
        return {**answer, "state": "running"}
    return {**answer, "words": state.words}


async def _received(request: Request, folder: Path) -> Path:
    """The file that is sent, in this folder."""
    name = clean_name(request.query_params.get("name", ""))
    content = await read_body(request, LARGEST_KEYPOINT_BYTES, TOO_LARGE)
    if not content:
        raise FormatError(f"{name} is empty.")
    await asyncio.to_thread((folder / name).write_bytes, content)
    return folder / name


def _gone() -> Response:
    return json_answer({"words": "This import is over."}, 404)
