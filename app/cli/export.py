"""`keypose export`: the tracked motion for other programs."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from keypose.app.cli.arguments import (
    note,
    order_of,
)
from keypose.app.cli.json_output import print_written
from keypose.app.cli.views import video_if_there
from keypose.app.export.motion_files import (
    motion_files,
    outdated_files,
    sampling_words,
    saved_motion,
)
from keypose.app.export.motion_formats import require_meant
from keypose.app.orders.motion import MotionOrder
from keypose.app.words.camera import unscaled_words
from keypose.tracker.errors import FormatError
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session import Session
from keypose.tracker.storage.atomic import (
    make_folder,
    require_absent,
    require_folder,
    write_file,
)
from keypose.tracker.storage.files import load_session
from keypose.tracker.storage.outdated import outdated_words
from keypose.tracker.storage.tracks import load_tracks
from keypose.tracker.video.info import Timecode


def run(arguments: argparse.Namespace) -> int:
    order = order_of(MotionOrder, arguments)
    require_meant(order, arguments.format)
    session = load_session(arguments.session)
    tracks = load_tracks(session, arguments.session)
    folder = arguments.session.absolute().parent
    recording = saved_motion(session, tracks, *_clock(session, arguments.session), folder)
    files = {
        name: content
        for format_name in arguments.format
        for name, content in motion_files(format_name, recording, order).items()
    }
    for_model = None
    if arguments.model is not None:
        from keypose.app.export.opensim_files import files_for_model  # loads what only this needs

        for_model = files_for_model(recording, order, arguments.model, arguments.out)
        files |= for_model.files
    places = {arguments.out / name: content for name, content in files.items()}
    if not arguments.overwrite:
        require_absent(places)
    require_folder(arguments.out)
    make_folder(arguments.out)
    for place, content in places.items():
        write_file(place, content, overwrite=arguments.overwrite)
    for format_name in arguments.format if arguments.overwrite else ():
        for name in outdated_files(format_name, files):
            (arguments.out / name).unlink(missing_ok=True)
    print_written(places, arguments.json)
    note(for_model.words if for_model else None)
    note(sampling_words(recording, order, arguments.format))
    note(unscaled_words(session))
    note(outdated_words(session, tracks))
    return 0


def _clock(session: Session, session_path: Path) -> tuple[Array, Timecode | None]:
    """The time of every frame, and the timecode; from the keyframes, with a word on it, when the
    video is gone."""
    with video_if_there(session, session_path, "times are those between keyframes") as video:
        if video is not None:
            return session.evidence.times_s(video.info.times_s), video.info.timecode
    if session.evidence.fps is not None:
        return session.evidence.times_s(None), None
    frames = [keyframe.frame for keyframe in session.subject.keyframes]
    times_s = [keyframe.time_s for keyframe in session.subject.keyframes]
    if len(frames) < 2 or min(np.diff(times_s)) <= 0:
        raise FormatError("Without the video, two keyframes with ascending times are needed.")
    return np.interp(np.arange(session.view.video.frame_count), frames, times_s), None
