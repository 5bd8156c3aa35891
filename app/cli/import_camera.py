"""`keypose import --camera`: the lens, what is up and the floor, from another program's camera."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from keypose.app.cli.arguments import note, order_of
from keypose.app.cli.json_output import print_json
from keypose.app.export.import_camera import (
    SAME_DEG,
    brought,
    film_or_none,
    reading_of,
    with_camera_file,
)
from keypose.app.export.recognising import camera_facts
from keypose.app.orders.imports import ImportCamera
from keypose.app.words.camera import imported_words
from keypose.app.words.imports import note_words
from keypose.tracker.apart import reading_apart
from keypose.tracker.formats.reading_camera import CameraFile, load_camera
from keypose.tracker.session import Session
from keypose.tracker.storage.files import load_session, open_video_of, save_session


def import_camera(arguments: argparse.Namespace) -> None:
    """Read the file into the session, which nobody else has open, and say what changed."""
    path, file = arguments.session, arguments.file
    order = order_of(ImportCamera, arguments)
    with reading_apart(load_camera) as read:
        session = load_session(path)
        size = (session.view.camera.width, session.view.camera.height)
        camera_file = read(file, size, reading_of(order))
    if camera_file.way is not None:
        with film_or_none(lambda: open_video_of(session, path)) as video:
            camera_file = brought(session, camera_file, file.name, order, video)
    made = with_camera_file(session, camera_file, file.name)
    save_session(made, path)
    if arguments.json:
        print_json(_facts(made, camera_file, path))
    else:
        _print(session, made, camera_file)
        print(f"Written: {path}")
    for words in note_words(camera_file.notes):
        note(words)


def _facts(made: Session, camera_file: CameraFile, path: Path) -> dict[str, Any]:
    camera, up = made.view.camera, made.world.up.tolist()
    lens = {"fx": camera.fx, "fy": camera.fy, "cx": camera.cx, "cy": camera.cy}
    return {
        "written": str(path),
        **lens,
        "up_camera": up,
        "floor_m": made.world.floor_m,
        "background_px": camera_file.background_px,
        "notes": note_words(camera_file.notes),
    }


def _print(session: Session, made: Session, camera_file: CameraFile) -> None:
    facts = camera_facts(session, made, camera_file)
    focal, across, turned = facts["focal_mm"], facts["across_deg"], facts["turned_deg"]
    print(f"Lens: {focal:.1f} mm on 35 mm film, {across:.1f}° across.")
    print(f"Up: turned by {turned:.1f}°." if turned > SAME_DEG else "Up: as it was.")
    if facts["floor_m"] is not None:
        print(f"Floor: {facts['floor_m']:.2f} m below the camera.")
    if camera_file.way is not None:
        print(f"The camera moves over {len(camera_file.way.frames)} frames of the file.")
    for sentence in imported_words(made, camera_file.background_px):
        print(sentence)
