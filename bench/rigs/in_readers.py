"""Open an exported file in a library, in an environment of its own; print frames and first second.

python in_readers.py READER FILE
"""

from __future__ import annotations

import json
import sys
import warnings
from typing import Any

warnings.simplefilter("ignore")


def bvh(path: str) -> tuple[int, float]:
    from bvh import Bvh

    with open(path) as file:  # noqa: PTH123 — a script of its own
        return int(Bvh(file.read()).nframes), 0.0


def bvhio(path: str) -> tuple[int, float]:
    import bvhio

    return int(bvhio.readAsBvh(path).FrameCount), 0.0


def c3d(path: str) -> tuple[int, float]:
    import c3d

    with open(path, "rb") as file:  # noqa: PTH123
        reader = c3d.Reader(file)
        frames = sum(1 for _ in reader.read_frames())
        return frames, float((reader.first_frame - 1) / reader.point_rate)


def ezc3d(path: str) -> tuple[int, float]:
    import ezc3d

    file = ezc3d.c3d(path)
    rate = float(file["parameters"]["POINT"]["RATE"]["value"][0])
    return file["data"]["points"].shape[2], file["header"]["points"]["first_frame"] / rate


def kineticstoolkit(path: str) -> tuple[int, float]:
    import kineticstoolkit

    points = kineticstoolkit.read_c3d(path)["Points"]
    return len(points.time), float(points.time[0])


def opensim(path: str) -> tuple[int, float]:
    import opensim

    opensim.Logger.setLevelString("Off")
    kind = opensim.TimeSeriesTableVec3 if path.endswith(".trc") else opensim.TimeSeriesTable
    table = kind(path)
    return table.getNumRows(), float(table.getIndependentColumn()[0])


def pandas(path: str) -> tuple[int, float]:
    import pandas

    rows = pandas.read_csv(path, sep="\t", skiprows=4)
    return len(rows), float(rows.iloc[0, 1])


def pygltflib(path: str) -> tuple[int, float]:
    import pygltflib

    file = pygltflib.GLTF2().load(path)
    clock = file.accessors[file.animations[0].samplers[0].input]
    return clock.count, float(clock.min[0])


def pxr(path: str) -> tuple[int, float]:
    from pxr import Usd

    stage = Usd.Stage.Open(path)
    first, last = stage.GetStartTimeCode(), stage.GetEndTimeCode()
    return int(last - first) + 1, first / stage.GetTimeCodesPerSecond()


def numpy(path: str) -> tuple[int, float]:
    import numpy

    with numpy.load(path, allow_pickle=False) as arrays:
        times_s: Any = arrays["time_s"] if "time_s" in arrays else [0.0] * len(arrays["poses"])
        return len(times_s), float(times_s[0])


if __name__ == "__main__":
    print(json.dumps(globals()[sys.argv[1]](sys.argv[2])))
