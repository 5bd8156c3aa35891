"""What a tab may ask for: the part under the pointer, pictures, the motion."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal
from urllib.parse import quote

import numpy as np
from pydantic import Field, TypeAdapter, ValidationError
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response
from starlette.routing import Route

from keypose.app.editor.copy_paste import copied_from
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.frames import pointer_views
from keypose.app.editor.message import Message
from keypose.app.editor.motion import feet_paths
from keypose.app.editor.shown import bodies_beside, shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.export.motion_files import File, every_format, motion_archive
from keypose.app.export.motion_formats import formats_of, require_meant
from keypose.app.orders.drawing import PicturesOrder, Viewpoint
from keypose.app.orders.motion import MotionOrder
from keypose.app.orders.order import read_order
from keypose.app.posing import InView, PointerView, outline, parts_at
from keypose.app.posing.gesture import Spot
from keypose.app.render.painting import Figure, form_in
from keypose.app.render.palette import body_colour
from keypose.app.render.stills import from_viewpoint
from keypose.app.render.studio import ViewStyle, png, snapshot
from keypose.app.server.headers import headers_for
from keypose.app.server.surfaces import Surfaces
from keypose.app.store.store import Store
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import KeyposeError, one_sentence
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.session.settings import FrameIndex
from keypose.tracker.storage.files import load_session
from keypose.tracker.storage.fingerprints import has_drafted_keypoints
from keypose.tracker.video import Video


class Pick(Message, InView):
    """Which parts lie under a point of a view."""

    ask: Literal["pick"]
    id: Annotated[int, Field(ge=0, lt=2**53)]
    at: Spot


class CopiedText(Message):
    """Some keyframes, or the pose at the present frame, as text for a clipboard."""

    ask: Literal["copied"]
    id: Annotated[int, Field(ge=0, lt=2**53)]
    frames: Annotated[tuple[FrameIndex, ...], Field(max_length=10_000)] = ()


LEFT_OUT = "X-Keypose-Left-Out"
"""The header that says, percent-encoded, which formats an archive lacks and why."""

MASK_COLOUR = (64, 224, 144)
MASK_OPACITY = 0.55
"""Of the person's mask over the picture: neither side of the body has that colour."""
FREE_SIZE = (1600, 1200)
"""Pixels of a picture of the free view."""


QUESTION: TypeAdapter[Pick | CopiedText] = TypeAdapter(
    Annotated[Pick | CopiedText, Field(discriminator="ask")]
)


class Outputs:
    """Answers made of the store's present state; nothing here changes it."""

    def __init__(self, store: Store, surfaces: Surfaces) -> None:
        self._store, self._surfaces = store, surfaces

    def routes(self) -> list[Route]:
        """Where pictures and motion are to be had."""
        return [
            Route("/picture.png", self._picture),
            Route("/person/{frame:int}.png", self._person),
            Route("/motion", self._motion),
            Route("/report.html", self._report),
        ]

    def answer(self, message: dict[str, Any]) -> dict[str, Any]:
        """The reply to a question of a tab."""
        reply = {"t": "reply", "id": message.get("id")}
        edit = self._store.app_state.edit
        try:
            question = QUESTION.validate_python(message)
        except ValidationError as error:
            return {**reply, "parts": [], "outline": [], "words": one_sentence(error)}
        if isinstance(question, CopiedText):
            return {**reply, "text": _copied_text(edit, question)}
        nothing: dict[str, Any] = {"parts": [], "outline": []}
        try:
            return {**reply, **(nothing if edit is None else _picked(edit, question))}
        except ActionRefused as error:
            return {**reply, **nothing, "words": str(error)}

    async def _picture(self, request: Request) -> Response:
        try:
            order = read_order(PicturesOrder, dict(request.query_params))
            (edit, video), name = await self._require_open(), self._store.name
            asked = order.frames if isinstance(order.frames, int) else edit.frame
            frame = min(asked, edit.frame_count - 1)
            content = await asyncio.to_thread(_png, edit, video, frame, order)
        except (ValidationError, KeyposeError) as error:
            return _refused(error)
        return _download(content, "image/png", f"{name}-{frame}-{_named(order)}.png")

    async def _person(self, request: Request) -> Response:
        frame = request.path_params["frame"]
        try:
            edit, video = await self._require_open()
            drafted = has_drafted_keypoints(edit.settled)  # of which outlines are kept already
            keypoints = None if drafted else self._store.app_state.keypoints.of_segment
            content = await asyncio.to_thread(_person_png, edit, video, frame, keypoints)
        except KeyposeError as error:
            return _refused(error)
        return _download(content, "image/png", f"{self._store.name}-{frame}-person.png")

    async def _motion(self, request: Request) -> Response:
        try:
            texts = dict(request.query_params)
            name_of_format = texts.pop("format", "")
            order = read_order(MotionOrder, texts)
            edit, name = self._edit(), self._store.name
            opened = self._store.opened
            folder = None if opened is None else opened.session_path.absolute().parent
            file = await asyncio.to_thread(_motion_of, name_of_format, order, edit, folder)
        except (ValidationError, KeyposeError) as error:
            return _refused(error)
        response = _download(file.content, file.media_type, f"{name}{file.suffix}")
        response.headers[LEFT_OUT] = quote(file.left_out)
        return response

    async def _report(self, _: Request) -> Response:
        try:
            (_edit, video), name = await self._require_open(), self._store.name
            path = await self._store.saved_path()
            content = await asyncio.to_thread(_report_of, path, video)
        except KeyposeError as error:
            return _refused(error)
        return _download(content, "text/html", f"{name}-report.html")

    def _edit(self) -> EditorState:
        edit = self._store.app_state.edit
        if edit is None:
            raise KeyposeError("Open a video first.")
        return edit

    async def _require_open(self) -> tuple[EditorState, Video]:
        edit, opened = self._edit(), self._store.opened
        if opened is None:
            raise KeyposeError("Open a video first.")
        return edit, await self._surfaces.video(edit) or opened.video


def _copied_text(edit: EditorState | None, question: CopiedText) -> str | None:
    """None where there is nothing of the kind."""
    try:
        return None if edit is None else copied_from(edit, question.frames).text
    except KeyposeError:
        return None


def _picked(edit: EditorState, question: Pick) -> dict[str, Any]:
    view = pointer_views(edit.doc, edit.frame, question.eye, question.film)[question.view]
    parts, edge = _parts_of(edit, view, question.at)
    if parts:
        return {"parts": list(parts), "outline": edge, "body": None}
    for body in edit.doc.bodies:
        alone = edit.about(body.id)
        there, edge = _parts_of(alone, view, question.at)
        if there and body.id != edit.doc.subject.id:
            return {"parts": [], "outline": edge, "body": body.id}
    return {"parts": [], "outline": [], "body": None}


def _parts_of(
    edit: EditorState, view: PointerView, at: Sequence[float]
) -> tuple[tuple[str, ...], list[list[float]]]:
    """The parts of a body at a place, front to back, and the outline of the first."""
    pose = shown_pose(edit).pose
    parts = parts_at(edit.skeleton, pose, view, at)
    edge = outline(edit.skeleton, pose, view, parts[0]).round(4).tolist() if parts else []
    return parts, edge


def _named(order: PicturesOrder) -> str:
    return "free" if isinstance(order.view, Viewpoint) else order.view


def _png(edit: EditorState, video: Video, frame: int, order: PicturesOrder) -> bytes:
    pose, beside = shown_pose(edit, frame).pose, _figures_beside(edit, frame)
    if isinstance(order.view, Viewpoint):
        floor = feet_paths(edit).floor_m
        return png(from_viewpoint(edit.doc, frame, pose, order.view, floor, FREE_SIZE, beside))
    look = ViewStyle(order.view, order.style, order.opacity, order.tint)
    return png(snapshot(edit.doc, video, frame, pose, look, beside))


def _figures_beside(edit: EditorState, frame: int) -> tuple[Figure, ...]:
    """The bodies that are not posed, each in its colour."""
    return tuple(
        Figure(form_in(Skeleton.of(body), body_colour(place)), Ts)
        for place, body, Ts in bodies_beside(replace(edit, frame=frame))
    )


def _person_png(edit: EditorState, video: Video, frame: int, keypoints: Keypoints | None) -> bytes:
    """Where the person is in the camera's picture, in one colour; KeyposeError where nobody is."""
    from keypose.app.export.matte import shown_mask  # its network loads when wanted

    share = shown_mask(edit.settled, video, frame, shown_pose(edit, frame).pose, keypoints)
    colour = np.full((*share.shape, 3), MASK_COLOUR, np.uint8)
    return png(np.dstack([colour, np.round(MASK_OPACITY * share).astype(np.uint8)]))


def _motion_of(name: str, order: MotionOrder, edit: EditorState, folder: Path | None) -> File:
    if name == "all":
        return every_format(edit, order, folder)
    (format_name,) = formats_of(name)
    require_meant(order, [format_name])
    return motion_archive(format_name, edit, order, folder)


def _report_of(path: Path, video: Video) -> bytes:
    from keypose.app.export.report.report import (
        report_html,  # its charts and letters load when wanted
    )

    return report_html(load_session(path), path, video)


def _refused(error: ValidationError | KeyposeError) -> Response:
    words = one_sentence(error) if isinstance(error, ValidationError) else str(error)
    return PlainTextResponse(f"{words}\n", 400, headers_for("data"))


def _download(content: bytes, media_type: str, name: str) -> Response:
    """Shown in the page or saved under this name, as the page asks; never cached by the browser."""
    headers = {
        "Content-Disposition": f"inline; filename*=UTF-8''{quote(name, errors='replace')}",
        "Cache-Control": "no-store",
    }
    return Response(content, media_type=media_type, headers={**headers_for("data"), **headers})
