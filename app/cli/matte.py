"""`keypose matte`: the person cut out of the film, as PNG pictures or a film with alpha."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from keypose.app.cli.arguments import note, order_of
from keypose.app.cli.bodies import about_one
from keypose.app.cli.json_output import print_json
from keypose.app.export.drawable import require_frame
from keypose.app.export.matte import (
    FILMS,
    frames_of,
    matte_of,
    write_film_with_alpha,
    write_pictures_into,
)
from keypose.app.export.picture_names import picture_names
from keypose.app.orders.drawing import MatteOrder
from keypose.tracker.errors import FormatError
from keypose.tracker.keypoints.on_body import is_persons
from keypose.tracker.storage.atomic import require_absent, require_folder, sweep
from keypose.tracker.storage.files import load_session, open_video_of


def run(arguments: argparse.Namespace) -> int:
    whole, out = load_session(arguments.session), arguments.out
    session = about_one(whole, arguments, lambda subject: is_persons(subject.body))
    order = order_of(MatteOrder, arguments)
    first, last = frames_of(session, order)
    require_frame(session, last)
    is_film = order.kind in FILMS
    if is_film and out.suffix.lower() != f".{order.kind}":
        raise FormatError(f"{str(out)!r} must end in .{order.kind}, the format of the film.")
    require_folder(out.parent if is_film else out)
    with open_video_of(session, arguments.session) as video, _bar() as progress:
        names = [] if is_film else picture_names(video.info, range(first, last + 1))
        written = [out / name for name in names] or [out]
        if not arguments.overwrite:
            require_absent(written)
        matte = matte_of(session, arguments.session.name, video, order, progress)
        if is_film:
            sweep(out.parent)
            write_film_with_alpha(out, matte, overwrite=arguments.overwrite)
        else:
            write_pictures_into(out, matte, overwrite=arguments.overwrite)
    note(matte.words or None)
    if arguments.json:
        of_frames = {"empty": list(matte.empty), "maybe_another": list(matte.maybe_another)}
        print_json({"written": list(map(str, written)), "frames": [first, last], **of_frames})
    else:
        pictures = "1 picture" if len(written) == 1 else f"{len(written)} pictures"
        print(f"Written: {out}" if is_film else f"Written: {pictures} in {out}")
    return 0


@contextmanager
def _bar() -> Iterator[Callable[[int, int], None]]:
    """Show at a terminal how far it is: every frame is looked at, and then written."""
    if not sys.stderr.isatty():
        yield lambda done, of: None
        return
    from tqdm import tqdm

    with tqdm(unit="step", file=sys.stderr, dynamic_ncols=True) as bar:

        def report(done: int, of: int) -> None:
            bar.n, bar.total = done, of
            bar.refresh()

        yield report
