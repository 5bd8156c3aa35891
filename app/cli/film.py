"""`keypose film`: the body over the video, or the motion as a new camera sees it, as a film."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from keypose.app.cli.arguments import note, order_of
from keypose.app.cli.bodies import about_drawn
from keypose.app.cli.json_output import print_json, print_written
from keypose.app.cli.views import session_to_draw, video_if_there
from keypose.app.export.drawable import require_frame, require_tint
from keypose.app.export.film import USUAL_FPS, film_of, film_words, write_film
from keypose.app.orders.drawing import FilmOrder
from keypose.app.render.films import Film
from keypose.app.render.palette import Picture
from keypose.app.render.poses import KnownPoses
from keypose.tracker.session import Session
from keypose.tracker.storage.files import open_video_of


def run(arguments: argparse.Namespace) -> int:
    whole, out = session_to_draw(arguments, "film", ".mp4"), arguments.out
    session, alone = about_drawn(whole, arguments)
    order = order_of(FilmOrder, arguments)
    require_tint(session, order.tint)
    poses = KnownPoses.of(session, arguments.session, alone=alone)
    name = arguments.session.name
    film = film_of(session.subject_in(name) if alone else name, poses, order)
    require_frame(session, film.last)
    with _video(session, arguments.session, film) as video:
        facts = write_film(
            out,
            session,
            video,
            poses,
            film,
            order.fps,
            seen=_with_bar,
            overwrite=arguments.overwrite,
        )
    for words in film_words(session, poses, film):
        note(words)
    if arguments.json:
        print_json({"written": [str(out)], **asdict(facts)})
    else:
        print_written([out], False)
    return 0


def _video(session: Session, session_path: Path, film: Film) -> Any:
    """The video, for its pictures or its times; a new camera does without it, with a note."""
    if film.needs_video:
        return open_video_of(session, session_path)
    if session.evidence.has_surface:  # and the session knows the pace
        return video_if_there(session, session_path, "the body is filmed without its surface")
    paced = len(session.subject.keyframes) > 1
    pace = (
        "the film's rate is that of the keyframes' times"
        if paced
        else f"the film has {USUAL_FPS:g} frames a second"
    )
    return video_if_there(session, session_path, pace)


def _with_bar(pictures: Iterator[Picture], count: int) -> Iterator[Picture]:
    """Show at a terminal how far it is and how long it will take."""
    if not sys.stderr.isatty():
        yield from pictures
        return
    from tqdm import tqdm

    with tqdm(total=count, unit="frame", file=sys.stderr, dynamic_ncols=True) as bar:
        for picture in pictures:
            yield picture
            bar.update()
