"""`keypose info`: the facts of a video."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from app.commands.arguments import Subcommands, add_command, add_json, file_name
from app.commands.json_output import print_json

if TYPE_CHECKING:
    from tracker.video import Video

_EXAMPLES = """\
  keypose info jump.mp4
  keypose info jump.mp4 --json
"""


def add(commands: Subcommands) -> None:
    text = "Tell size, frames, rate and fingerprint of a video file or a folder of images."
    command = add_command(commands, "info", run, text, _EXAMPLES)
    command.add_argument("video", metavar="VIDEO", type=file_name, help="the video")
    add_json(command)


def run(arguments: argparse.Namespace) -> int:
    from tracker.video import Video

    with Video.open(arguments.video) as video:
        facts = _facts(video)
    if arguments.json:
        print_json(facts, indent=2)
        return 0
    for line in _lines(facts):
        print(line)
    return 0


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
        "rotation_deg": info.rotation_deg,
        "missing_frames": list(info.missing),
        "fingerprint": video.fingerprint(),
    }


def _lines(facts: dict[str, Any]) -> list[str]:
    last = facts["frame_count"] - 1
    rate = "varying, mean " if facts["variable_rate"] else ""
    lines = [
        facts["path"],
        f"  pictures     {facts['width']}×{facts['height']} pixels, {facts['codec']} in "
        f"{facts['container']}",
        f"  frames       0 to {last}, the last at {facts['last_frame_s']:.3f} s",
        f"  rate         {rate}{facts['fps']:.3f} frames/s",
        f"  fingerprint  {facts['fingerprint']}",
    ]
    notes = {
        f"turned by {facts['rotation_deg']}° to stand upright": facts["rotation_deg"],
        f"pixels {facts['pixel_aspect']:.4f} times as wide as high": facts["pixel_aspect"] != 1,
        "interlaced: two half pictures are woven into one": facts["interlaced"],
        f"{len(facts['missing_frames'])} frames cannot be decoded": facts["missing_frames"],
    }
    return lines + [f"  note         {text}" for text, holds in notes.items() if holds]
