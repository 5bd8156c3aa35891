"""Long exports of the page: begun, asked about, cancelled, fetched. One at a time."""

from __future__ import annotations

import asyncio
import importlib.util
import secrets
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import Field, FiniteFloat, TypeAdapter, ValidationError, model_validator
from starlette.requests import ClientDisconnect, Request
from starlette.responses import FileResponse, Response
from starlette.routing import Route

from keypose.app.editor.message import Degrees, Message
from keypose.app.export.drawable import (
    LARGEST_SIDE,
    MOST_PIXELS,
    SMALLEST_SIDE,
    require_frame,
    require_tint,
)
from keypose.app.export.film import FilmOrder
from keypose.app.jobs.exchange import (
    Export,
    ExportWork,
    FilmExport,
    PicturesExport,
    SheetExport,
    fps_of,
)
from keypose.app.jobs.side_process import SideProcess, WorkState
from keypose.app.render.films import FilmView
from keypose.app.render.stills import Still
from keypose.app.render.studio import Paint, ViewStyle
from keypose.app.render.tints import Tint
from keypose.app.render.viewpoints import Viewpoint
from keypose.app.server.headers import headers_for, json_answer, read_body
from keypose.app.store.store import Store
from keypose.tracker.errors import FormatError, KeyposeError, one_sentence
from keypose.tracker.scratch import Scratch
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import FrameIndex
from keypose.tracker.video.encode import can_write_films

LARGEST_ORDER = 1 << 14
TOO_LONG = "The order of an export is too long."
LIBRARIES = {"c3d": "ezc3d", "usd": "pxr"}
"""By format of motion, the module that it needs, which an extra of the same name installs."""
FILM_REMEDY = "pip install --force-reinstall av"

Side: TypeAlias = Annotated[int, Field(ge=SMALLEST_SIDE, le=LARGEST_SIDE)]


class _Drawn(Message):
    """How the body is drawn over the video."""

    style: Literal["wire", "solid", "both"] = "both"
    opacity: Annotated[FiniteFloat, Field(ge=0, le=1)] = 0.5
    tint: Tint = "clay"

    @property
    def paint(self) -> Paint:
        return Paint(self.style, self.opacity)

    def require(self, session: Session) -> None:
        """KeyposeError where it cannot be drawn of this session."""
        require_tint(session, self.tint)


class _Sized(_Drawn):
    """With a view and a size; `camera` and `orbit` of a picture look from azimuth and elevation."""

    view: Literal["main", "top", "side", "front", "all", "orbit", "camera"] = "main"
    azimuth: Degrees = 0.0
    elevation: Annotated[FiniteFloat, Field(ge=-90, le=90)] = 12.0
    size: tuple[Side, Side] | None = None

    @property
    def viewpoint(self) -> Viewpoint:
        return Viewpoint(self.azimuth % 360.0, self.elevation)

    @model_validator(mode="after")
    def _is_not_too_large(self) -> _Sized:
        if self.size is not None and self.size[0] * self.size[1] > MOST_PIXELS:
            raise ValueError(f"more than {MOST_PIXELS // 10**6} million pixels")
        return self


class Film(_Sized):
    """The motion as a film; without frames from the first pose to the last."""

    what: Literal["film"]
    frames: tuple[FrameIndex, FrameIndex] | None = None
    fps: Annotated[FiniteFloat, Field(ge=0.1, le=1000)] | None = None

    @property
    def export(self) -> Export:
        view: FilmView = self.viewpoint if self.view == "camera" else self.view
        order = (view, self.frames, self.paint, self.size, self.tint, fps_of(self.fps))
        return FilmExport(FilmOrder(*order))

    def require(self, session: Session) -> None:
        super().require(session)
        if self.frames is not None:
            if self.frames[0] > self.frames[1]:
                raise FormatError("The last frame of a film comes after its first.")
            require_frame(session, self.frames[1])


class Sheet(_Drawn):
    """All keyframes on one picture."""

    what: Literal["sheet"]
    columns: Annotated[int, Field(ge=1, le=100)] | None = None

    @property
    def export(self) -> Export:
        return SheetExport(ViewStyle("main", self.style, self.opacity, self.tint), self.columns)


class Pictures(_Sized):
    """A picture of every keyframe, of every frame that has a pose, or of one frame."""

    what: Literal["pictures"]
    frames: Literal["keyframes", "posed"] | FrameIndex = "keyframes"
    background: Literal["video", "none"] = "video"

    @property
    def export(self) -> Export:
        view: Any = self.viewpoint if self.view in ("orbit", "camera") else self.view
        nothing = self.background == "none"
        still = Still(view, self.paint, self.size, on_nothing=nothing, tint=self.tint)
        return PicturesExport(still, self.frames)

    def require(self, session: Session) -> None:
        super().require(session)
        if isinstance(self.frames, int):
            require_frame(session, self.frames)


Order: TypeAlias = Annotated[Film | Sheet | Pictures, Field(discriminator="what")]
ORDER: TypeAdapter[Film | Sheet | Pictures] = TypeAdapter(Order)


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
            order = ORDER.validate_json(await read_body(request, LARGEST_ORDER, TOO_LONG))
            async with self._beginning:
                return await self._start(order)
        except ValidationError as error:
            return json_answer({"words": one_sentence(error)}, 400)
        except (KeyposeError, ClientDisconnect, OSError) as error:
            return json_answer({"words": str(error)}, 400)

    async def _start(self, order: Film | Sheet | Pictures) -> Response:
        if self._process is not None and self._process.state.state == "running":
            words = "Another export is under way. Wait for it or cancel it."
            return json_answer({"words": words}, 409)
        path = await self._store.saved_path()
        edit, opened = self._store.app_state.edit, self._store.opened
        if edit is None or opened is None:
            raise FormatError("Open a video first.")
        order.require(edit.doc)
        await self.close()
        self._scratch = await asyncio.to_thread(Scratch, "export")
        export = order.export
        self._out = self._scratch.path / f"export{Path(export.suffix).suffix}"
        work = ExportWork(export, path, self._out)
        self._process = await asyncio.to_thread(SideProcess, work)
        self._id = secrets.token_hex(8)
        self._name = f"{self._store.name}{export.suffix}"
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
        for name, module in LIBRARIES.items()
        if importlib.util.find_spec(module) is None
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
