#!/usr/bin/env bash
# Blender 5.0.1: its importer of glTF multiplies by fps_base where the scene divides by it, so that a
# second of 30000/1001 frames a second has 30.03 frames; curves of KHR_animation_pointer leave it out
# and have 30. Its importer of FBX leaves it out, too. Seen: a key at 10 s at frame 300.3 of a node
# and at 300.0 of a lens, for 299.7; and one that was exported as FBX at frame 300 comes back at 300.3.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3.11 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet bpy==5.0.1
cd "$folder"
venv/bin/python - <<'PYTHON' | tail -n 1
import base64
import json
import struct

import bpy

numbers = struct.pack("<10f", 0, 10, 0, 0, 0, 1, 0, 0, 0.5, 0.7)  # times, places, angles
views = [(0, 8, 2, "SCALAR"), (8, 24, 2, "VEC3"), (32, 8, 2, "SCALAR")]
pointer = {"pointer": "/cameras/0/perspective/yfov"}
targets = [
    {"node": 0, "path": "translation"},
    {"path": "pointer", "extensions": {"KHR_animation_pointer": pointer}},
]
document = {
    "asset": {"version": "2.0"}, "extensionsUsed": ["KHR_animation_pointer"], "scene": 0,
    "scenes": [{"nodes": [0]}], "nodes": [{"camera": 0}],
    "cameras": [{"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.1}}],
    "buffers": [{
        "byteLength": len(numbers),
        "uri": "data:application/octet-stream;base64," + base64.b64encode(numbers).decode(),
    }],
    "bufferViews": [{"buffer": 0, "byteOffset": a, "byteLength": n} for a, n, _, _ in views],
    "accessors": [
        {"bufferView": k, "componentType": 5126, "count": count, "type": kind,
         "min": [0] * (3 if kind == "VEC3" else 1), "max": [10] * (3 if kind == "VEC3" else 1)}
        for k, (_, _, count, kind) in enumerate(views)
    ],
    "animations": [{
        "channels": [{"sampler": k, "target": target} for k, target in enumerate(targets)],
        "samplers": [{"input": 0, "output": k + 1} for k in range(2)],
    }],
}
with open("a.gltf", "w") as file:
    json.dump(document, file)


def scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps, bpy.context.scene.render.fps_base = 30, 1.001
    return bpy.context.scene


def last_keys():
    """By what is animated, the frame of the last key."""
    return {
        curve.data_path: round(curve.keyframe_points[-1].co.x, 2)
        for action in bpy.data.actions
        for layer in action.layers for strip in layer.strips for bag in strip.channelbags
        for curve in bag.fcurves
    }


scene()
bpy.ops.import_scene.gltf(filepath="a.gltf")
gltf = last_keys()
made = scene()
moved = bpy.data.objects.new("moved", None)
made.collection.objects.link(moved)
made.frame_start, made.frame_end = 0, 300
for frame in (0, 300):
    moved.location.x = float(frame)
    moved.keyframe_insert("location", frame=frame)
bpy.ops.export_scene.fbx(
    filepath="a.fbx", bake_anim_use_all_actions=False, bake_anim_use_nla_strips=False
)
scene()
bpy.ops.import_scene.fbx(filepath="a.fbx", anim_offset=0)
rate = bpy.context.scene.render.fps / bpy.context.scene.render.fps_base
fbx = last_keys()["location"]
print("Blender", bpy.app.version_string, gltf, fbx, round(rate, 2))
assert gltf == {"location": 300.3, "lens": 300.0}, gltf
assert (fbx, round(rate, 2)) == (300.3, 29.97), (fbx, rate)
PYTHON
