"""Films, sheets and pictures of a saved session as files, as the page orders them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

from keypose.app.export.film import film_of, film_words, write_film
from keypose.app.export.matte import FILMS, matte_of, write_film_with_alpha, write_zip
from keypose.app.export.pictures import sheet_png, write_pictures
from keypose.app.orders.drawing import FilmOrder, MatteOrder, PicturesOrder, SheetOrder
from keypose.app.render.palette import Picture
from keypose.app.render.poses import KnownPoses
from keypose.app.render.stills import still
from keypose.app.render.studio import png
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.files import open_video_of


def write_drawn(
    session: Session,
    path: Path,
    order: FilmOrder | SheetOrder | PicturesOrder | MatteOrder,
    out: Path,
    progress: Callable[[int, int], None],
) -> str:
    """Write what is ordered; what should be known of it, sentences. A film is as `keypose film`
    writes it, a sheet as `keypose sheet`, pictures as `keypose shot`, several in one zip, a matte
    as `keypose matte`."""
    with open_video_of(session, path) as video:
        if isinstance(order, MatteOrder):
            matte = matte_of(session, path.name, video, order, progress)
            (write_film_with_alpha if order.kind in FILMS else write_zip)(out, matte)
            return matte.words
        if isinstance(order, SheetOrder):
            content, problem = sheet_png(session, path, video, order, progress)
            out.write_bytes(content)
            return problem or ""
        poses = KnownPoses.of(session, path, alone=False)
        if isinstance(order, FilmOrder):
            film = film_of(path.name, poses, order)

            def seen(pictures: Iterator[Picture], count: int) -> Iterator[Picture]:
                for done, picture in enumerate(pictures, start=1):
                    yield picture
                    progress(done, count)

            write_film(out, session, video, poses, film, order.fps, seen=seen)
            return " ".join(film_words(session, poses, film))
        if isinstance(order.frames, int):
            out.write_bytes(png(still(session, video, order.frames, poses, order)))
            return ""
        keys = [keyframe.frame for keyframe in session.subject.keyframes]
        frames = keys if order.frames == "keyframes" else list(poses.frames)
        write_pictures(out, session, video, poses, frames, order, progress)
        return ""
