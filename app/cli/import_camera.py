"""`keypose import --camera`: the lens, what is up and the floor, from another program's camera."""

from __future__ import annotations

import argparse
from pathlib import Path

from keypose.app.cli.json_output import print_json
from keypose.app.export.import_camera import SAME_DEG, with_camera_file
from keypose.app.export.recognising import camera_facts
from keypose.app.words.camera import finding_sentences
from keypose.tracker.body.heading import CAMERA_UP
from keypose.tracker.formats.apart import reading_apart
from keypose.tracker.formats.reading_camera import load_camera
from keypose.tracker.storage.files import load_session, save_session


def import_camera(arguments: argparse.Namespace) -> None:
    """Read the file into the session, which nobody else has open, and say what changed."""
    path: Path = arguments.session
    with reading_apart(load_camera) as read:
        session = load_session(path)
        found = read(arguments.file, (session.view.camera.width, session.view.camera.height))
    made = with_camera_file(session, found, arguments.file.name)
    save_session(made, path)
    camera = made.view.camera
    if arguments.json:
        lens = {"fx": camera.fx, "fy": camera.fy, "cx": camera.cx, "cy": camera.cy}
        up = list(made.world.up_world or CAMERA_UP)
        print_json({"written": str(path), **lens, "up_camera": up, "floor_m": made.world.floor_m})
        return
    facts = camera_facts(session, made, found)
    focal, across, turned = facts["focal_mm"], facts["across_deg"], facts["turned_deg"]
    print(f"Lens: {focal:.1f} mm on 35 mm film, {across:.1f}° across.")
    print(f"Up: turned by {turned:.1f}°." if turned > SAME_DEG else "Up: as it was.")
    if facts["floor_m"] is not None:
        print(f"Floor: {facts['floor_m']:.2f} m below the camera.")
    if found.way is not None and made.view.camera_motion is not None:
        print(f"The camera moves over {len(found.way.frames)} frames of the file.")
        for sentence in finding_sentences(made.view.camera_motion.findings):
            print(sentence)
    print(f"Written: {path}")
