"""Run by an interpreter that has bpy: FILE FPS WIDTH HEIGHT FRAME …; prints RESULT and JSON.

It opens a GLB or FBX file, and says where its camera sees the bones begin, in shares of the
picture. A script beside the file is run first: it makes FBX. It imports nothing of this project.
"""

from __future__ import annotations

import json
import runpy
import sys
from pathlib import Path
from typing import Any

import bpy  # type: ignore[import-not-found]
from bpy_extras.object_utils import world_to_camera_view  # type: ignore[import-not-found]


def main() -> None:
    file, fps, width, height, *frames = sys.argv[1:]
    for script in Path(file).parent.glob("*.py"):
        runpy.run_path(str(script))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps = int(fps)
    opened = {".glb": bpy.ops.import_scene.gltf, ".fbx": bpy.ops.import_scene.fbx}
    opened[Path(file).suffix](filepath=file)
    scene.render.resolution_x, scene.render.resolution_y = int(width), int(height)
    (armature,) = [thing for thing in bpy.data.objects if thing.type == "ARMATURE"]
    (camera,) = [thing for thing in bpy.data.objects if thing.type == "CAMERA"]
    if file.endswith(".fbx"):
        camera.data.sensor_fit = "HORIZONTAL"  # as FBX says, and the importer does not
    said = {
        "version": bpy.app.version_string,
        "rate": scene.render.fps / scene.render.fps_base,
        "range": list(armature.animation_data.action.frame_range),
        "frames": [seen(scene, armature, camera, float(frame)) for frame in frames],
    }
    print("RESULT", json.dumps(said))


def seen(scene: Any, armature: Any, camera: Any, frame: float) -> dict[str, list[float]]:
    scene.frame_set(int(frame), subframe=frame % 1)
    return {
        bone.name: list(world_to_camera_view(scene, camera, armature.matrix_world @ bone.head))[:2]
        for bone in armature.pose.bones
    }


main()
