#!/usr/bin/env bash
# PyAV 18.1.0: a WebM of VP9 with alpha, written by libvpx-vp9 as yuva420p, loses its alpha without a
# word when it is read: the container's decoder, FFmpeg's own vp9, gives yuv420p. Decoded by
# libvpx-vp9, asked for by name, the same packets give yuva420p. ProRes 4444, written as yuva444p10le,
# keeps its alpha but comes back as yuva444p12le.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3.11 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet av==18.1.0 numpy==2.4.6
cd "$folder"
venv/bin/python - <<'PYTHON'
import av
import numpy as np

picture = np.zeros((64, 64, 4), np.uint8)
picture[..., :3] = 90
picture[16:48, 16:48, 3] = 255


def write(name, codec, pixels):
    with av.open(name, "w") as out:
        stream = out.add_stream(codec, rate=25)
        stream.width, stream.height, stream.pix_fmt = 64, 64, pixels
        for _ in range(3):
            frame = av.VideoFrame.from_ndarray(picture, format="rgba").reformat(format=pixels)
            for packet in stream.encode(frame):
                out.mux(packet)
        for packet in stream.encode():
            out.mux(packet)


def usual(name):
    with av.open(name) as film:
        return next(film.decode(video=0)).format.name


def by_name(name, codec):
    with av.open(name) as film:
        decoder = av.CodecContext.create(codec, "r")
        for packet in film.demux(video=0):
            for frame in decoder.decode(packet):
                return frame.format.name, frame.to_ndarray(format="rgba")[32, 32, 3]


write("alpha.webm", "libvpx-vp9", "yuva420p")
write("alpha.mov", "prores_ks", "yuva444p10le")
found = usual("alpha.webm"), by_name("alpha.webm", "libvpx-vp9"), usual("alpha.mov")
print("PyAV", av.__version__, found)
assert found[0] == "yuv420p", found
assert found[1] == ("yuva420p", 255), found
assert found[2] == "yuva444p12le", found
PYTHON
