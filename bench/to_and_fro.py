"""Sessions about long films of a person who goes to and fro: a sample's frames, again and again."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import av

from bench.stand import FPS
from keypose.tracker.video import Video


def to_and_fro(sample: Path, frames: int, size: tuple[int, int], folder: Path) -> Path:
    """A session about so many frames, (width, height) pixels, in a new folder; its file.

    sample: a folder with a session, and a film by its own name. The film runs from the first
    keyframe to the last and back, with a keyframe wherever it comes by one.
    """
    folder.mkdir()
    session = json.loads((sample / "session.json").read_text(encoding="utf-8"))
    keyframes = {key["frame"]: key for key in session["bodies"][0]["keyframes"]}
    order = _order(min(keyframes), max(keyframes), frames)
    _write_film(sample / f"{sample.name}.mp4", order, size, folder / "long.mp4")
    session["bodies"][0]["keyframes"] = [
        {**keyframes[frame], "frame": n, "time_s": n / FPS}
        for n, frame in enumerate(order)
        if frame in keyframes
    ]
    _lengthen(session["views"][0], frames, size)
    (folder / "session.json").write_text(json.dumps(session), encoding="utf-8")
    return folder / "session.json"


def _order(first: int, last: int, count: int) -> list[int]:
    """So many frames of a film, forth and back."""
    there = [*range(first, last), *range(last, first, -1)]
    return [there[n % len(there)] for n in range(count)]


def _write_film(film: Path, order: list[int], size: tuple[int, int], place: Path) -> None:
    with Video.open(film) as video, av.open(str(place), "w") as file:
        pictures = {frame: video.frame(frame) for frame in sorted(set(order))}
        stream = file.add_stream("libx264", rate=FPS)
        stream.width, stream.height, stream.pix_fmt = *size, "yuv420p"
        stream.options = {"preset": "ultrafast"}
        for frame in order:
            picture = av.VideoFrame.from_ndarray(pictures[frame], "rgb24")
            file.mux(stream.encode(picture.reformat(*size)))
        file.mux(stream.encode())


def _lengthen(view: dict[str, Any], frames: int, size: tuple[int, int]) -> None:
    """Make a session's view one of that film: as long, and as much larger."""
    larger = size[0] / view["camera"]["width"]
    view["video"] = {
        "path": "long.mp4",
        "fingerprint": "",
        "frame_count": frames,
        "width": size[0],
        "height": size[1],
    }
    view["camera"] |= {
        "width": size[0],
        "height": size[1],
        **{name: view["camera"][name] * larger for name in ("fx", "fy")},
        **{name: (view["camera"][name] + 0.5) * larger - 0.5 for name in ("cx", "cy")},
    }
