"""Run by an interpreter that has bpy: FILE FRAME …; prints RESULT and JSON.

It opens a BVH, USD or FBX file as a person does who changes nothing in the dialog, and says where
bones begin, in Blender's world, z up, metres. A script beside the file is run first: it makes FBX.
It imports nothing of this project.
"""

from __future__ import annotations

import json
import runpy
import sys
from pathlib import Path
from typing import Any

import bpy  # type: ignore[import-not-found]


def main() -> None:
    file, *frames = sys.argv[1:]
    for script in Path(file).parent.glob("*.py"):
        runpy.run_path(str(script))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    opened = {
        ".bvh": bpy.ops.import_anim.bvh,
        ".usd": bpy.ops.wm.usd_import,
        ".fbx": bpy.ops.import_scene.fbx,
    }
    opened[Path(file).suffix](filepath=file)
    (armature,) = [thing for thing in bpy.data.objects if thing.type == "ARMATURE"]
    action = armature.animation_data.action
    said = {
        "version": bpy.app.version_string,
        "range": list(action.frame_range),
        "kinds": sorted(thing.type for thing in bpy.data.objects),
        "frames": [heads(armature, int(frame)) for frame in frames],
    }
    print("RESULT", json.dumps(said))


def heads(armature: Any, frame: int) -> dict[str, list[float]]:
    bpy.context.scene.frame_set(frame)
    return {bone.name: list(armature.matrix_world @ bone.head) for bone in armature.pose.bones}


main()
