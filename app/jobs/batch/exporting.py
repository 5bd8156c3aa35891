"""The motion of one session of a batch as files for other programs."""

from __future__ import annotations

from pathlib import Path

from keypose.app.export.motion_files import motion_files, saved_motion
from keypose.app.export.motion_formats import FORMATS
from keypose.app.jobs.batch.finding import SESSION
from keypose.app.jobs.batch.task import Export
from keypose.tracker.errors import FormatError
from keypose.tracker.storage.atomic import make_folder, write_file
from keypose.tracker.storage.files import load_session, open_video_of
from keypose.tracker.storage.tracks import load_tracks


def export_of(session: Path, folder: Path, out: Path | None, formats: tuple[str, ...]) -> Export:
    """Where the files of a session in `folder` go: beside it, or to the same place below `out`.

    A session that is not called session.json gives its name to its files.
    """
    place = session.parent if out is None else out / session.parent.relative_to(folder)
    prefix = "" if session.name == SESSION else f"{session.stem}-"
    return Export(formats, place, prefix)


def places(export: Export) -> list[Path]:
    """The files that there will be."""
    names = [name for one in FORMATS if one in export.formats for name in FORMATS[one].names]
    return [export.folder / f"{export.prefix}{name}" for name in names]


def export_motion(session_path: Path, export: Export) -> tuple[str, ...]:
    """Write the session's motion in every format; the files. FormatError when one cannot be."""
    session = load_session(session_path)
    tracks = load_tracks(session, session_path)
    with open_video_of(session, session_path) as video:
        times_s = session.evidence.times_s(video.info.times_s)
        recording = saved_motion(session, tracks, times_s, video.info.timecode)
    make_folder(export.folder, error=FormatError)
    written = []
    for format_name in FORMATS:
        if format_name not in export.formats:
            continue
        for name, content in motion_files(format_name, recording).items():
            place = export.folder / f"{export.prefix}{name}"
            write_file(place, content, overwrite=True)
            written.append(str(place))
    return tuple(written)
