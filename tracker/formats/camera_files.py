"""The film's camera for rotomation: as JSON with all that is known of it, and as Nuke's .chan.

Both give where it stands in the world of all files (`keypose.tracker.body.ground`): metres, y up,
the floor at zero.

JSON:

    format, version         "keypose camera", 1
    width, height           of the picture, pixels
    projection              perspective or telephoto
    fx, fy, cx, cy          pixels; pixel centres are at integers, the upper left one is (0, 0)
    distortion_k1_k2_p1_p2_k3   as OpenCV has it
    telephoto_distance_m    of a telephoto lens: the distance at which its scale holds
    horizontal_fov_deg, vertical_fov_deg    of the whole picture, without distortion
    focal_35mm              of the lens that shows as much on 35 mm film, millimetres
    T_world_camera          4×4, rows; its camera looks along +z, x right, y down
    floor_m                 height of the floor in that world: 0
    first_frame, last_frame of the motion that was exported with it, by frames_per_second, from
                            the film's first frame, which is 0
    film_frames             the same as frames of the film: others where the motion was given a rate
                            of its own
    timecode_of_frame_0     where the film has it
    file_number_of_frame_0  where the film is image files that are numbered consecutively
    without_scale           first and last frames of the film over which nothing tells how far the
                            camera went: there it is taken to turn alone; left out without any

Of a camera that moves, version 2: `T_world_camera` is that of the film's first frame, and

    frames                  of every frame of the motion: `frame`, `T_world_camera`, `fx` and `fy`

.chan: a line for every frame, with numbers between tabs: the frame's number in the film, from 0,
or that of its image file; position x, y, z; rotation about x, y, z, degrees, in the order ZXY,
which is Nuke's own; the vertical field of view, degrees. The camera looks along −z with y up; of
one that stands still all lines are alike. A telephoto lens has no field of view, and a .chan file
knows neither distortion nor a principal point beside the middle.
"""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np

from keypose.tracker.errors import FormatError
from keypose.tracker.formats.conventions import FLIP, fixed_decimals
from keypose.tracker.formats.recording import Recording
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array

FORMAT = "keypose camera"
VERSION = 1
VERSION_OF_MOVING = 2
DECIMALS = 9
"""Of places, rotations and angles in the files."""
DEGENERATE = 1e-9
"""The level share of where the camera looks, below which it looks straight down or up."""


def camera_json(recording: Recording) -> str:
    """The text of the JSON file. FormatError where neither floor nor motion is known."""
    camera = recording.camera
    fields: dict[str, Any] = {
        "format": FORMAT,
        "version": VERSION,
        **camera.model_dump(include={"width", "height", "projection", "fx", "fy", "cx", "cy"}),
        "distortion_k1_k2_p1_p2_k3": list(camera.distortion),
        "focal_35mm": round(camera.focal_mm, 4),
        "T_world_camera": (recording.T_world_camera.round(DECIMALS) + 0.0).tolist(),
        "floor_m": 0.0,
        "first_frame": recording.frames[0],
        "last_frame": recording.frames[-1],
        "film_frames": recording.film_frames[[0, -1]].round(4).tolist(),
    }
    if camera.telephoto_distance_m is not None:
        fields["telephoto_distance_m"] = camera.telephoto_distance_m
    else:
        across, down = fields_of_view_deg(camera)
        fields |= {"horizontal_fov_deg": round(across, 6), "vertical_fov_deg": round(down, 6)}
    if recording.rate is not None:
        fields["frames_per_second"] = round(recording.rate, 9)
    if recording.timecode is not None:
        fields["timecode_of_frame_0"] = str(recording.timecode)
    if recording.first_file_number is not None:
        fields["file_number_of_frame_0"] = recording.first_file_number
    if recording.unscaled:
        fields["without_scale"] = [list(span) for span in recording.unscaled]
    if recording.seen_from is not None:
        fields |= {"version": VERSION_OF_MOVING, "frames": _frames(recording)}
    return json.dumps(fields, indent=1) + "\n"


def _frames(recording: Recording) -> list[dict[str, Any]]:
    """Where the camera was at every frame, and its focal length there."""
    frames = []
    for row, T in enumerate(recording.Ts_world_camera):
        camera = recording.camera_at(row)
        place = (T.round(DECIMALS) + 0.0).tolist()
        focal = {"fx": round(camera.fx, DECIMALS), "fy": round(camera.fy, DECIMALS)}
        frames.append({"frame": recording.frames[row], "T_world_camera": place, **focal})
    return frames


def chan(recording: Recording) -> str:
    """The text of the .chan file. FormatError for a telephoto lens, which it cannot describe."""
    if recording.camera.telephoto_distance_m is not None:
        raise FormatError("A .chan file needs a field of view, and a telephoto lens has none.")
    if recording.seen_from is None:
        numbers = _line(recording.T_world_camera, recording.camera)
        return "".join(f"{frame}\t{numbers}\n" for frame in recording.numbers)
    Ts = recording.Ts_world_camera
    lines = (_line(T, recording.camera_at(row)) for row, T in enumerate(Ts))
    both = zip(recording.numbers, lines, strict=True)
    return "".join(f"{frame}\t{line}\n" for frame, line in both)


def _line(T: Array, camera: Camera) -> str:
    """The numbers of a line of .chan behind the frame's: place, rotation and field of view."""
    angles_deg = np.degrees(_zxy(T[:3, :3] * FLIP))
    seen_deg = fields_of_view_deg(camera)[1]
    return "\t".join(fixed_decimals([*T[:3, 3], *angles_deg, seen_deg], DECIMALS))


def fields_of_view_deg(camera: Camera) -> tuple[float, float]:
    """What the picture spans across and down, as if the principal point were its middle."""
    across, down = camera.width / 2 / camera.fx, camera.height / 2 / camera.fy
    return 2 * math.degrees(math.atan(across)), 2 * math.degrees(math.atan(down))


def _zxy(R: Array) -> tuple[float, float, float]:
    """[x, y, z] radians with R = Qy·Qx·Qz; straight down or up, z is 0."""
    x = math.atan2(-R[1, 2], math.hypot(R[0, 2], R[2, 2]))
    if math.hypot(R[0, 2], R[2, 2]) < DEGENERATE:
        return x, math.atan2(-R[2, 0], R[0, 0]), 0.0
    return x, math.atan2(R[0, 2], R[2, 2]), math.atan2(R[1, 0], R[1, 1])
