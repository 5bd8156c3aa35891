"""`keypose shot`: a picture of the posed body, over the video or from anywhere."""

from __future__ import annotations

import argparse
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

from keypose.app.cli.arguments import note, order_of
from keypose.app.cli.bodies import about_drawn
from keypose.app.cli.json_output import print_written
from keypose.app.cli.views import session_to_draw, video_if_there
from keypose.app.export.drawable import require_frame, require_tint
from keypose.app.orders.drawing import PictureOrder
from keypose.app.orders.values import MOST_PIXELS
from keypose.app.render.poses import KnownPoses
from keypose.app.render.stills import still
from keypose.app.render.studio import png
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError, SessionError
from keypose.tracker.session import Session
from keypose.tracker.storage.atomic import write_file
from keypose.tracker.storage.files import open_video_of
from keypose.tracker.storage.outdated import outdated_words
from keypose.tracker.storage.tracks import load_tracks


def run(arguments: argparse.Namespace) -> int:
    whole, out = session_to_draw(arguments, "picture", ".png"), arguments.out
    session, alone = about_drawn(whole, arguments)
    if not alone:
        session = _about_posed_at(session, arguments.session, arguments.frame)
    order = order_of(PictureOrder, arguments)
    require_tint(session, order.tint)
    _require_size(session, order)
    poses = _poses(session, arguments.session, arguments.frame, order)
    if not alone:
        poses = replace(poses, beside=KnownPoses.others(session, arguments.session))
    content = _content(session, poses, order, arguments)
    write_file(out, content, overwrite=arguments.overwrite)
    print_written([out], arguments.json)
    return 0


def _about_posed_at(session: Session, session_path: Path, frame: int) -> Session:
    """The session about a body that has a pose at the frame, where one has: its own if it can."""
    each = (session, *(session.about(body.id) for body in session.bodies))
    posed = (about for about in each if KnownPoses.of(about, session_path).pose(frame) is not None)
    return next(posed, session)


def _require_size(session: Session, order: PictureOrder) -> None:
    pixels = session.view.video.width * session.view.video.height * order.scale**2
    if order.scale > 1 and pixels > MOST_PIXELS:
        raise FormatError(
            f"A scale of {order.scale:g} makes a picture of {pixels / 1e6:.0f} million pixels; "
            f"at most {MOST_PIXELS // 10**6} million are drawn."
        )


def _poses(session: Session, session_path: Path, frame: int, order: PictureOrder) -> KnownPoses:
    """The poses with the one to draw; SessionError when the frame is neither a keyframe nor
    tracked.
    """
    require_frame(session, frame)
    skeleton = Skeleton.of(session.subject.body)
    keys = {keyframe.frame: keyframe.pose(skeleton) for keyframe in session.subject.keyframes}
    if frame in keys and not (order.has_floor and session.subject.results):
        return KnownPoses(skeleton, keys, None)
    tracks = load_tracks(session, session_path)
    if frame not in keys:
        if tracks.pose(frame) is None:
            raise SessionError(
                f"Frame {frame} is not tracked; the tracked frames are {tracks.runs()}."
            )
        note(outdated_words(session, tracks))
    return KnownPoses(skeleton, keys, tracks)


def _content(
    session: Session, poses: KnownPoses, order: PictureOrder, arguments: argparse.Namespace
) -> bytes:
    """The PNG file's bytes."""
    with _open_source(session, arguments.session, order) as video:
        content = png(still(session, video, arguments.frame, poses, order))
        if video is not None:
            note(video.note(arguments.frame))
    return content


def _open_source(session: Session, session_path: Path, order: PictureOrder) -> Any:
    """The video, or the surfaces around the body, where the picture shows them."""

    if order.needs_video:
        return open_video_of(session, session_path)
    if order.on_nothing or not session.evidence.has_surface:
        return nullcontext()
    return video_if_there(session, session_path, "the body is drawn without its surface")
