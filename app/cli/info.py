"""`keypose info`: the facts of a video, of meshes, or of a session's bodies."""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from keypose.app.cli.arguments import is_session_named, session_file
from keypose.app.cli.bodies import about_each
from keypose.app.cli.json_output import print_json
from keypose.app.words.problems import repeats_words
from keypose.tracker.body.trajectory import runs
from keypose.tracker.errors import SessionError, SurfaceError
from keypose.tracker.session import Session
from keypose.tracker.storage.files import load_session
from keypose.tracker.storage.results import load_results
from keypose.tracker.surface.files.sequence import MeshSequence, describe_unusable
from keypose.tracker.surface.new_session import first_mesh
from keypose.tracker.surface.picture import CONTAINER
from keypose.tracker.surface.source import holds_meshes
from keypose.tracker.video import Video

Description: TypeAlias = tuple[dict[str, Any], list[str]]
"""The facts, and the same in lines for a person."""


def run(arguments: argparse.Namespace) -> int:
    is_session = is_session_named(arguments.video) and not holds_meshes(arguments.video)
    if arguments.body is not None and not is_session:
        raise SessionError("--body is for a session: give the session's file or folder.")
    if is_session:
        facts, lines = _of_session(arguments)
    elif holds_meshes(arguments.video):
        facts, lines = _of_meshes(arguments.video, arguments.check)
    else:
        facts, lines = _of_video(arguments.video, arguments.check)
    if arguments.json:
        print_json(facts, indent=2)
        return 0
    for line in lines:
        print(line)
    return 0


def _of_session(arguments: argparse.Namespace) -> Description:
    if arguments.check:
        raise SessionError("--check is for a video or meshes: give the session's own.")
    path = session_file(str(arguments.video))
    session = load_session(path)
    each = {about.subject.id: _body_facts(about, path) for about in about_each(session, arguments)}
    facts = {"session": str(path), "video": session.view.video.path, "bodies": each}
    width = max(map(len, each))
    return facts, [str(path), *(_body_line(f"{name:{width}}", each[name]) for name in each)]


def _body_facts(session: Session, path: Path) -> dict[str, Any]:
    subject = session.subject
    states = load_results(session, path).states(session).values()
    return {
        "name": subject.body.name,
        "parts": len(subject.body.parts),
        "keyframes": [keyframe.frame for keyframe in subject.keyframes],
        "drafts": [keyframe.frame for keyframe in subject.drafts],
        "pins": len(subject.pins),
        "segments": dict(Counter(states)),
    }


def _body_line(body_id: str, facts: dict[str, Any]) -> str:
    """Such as "  second  box; parts: 1, keyframes: 4, drafts: 0, segments: 2 good, 1 to check"."""
    words = {"none": "not tracked", "check": "to check"}
    segments = [f"{count} {words.get(state, state)}" for state, count in facts["segments"].items()]
    return (
        f"  {body_id}  {facts['name']}; parts: {facts['parts']}, "
        f"keyframes: {len(facts['keyframes'])}, drafts: {len(facts['drafts'])}, "
        f"segments: {', '.join(segments) or 'none'}"
    )


def _of_video(path: Path, check: bool) -> Description:
    with Video.open(path) as video:
        if check:
            _examine(video)
        facts = {**_facts(video), "checked": check}
    return facts, _lines(facts)


def _examine(video: Video) -> None:
    """Decode every frame; a bar at a terminal says how far it is."""
    from tqdm import tqdm

    count = video.info.frame_count
    with tqdm(total=count, unit="frame", file=sys.stderr, disable=None, leave=False) as bar:
        for reached in video.examine(0, count - 1):
            bar.update(reached + 1 - bar.n)


def _of_meshes(path: Path, check: bool) -> Description:
    with MeshSequence.open(path) as meshes:
        frame, mesh = first_mesh(meshes)
        if check:
            _read_all(meshes)
        facts = {
            "path": str(path),
            "container": CONTAINER,
            "frame_count": meshes.frame_count,
            "units": meshes.stated_units,
            "up": meshes.stated_up,
            "first_mesh": frame,
            "vertices": len(mesh.vertices),
            "faces": len(mesh.faces),
            "extent": mesh.extent.tolist(),
            "rim_edges": len(mesh.rim),
            "consistency": mesh.consistency is not None,
            "missing_frames": sorted(meshes.missing),
            "missing": {str(frame): words for frame, words in sorted(meshes.missing.items())},
            "checked": check,
            "fingerprint": meshes.fingerprint(),
        }
    return facts, _mesh_lines(facts)


def _read_all(meshes: MeshSequence) -> None:
    """Read every mesh: what cannot be used is among its `missing` then."""
    from tqdm import tqdm

    for frame in tqdm(
        range(meshes.frame_count), unit="mesh", file=sys.stderr, disable=None, leave=False
    ):
        with suppress(SurfaceError):
            meshes.mesh(frame)


def _mesh_lines(facts: dict[str, Any]) -> list[str]:
    size = " × ".join(f"{length:.4g}" for length in facts["extent"])
    units = facts["units"] or "units, which the files do not state"
    lines = [
        facts["path"],
        f"  meshes       0 to {facts['frame_count'] - 1}",
        f"  mesh {facts['first_mesh']:<8}{facts['vertices']} vertices, {facts['faces']} faces",
        f"  size         {size} {units}",
        f"  up           {facts['up'] or 'not stated by the files'}",
        f"  fingerprint  {facts['fingerprint']}",
    ]
    rims = facts["rim_edges"]
    unusable = describe_unusable({int(step): words for step, words in facts["missing"].items()})
    notes = {
        f"it has holes: {rims} edges have a face on one side only": rims,
        unusable: unusable,
        "every mesh was read, and all can be used": facts["checked"] and not unusable,
        "every vertex says how well the cameras agree on it": facts["consistency"],
    }
    return lines + [f"  note         {text}" for text, holds in notes.items() if holds]


def _facts(video: Video) -> dict[str, Any]:
    info = video.info
    return {
        "path": str(info.path),
        "container": info.container,
        "codec": info.codec,
        "width": info.width,
        "height": info.height,
        "pixel_aspect": float(info.pixel_aspect),
        "frame_count": info.frame_count,
        "last_frame_s": float(info.times_s[-1]),
        "fps": float(info.fps),
        "variable_rate": info.variable_rate,
        "interlaced": info.interlaced,
        "deinterlaced": info.deinterlaced,
        "rotation_deg": info.rotation_deg,
        "mirrored": info.mirrored,
        "depth": info.depth,
        "numbering": info.numbering,
        "missing_frames": list(info.missing),
        "damaged_frames": list(info.damaged),
        "repeated_frames": list(video.repeats().frames),
        "fingerprint": video.fingerprint(),
        "focal_mm": None if info.lens is None else info.lens.focal_mm,
        "device": None if info.lens is None else info.lens.device,
        "timecode": None if info.timecode is None else str(info.timecode),
    }


def _lines(facts: dict[str, Any]) -> list[str]:
    last = facts["frame_count"] - 1
    rate = "varying, mean " if facts["variable_rate"] else ""
    assumed = ", assumed: images keep none" * (facts["container"] == "images")
    lines = [
        facts["path"],
        f"  pictures     {facts['width']}×{facts['height']} pixels, {facts['codec']} in "
        f"{facts['container']}",
        f"  frames       0 to {last}, the last at {facts['last_frame_s']:.3f} s",
        f"  rate         {rate}{facts['fps']:.3f} frames/s{assumed}",
        f"  fingerprint  {facts['fingerprint']}",
    ]
    if facts["focal_mm"] is not None:
        device = f", {facts['device']}" if facts["device"] else ""
        lines.insert(-1, f"  lens         {facts['focal_mm']:g} mm as on 35 mm film{device}")
    if facts["timecode"] is not None:
        lines.insert(-1, f"  timecode     {facts['timecode']}")
    notes = {
        _turned(facts): facts["rotation_deg"] or facts["mirrored"],
        f"pixels {facts['pixel_aspect']:.4f} times as wide as high": facts["pixel_aspect"] != 1,
        "interlaced: frames are deinterlaced as they are read": facts["interlaced"],
        f"{facts['depth']} of 16 bits are used: they are spread to the full range": facts["depth"],
        facts["numbering"][:1].lower() + facts["numbering"][1:].rstrip("."): facts["numbering"],
        f"{len(facts['missing_frames'])} frames cannot be decoded": facts["missing_frames"],
        _damage(facts): facts["damaged_frames"],
        _repeats(facts): facts["repeated_frames"],
        "every frame was decoded, and none is damaged": facts["checked"]
        and not (facts["missing_frames"] or facts["damaged_frames"]),
    }
    return lines + [f"  note         {text}" for text, holds in notes.items() if holds]


def _turned(facts: dict[str, Any]) -> str:
    """ "rotated by 90° to be upright", "mirrored left to right to be upright"."""
    rotated = f"rotated by {facts['rotation_deg']}°" if facts["rotation_deg"] else ""
    if not facts["mirrored"]:
        return f"{rotated} to be upright"
    return f"{f'{rotated}, then ' if rotated else ''}mirrored {facts['mirrored']} to be upright"


def _repeats(facts: dict[str, Any]) -> str:
    return repeats_words(len(facts["repeated_frames"]), facts["frame_count"]).rstrip(".")


def _damage(facts: dict[str, Any]) -> str:
    """ "60 frames are damaged and not used for tracking: 31–60, 80–109"."""

    frames = facts["damaged_frames"]
    flags = np.isin(np.arange(facts["frame_count"]), frames)
    listed = ", ".join(str(a) if a == b else f"{a}–{b}" for a, b in runs(flags))
    are = "frame is" if len(frames) == 1 else "frames are"
    return f"{len(frames)} {are} damaged and not used for tracking: {listed}"
