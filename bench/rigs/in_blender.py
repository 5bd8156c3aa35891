"""Run by an interpreter that has bpy: FILE FPS PICTURE FRAME …; prints RESULT and JSON.

It imports nothing of this project. Everything it says is in Blender's world, z up, metres.
"""

from __future__ import annotations

import json
import sys
from typing import Any

import bpy  # type: ignore[import-not-found]
from bpy_extras.object_utils import world_to_camera_view  # type: ignore[import-not-found]


def main() -> None:
    file, fps, picture, *frames = sys.argv[1:]
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.fps = int(fps)
    bpy.ops.import_scene.gltf(filepath=file)
    (armature,) = kinds("ARMATURE")
    (camera,) = kinds("CAMERA")
    (body,) = [mesh for mesh in kinds("MESH") if mesh.parent is armature]
    scene.camera = camera
    width, height = (int(camera.data[side]) for side in ("width", "height"))
    scene.render.resolution_x, scene.render.resolution_y = width, height
    at = [posed(scene, armature, body, camera, int(frame)) for frame in frames]
    armature.data.pose_position = "REST"
    rest = vertices(body)
    armature.data.pose_position = "POSE"
    if picture:
        render(scene, picture, int(frames[-2]))
    said = {
        "version": bpy.app.version_string,
        "actions": len(bpy.data.actions),
        "keys": keys(bpy.data.actions[0]),
        "height_m": max(z for _, _, z in rest),
        "lowest_at_rest_m": min(z for _, _, z in rest),
        "frames": at,
    }
    print("RESULT", json.dumps(said))


def kinds(kind: str) -> list[Any]:
    return [thing for thing in bpy.data.objects if thing.type == kind]


def posed(scene: Any, armature: Any, body: Any, camera: Any, frame: int) -> dict[str, Any]:
    """Where bones begin, where the camera sees that, and the lowest point of the skin."""
    scene.frame_set(frame)
    heads = {bone.name: armature.matrix_world @ bone.head for bone in armature.pose.bones}
    seen = {name: world_to_camera_view(scene, camera, head) for name, head in heads.items()}
    return {
        "frame": frame,
        "heads": {name: list(head) for name, head in heads.items()},
        "seen": {name: list(at)[:2] for name, at in seen.items()},
        "lowest_m": min(z for _, _, z in vertices(body)),
    }


def vertices(body: Any) -> list[Any]:
    """Of the skin as the armature bends it now."""
    bent = body.evaluated_get(bpy.context.evaluated_depsgraph_get())
    return [body.matrix_world @ vertex.co for vertex in bent.to_mesh().vertices]


def keys(action: Any) -> list[float]:
    """The frames at which an action has keys, all of its curves together."""
    curves = [
        curve
        for layer in action.layers
        for strip in layer.strips
        for bag in strip.channelbags
        for curve in bag.fcurves
    ]
    return sorted({round(point.co.x, 3) for curve in curves for point in curve.keyframe_points})


def render(scene: Any, picture: str, frame: int) -> None:
    """The frame as the camera sees it, on a floor at zero, under a sun."""
    scene.render.engine, scene.cycles.samples = "CYCLES", 8
    world = bpy.data.worlds.new("sky")
    scene.world = world
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs[0].default_value = (0.6, 0.65, 0.7, 1.0)
    sun = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 3.0, (0.5, 0.3, 0.0)
    scene.collection.objects.link(sun)
    bpy.ops.mesh.primitive_plane_add(size=20)
    scene.frame_set(frame)
    scene.render.filepath = picture
    bpy.ops.render.render(write_still=True)


main()
