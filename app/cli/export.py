"""`keypose export`: the tracked motion for other programs."""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from keypose.app.cli.arguments import note, order_of
from keypose.app.cli.bodies import about_each
from keypose.app.cli.json_output import print_written
from keypose.app.cli.views import video_if_there
from keypose.app.export.motion_files import (
    files_of_bodies,
    outdated_files,
    sampling_sentences,
    saved_motions,
    unknown_errors_words,
)
from keypose.app.export.motion_formats import require_meant
from keypose.app.orders.motion import MotionOrder
from keypose.app.words.bodies import after_id
from keypose.app.words.camera import unscaled_words
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.recording import Recording
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session import Session
from keypose.tracker.session.bodies import bodies_words
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
    bodies = _recordings(session, arguments)
    files, refused = dict[str, bytes](), list[str]()
    for format_name in arguments.format:
        of_format, not_written = files_of_bodies(format_name, bodies, order)
        files |= of_format
        refused += not_written
    for_model = None
    if arguments.model is not None:
        from keypose.app.export.opensim_files import files_for_model  # loads what only this needs

        if len(bodies) > 1:
            raise FormatError("--model is for one body: choose it with --body.")
        for_model = files_for_model(bodies[0], order, arguments.model, arguments.out)
        files |= for_model.files
    places = {arguments.out / name: content for name, content in files.items()}
    if not arguments.overwrite:
        require_absent(places)
    require_folder(arguments.out)
    make_folder(arguments.out)
    for place, content in places.items():
        write_file(place, content, overwrite=arguments.overwrite)
    for format_name in arguments.format if arguments.overwrite else ():
        for name in outdated_files(format_name, files, [body.body_id for body in bodies]):
            (arguments.out / name).unlink(missing_ok=True)
    print_written(places, arguments.json)
    note(for_model.words if for_model else None)
    for words in (*refused, *sampling_sentences(bodies, order, arguments.format)):
        note(words)
    for format_name in arguments.format:
        note(unknown_errors_words(format_name, files, [body.body_id for body in bodies]))
    note(unscaled_words(session))
    return 0


def _recordings(session: Session, arguments: argparse.Namespace) -> list[Recording]:
    """The motion of the bodies to export, in the world of all that are tracked, with a note of
    those that have none; SessionError where none has one."""
    path, abouts = arguments.session, about_each(session, arguments)
    asked = [about.subject for about in abouts]
    left = [body for body in asked if body.results is None]
    if len(left) == len(asked):
        load_tracks(abouts[0], path)  # which says so
    if left:
        verb = "is" if len(left) == 1 else "are"
        note(f"{bodies_words(left)} {verb} not tracked and left out.")
    tracked = [session.about(body.id) for body in session.bodies if body.results is not None]
    tracks = {about.subject.id: load_tracks(about, path) for about in tracked}
    folder = path.absolute().parent
    bodies = saved_motions(session, tracks, *_clock(tracked[0], path), folder)
    ids = ["", *(body.id for body in asked)]
    for about in tracked:
        if about.subject in asked:
            words = outdated_words(about, tracks[about.subject.id])
            if words is not None:
                note(after_id(words, about.subject.id, session))
    return [body for body in bodies if body.body_id in ids]


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
