"""Make the rendered sample clips anew:  python -m keypose.sample_videos.make_samples

Each folder receives the clip, its exact motion and a session whose keyframes are taken from it.
The same sources give the same pictures; the clip's bytes depend on the encoder's version as well.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.session import Keyframe, Session, VideoReference
from keypose.tracker.storage.archive import archive_bytes
from keypose.tracker.storage.atomic import write_file
from keypose.tracker.storage.files import session_json
from keypose.tracker.video import Video
from tests.rendering.scenes import Scene, scene
from tests.rendering.settings import RenderSettings

FOLDER = Path(__file__).parent
FPS = 30


@dataclass(frozen=True, eq=False)
class Sample:
    """One clip: the scene it shows, the frames that get a keyframe, x264's quality (0 is best)."""

    name: str
    scene: Scene
    keyframes: tuple[int, ...]
    crf: int


def samples() -> tuple[Sample, ...]:
    """A box that tumbles, and a person who walks by."""
    quiet = RenderSettings(noise=0.5, background_contrast=9.0)
    box = scene("tumbling_box", quiet, size=(320, 240)).cut(0, 40)
    person = scene("stride", quiet, size=(640, 360)).cut(24, 96)
    return Sample("box", box, (0, 40), 12), Sample("person", person, (0, 24, 48, 72), 12)


def main() -> None:
    for sample in samples():
        make(sample, FOLDER / sample.name)


def make(sample: Sample, folder: Path) -> None:
    """Write clip, truth and session into a folder."""
    folder.mkdir(exist_ok=True)
    video = folder / f"{sample.name}.mp4"
    encode(sample.scene.frames(), video, sample.crf)
    truth = sample.scene.truth
    arrays = {
        "Rs_parent_part": truth.Rs_parent_part,
        "ps_camera_root": truth.ps_camera_root,
        "first_frame": np.array(truth.first_frame),
    }
    write_file(folder / "truth.npz", archive_bytes(arrays), overwrite=True)
    content = session_json(session_of(sample, video))
    write_file(folder / "session.json", content, overwrite=True)


def encode(frames: NDArray[np.uint8], path: Path, crf: int) -> None:
    """Write frames (N, H, W, 3) as H.264 in an mp4, without clock or thread in its bytes."""
    with av.open(str(path), "w", options={"fflags": "+bitexact", "movflags": "+faststart"}) as file:
        options = {"crf": str(crf), "preset": "slower", "g": "24", "x264-params": "threads=1"}
        stream = file.add_stream("libx264", rate=FPS, options=options)
        stream.height, stream.width = frames.shape[1:3]
        stream.pix_fmt = "yuv420p"
        stream.time_base = stream.codec_context.time_base = Fraction(1, FPS)
        for number, picture in enumerate(frames):
            frame = av.VideoFrame.from_ndarray(picture, format="rgb24")
            frame.pts, frame.time_base = number, Fraction(1, FPS)
            file.mux(stream.encode(frame))
        file.mux(stream.encode())


def session_of(sample: Sample, path: Path) -> Session:
    """The session of a clip, its keyframes posed as the truth is."""
    scene = sample.scene
    with Video.open(path) as video:
        info, fingerprint = video.info, video.fingerprint()
    reference = VideoReference(
        path=path.name,
        fingerprint=fingerprint,
        frame_count=info.frame_count,
        width=info.width,
        height=info.height,
    )
    keyframes = [
        Keyframe.of(scene.skeleton, scene.truth.pose(frame), frame, float(info.times_s[frame]))
        for frame in sample.keyframes
    ]
    return Session(
        video=reference,
        camera=scene.camera,
        body=scene.skeleton.body,
        keyframes=tuple(keyframes),
    )


if __name__ == "__main__":
    main()
