"""The script with which Blender makes FBX of the GLB beside it: the film's frames, and its camera.

FBX is closed, and no open library writes it on every computer that this program runs on.

Blender's importer of glTF puts a second at `fps` frames, whatever `fps_base` divides it by, and
curves of KHR_animation_pointer otherwise than those of nodes; its camera fits the height of a
sensor of 3:2, where FBX fits the width. The script puts both right before it exports.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from keypose.tracker.formats.recording import Recording

_SCRIPT: Final = '''\
"""Make {stem}.fbx of the {stem}.glb beside this file, run by Blender."""

from pathlib import Path

import bpy
import numpy as np

FPS, FPS_BASE = {fps}, {base!r}  # frames a second, and what Blender divides them by
FIRST, LAST = {first}, {last}
WIDTH, HEIGHT = {width}, {height}  # of the film's pictures, pixels
ASPECT = {aspect!r}  # what the camera sees across by what it sees down
SENSOR_MM = 36.0


def curves_of(action):
    """All that an action animates; since Blender 4.4 it has layers."""
    if not hasattr(action, "layers"):
        return list(action.fcurves)
    bags = [bag for layer in action.layers for strip in layer.strips for bag in strip.channelbags]
    return [curve for bag in bags for curve in bag.fcurves]


def change(curve, longer):
    """Lay the keys on the film's frames, and make a lens longer."""
    points = curve.keyframe_points
    keys = np.empty(2 * len(points), dtype=np.float32)
    points.foreach_get("co", keys)
    keys[::2] = np.round(keys[::2] / FPS_BASE)
    if curve.data_path == "lens":
        keys[1::2] *= longer
    points.foreach_set("co", keys)
    curve.update()


folder = Path(__file__).resolve().parent
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.fps, scene.render.fps_base = FPS, 1.0
bpy.ops.import_scene.gltf(filepath=str(folder / "{stem}.glb"), disable_bone_shape=True)
(camera,) = bpy.data.cameras
longer = SENSOR_MM / ASPECT / camera.sensor_height
camera.sensor_fit = "HORIZONTAL"
camera.sensor_width, camera.sensor_height = SENSOR_MM, SENSOR_MM / ASPECT
camera.lens *= longer
for action in bpy.data.actions:
    for curve in curves_of(action):
        change(curve, longer)
scene.render.fps_base = FPS_BASE
scene.render.resolution_x, scene.render.resolution_y = WIDTH, HEIGHT
scene.frame_start, scene.frame_end = FIRST, LAST
bpy.ops.export_scene.fbx(
    filepath=str(folder / "{stem}.fbx"), add_leaf_bones=False, bake_anim_simplify_factor=0,
    bake_anim_use_all_actions=False, bake_anim_use_nla_strips=False,
)
'''


def fbx_script(recording: Recording, beside: Sequence[Recording] = ()) -> str:
    """The text of the script. FormatError without two times.

    beside: the other bodies of the scene, of the same frames.
    """
    stem = "motion" if beside else recording.body_id or "motion"
    recording = recording if beside else recording.whole("FBX")
    rate, camera = recording.frames_per_second, recording.camera
    fps = max(1, round(rate))  # of Blender a whole number
    first, last = (round(float(recording.times_s[row]) * rate) for row in (0, -1))
    return _SCRIPT.format(
        stem=stem,
        fps=fps,
        base=round(fps / rate, 9),
        first=first,
        last=last,
        width=camera.width,
        height=camera.height,
        aspect=round(camera.width * camera.fy / (camera.height * camera.fx), 9),
    )
