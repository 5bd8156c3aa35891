"""The script with which Blender makes FBX of the GLB beside it, keeping the film's frames.

FBX is closed, and no open library writes it on every computer that this program runs on.
"""

from __future__ import annotations

from typing import Final

from keypose.tracker.formats.recording import Recording

_SCRIPT: Final = '''\
"""Make motion.fbx of the motion.glb beside this file, run by Blender."""

from pathlib import Path

import bpy

folder = Path(__file__).resolve().parent
bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.fps, scene.render.fps_base = {fps}, {base!r}
bpy.ops.import_scene.gltf(filepath=str(folder / "motion.glb"), disable_bone_shape=True)
scene.frame_start, scene.frame_end = map(int, bpy.data.actions[0].frame_range)
bpy.ops.export_scene.fbx(
    filepath=str(folder / "motion.fbx"), add_leaf_bones=False, bake_anim_simplify_factor=0,
    bake_anim_use_all_actions=False, bake_anim_use_nla_strips=False,
)
'''


def fbx_script(recording: Recording) -> str:
    """The text of the script. FormatError without two times."""
    rate = recording.frames_per_second
    fps = max(1, round(rate))  # of Blender a whole number, and what it is divided by
    return _SCRIPT.format(fps=fps, base=round(fps / rate, 9))
