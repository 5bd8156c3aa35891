#!/usr/bin/env bash
# PyAV 18.1.0: of an MP4 that was cut without being encoded anew, as phones cut films (an edit list
# hides what is before the cut) and has B-frames, a seek to the very time of a key frame lands at the
# key frame before it, and so does one to the next frame's time; the first that lands at the key
# frame is two or three frames later. In the whole file all land there. With keys every 250 frames,
# each jump decodes hundreds of frames in vain.
# Its stream also counts the packets of the whole file (`frames`), while the demuxer gives those from
# the last key before the cut on; `index_entries` has as many as it gives.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3.11 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet av==18.1.0 numpy==2.4.6
cd "$folder"
venv/bin/python - <<'PYTHON'
import av
import numpy as np

FRAMES, EVERY, CUT = 80, 20, 27
HOW = {"bf": "2", "g": str(EVERY), "sc_threshold": "0"}


def write(name):
    with av.open(name, "w") as out:
        stream = out.add_stream("libx264", rate=30, options=HOW)
        stream.width, stream.height, stream.pix_fmt = 96, 64, "yuv420p"
        for n in range(FRAMES):
            picture = np.full((64, 96, 3), 2 * n, np.uint8)
            out.mux(stream.encode(av.VideoFrame.from_ndarray(picture)))
        out.mux(stream.encode(None))


def cut(name, whole, frames):
    how = {"avoid_negative_ts": "disabled"}
    with av.open(whole) as source, av.open(name, "w", options=how) as out:
        before = source.streams.video[0]
        stream = out.add_stream_from_template(before)
        away = round(frames / before.average_rate / before.time_base)
        for packet in source.demux(before):
            if packet.dts is not None:
                packet.pts, packet.dts = packet.pts - away, packet.dts - away
                packet.stream = stream
                out.mux(packet)


def landed(name):
    """How many frames after each key a seek has to go to land there, and three counts of packets."""
    with av.open(name) as film:
        stream = film.streams.video[0]
        packets = [packet for packet in film.demux(stream) if packet.size]
        frame = round(1 / stream.average_rate / stream.time_base)
        found = []
        for key in [packet.pts for packet in packets if packet.is_keyframe and packet.pts > 0]:
            for later in range(EVERY):
                film.seek(key + later * frame, stream=stream)
                if next(film.demux(stream)).pts == key:
                    break
            found.append(later)
        return found, stream.frames, len(packets), len(stream.index_entries)


write("whole.mp4")
cut("cut.mp4", "whole.mp4", CUT)
whole, short = landed("whole.mp4"), landed("cut.mp4")
print("PyAV", av.__version__, "whole", whole, "cut", short)
assert whole == ([0, 0, 0], FRAMES, FRAMES, FRAMES), whole
assert short == ([2, 2], FRAMES, FRAMES - EVERY, FRAMES - EVERY), short
PYTHON
