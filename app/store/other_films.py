"""The pictures of a session's other films; a video is opened when it is first asked for."""

from __future__ import annotations

import asyncio
from pathlib import Path
from typing import NamedTuple

from keypose.app.render.video_frames import Frames
from keypose.app.store.sections.film_values import film_version
from keypose.tracker.errors import VideoError
from keypose.tracker.session.references import VideoReference
from keypose.tracker.session.schema import Session
from keypose.tracker.session.views import View
from keypose.tracker.storage.files import open_video_of
from keypose.tracker.video import Video


class _OpenedFilm(NamedTuple):
    """video: of which `frames` makes pictures.  of: what the session says of its file."""

    video: Video
    frames: Frames
    of: VideoReference


class OtherFilms:
    """All methods are for the loop's thread; videos are opened and closed in others."""

    def __init__(self, session_path: Path) -> None:
        self._session_path = session_path
        self._opened: dict[str, _OpenedFilm] = {}
        self._one_at_a_time = asyncio.Lock()
        self._closed = False

    async def jpeg(self, doc: Session, view: View, index: int, shrink: int = 1) -> bytes:
        """A frame of a view's film as an ideal lens would have taken it, as of `Frames.jpeg`.

        KeyposeError in one sentence where the film is not there, or has no such frame.
        """
        film = await self._film(doc, view)
        return await film.frames.jpeg(index, view.camera, film_version(view), shrink)

    async def close(self) -> None:
        """Close all videos; nothing is opened any more."""
        self._closed = True
        async with self._one_at_a_time:
            for view_id in list(self._opened):
                await self._close(view_id)

    async def _film(self, doc: Session, view: View) -> _OpenedFilm:
        async with self._one_at_a_time:
            if self._closed:
                raise VideoError("The video has been closed.")
            film = self._opened.get(view.id)
            if film is not None and film.of == view.video:
                return film
            await self._close(view.id)
            video = await asyncio.to_thread(open_video_of, doc.alone(view.id), self._session_path)
            film = self._opened[view.id] = _OpenedFilm(video, Frames(video), view.video)
            return film

    async def _close(self, view_id: str) -> None:
        film = self._opened.pop(view_id, None)
        if film is not None:
            film.frames.close()
            await asyncio.to_thread(film.video.close)
