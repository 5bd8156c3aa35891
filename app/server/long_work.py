"""Work of the page in a process of its own, one of a kind at a time: begun, asked about, left."""

from __future__ import annotations

import asyncio
import secrets
from collections.abc import Awaitable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError
from starlette.requests import ClientDisconnect, Request
from starlette.responses import Response
from starlette.routing import Route

from keypose.app.editor.documents import ActionRefused
from keypose.app.jobs.side_process import SideProcess, Work, WorkState
from keypose.app.orders.order import read_order
from keypose.app.server.headers import json_answer, read_body
from keypose.app.store.store import Store
from keypose.tracker.errors import FormatError, KeyposeError, one_sentence
from keypose.tracker.scratch import Scratch

OrderT = TypeVar("OrderT")
LARGEST_ORDER = 1 << 16
TEXTS: TypeAdapter[dict[str, str | list[str]]] = TypeAdapter(dict[str, str | list[str]])


class LongWork:
    """Its routes, and the one that is under way. kind: "export" or "import"."""

    def __init__(self, store: Store, kind: str) -> None:
        self.store, self._what = store, kind
        self._id = ""
        self.process: SideProcess | None = None
        self._scratch: Scratch | None = None
        self._beginning = asyncio.Lock()

    def routes(self) -> list[Route]:
        """Where the page asks for all this."""
        place, of_id = f"/{self._what}s", f"/{self._what}s/{{id}}"
        return [
            Route(place, self._new, methods=["POST"]),
            Route(of_id, self._state),
            Route(of_id, self._leave, methods=["DELETE"]),
        ]

    async def begin(self, request: Request) -> Any:
        """Begin it, and say so to the page; KeyposeError where it is refused."""
        raise NotImplementedError

    def described(self, state: WorkState) -> dict[str, Any]:
        """What the page is told of its state."""
        raise NotImplementedError

    async def close(self) -> None:
        """End what is under way, and leave no files."""
        process, self.process = self.process, None
        if process is not None:
            await asyncio.to_thread(process.cancel)
        scratch, self._scratch = self._scratch, None
        if scratch is not None:
            await asyncio.to_thread(scratch.close)

    async def answer(self, beginning: Awaitable[Any]) -> Response:
        """What comes of beginning it, or why that was refused."""
        try:
            async with self._beginning:
                return json_answer(await beginning)
        except ValidationError as error:
            words = one_sentence(error)
        except KeyposeError as error:
            words = str(error)
        except ClientDisconnect:
            words = "It was not brought whole. Try again."
        except OSError as error:
            words = f"It cannot be kept: {error.strerror or error}."
        return json_answer({"words": words}, 400)

    async def order_in(
        self, request: Request, key: str, kinds: Mapping[str, type[OrderT]]
    ) -> OrderT:
        """The order in a request; ValidationError or FormatError where it is none."""
        too_long = f"The order of an {self._what} is too long."
        texts = TEXTS.validate_json(await read_body(request, LARGEST_ORDER, too_long))
        kind, kinds_listed = str(texts.pop(key, "")), ", ".join(kinds)
        if kind not in kinds:
            raise FormatError(
                f"There is no {self._what} {kind[:40]!r}; choose from {kinds_listed}."
            )
        return read_order(kinds[kind], texts)

    def require_idle(self) -> None:
        """Refused while it is at work."""
        if self.process is not None and self.process.state.state == "running":
            raise ActionRefused(f"Another {self._what} is under way. Wait for it or cancel it.")

    async def folder_anew(self) -> Path:
        """An empty folder and another id, in place of what is under way."""
        await self.close()
        self._id = secrets.token_hex(8)
        self._scratch = await asyncio.to_thread(Scratch, self._what)
        return self._scratch.path

    async def start(self, work: Work) -> dict[str, str]:
        """Start it, and tell the page its id."""
        self.process = await asyncio.to_thread(SideProcess, work)
        return {"id": self._id}

    def under_way(self, request: Request) -> SideProcess | None:
        """What the request names, unless it is over."""
        return self.process if request.path_params["id"] == self._id else None

    def gone(self) -> Response:
        return json_answer({"words": f"This {self._what} is over."}, 404)

    async def _new(self, request: Request) -> Response:
        return await self.answer(self.begin(request))

    async def _state(self, request: Request) -> Response:
        process = self.under_way(request)
        return self.gone() if process is None else json_answer(self.described(process.state))

    async def _leave(self, request: Request) -> Response:
        process = self.under_way(request)
        if process is None:
            return self.gone()
        await self.close()
        return json_answer(self.described(process.state))
