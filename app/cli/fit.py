"""`keypose fit`: the motion of a body by observed surfaces, saved beside the session."""

from __future__ import annotations

import argparse
import shlex
from pathlib import Path

from keypose.app.cli.arguments import (
    SESSION,
    SESSION_FOLDER,
)
from keypose.app.cli.outcome import track_and_save
from keypose.app.document.new import path_from
from keypose.app.jobs.rerun import require_trackable, with_settings
from keypose.app.orders.tracking import TrackOrder
from keypose.tracker.errors import SessionError
from keypose.tracker.session import Session
from keypose.tracker.session.evidence import surface_of
from keypose.tracker.session.references import Surface
from keypose.tracker.storage.files import load_session, video_path
from keypose.tracker.surface.cameras.rig import Rig
from keypose.tracker.surface.files.sequence import MeshSequence


def run(arguments: argparse.Namespace) -> int:
    if arguments.session is None:
        arguments.session = _usual_place(arguments.meshes)
    session = _with_meshes(_session(arguments), arguments)
    require_trackable(session, arguments.session)
    surface = _surface(session, arguments)
    session = session.changed({"surface": surface})
    return track_and_save(
        session, with_settings(session, TrackOrder(quality=arguments.quality)), arguments
    )


def _usual_place(meshes: Path | None) -> Path:
    """Where the session lies when nobody says."""
    if meshes is None:
        return Path(SESSION)
    stem = meshes.name if meshes.is_dir() else meshes.stem
    return meshes.with_name(f"{stem}{SESSION_FOLDER}") / SESSION


def _session(arguments: argparse.Namespace) -> Session:
    """The session; a sentence on how to get one where there is none yet."""
    path: Path = arguments.session
    if not path.exists() and arguments.meshes is not None:
        raise SessionError(
            f"There is no session {str(path)!r}: pose the body in one of the meshes first, with "
            f"`keypose open {shlex.quote(str(arguments.meshes))}`."
        )
    session = load_session(path)
    if session.view.surface is None:
        raise SessionError(
            f"{path.name} is about a video: track it with keypose track, or begin a session about "
            "the meshes with `keypose open MESHES`."
        )
    return session


def _with_meshes(session: Session, arguments: argparse.Namespace) -> Session:
    """The session with the meshes that were named, if they are its own, wherever they lie now."""
    meshes, path = arguments.meshes, arguments.session
    if meshes is None or meshes.resolve() == video_path(session, path).resolve():
        return session
    with MeshSequence.open(meshes) as sequence:
        is_own = session.view.video.fingerprint in ("", sequence.fingerprint())
    if not is_own:
        raise SessionError(
            f"{str(meshes)!r} holds other meshes than those that {path.name} was posed in: begin a "
            f"session of their own with `keypose open {shlex.quote(str(meshes))}`."
        )
    video = session.view.video.model_copy(
        update={"path": path_from(meshes, path.absolute().parent)}
    )
    return session.changed({"video": video})


def _surface(session: Session, arguments: argparse.Namespace) -> Surface:
    """How the surfaces are to be fitted. What the poses were set by is not changed."""
    surface = surface_of(session)
    for name, phrase in (("units", "in {}"), ("up", "with {} up")):
        ordered, present = getattr(arguments, name), getattr(surface, name)
        if ordered not in (None, present):
            raise SessionError(
                f"{arguments.session.name} was posed in meshes read {phrase.format(present)}, "
                f"not {phrase.format(ordered)}: change it under Fit in the page, "
                "where the poses follow."
            )
    asked = {name: getattr(arguments, name) for name in ("weights", "distance", "binding")}
    if arguments.cameras is not None:
        Rig.open(arguments.cameras)  # what is wrong with it is said before the work
        asked["cameras"] = path_from(arguments.cameras, arguments.session.absolute().parent)
    chosen = {name: value for name, value in asked.items() if value is not None}
    return surface.model_copy(update=chosen)
