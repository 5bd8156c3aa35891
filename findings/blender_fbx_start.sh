#!/usr/bin/env bash
# Blender 5.0.1: an animation of frames 12 to 46 begins at 0 in the FBX that it exports by default.
# It keeps its frames only with both bake_anim_use_all_actions and bake_anim_use_nla_strips off and
# the scene's range set. Its FBX importer adds 1. Seen: 1 by default, 13 otherwise.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3.11 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet bpy==5.0.1
cd "$folder"
venv/bin/python - <<'PYTHON' | tail -n 1
import bpy


def first_frame(name, **options):
    """Where an object moved from frame 12 to 46 begins after a way through FBX."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    moved = bpy.data.objects.new("moved", None)
    scene.collection.objects.link(moved)
    for frame in (12, 46):
        moved.location.x = float(frame)
        moved.keyframe_insert("location", frame=frame)
    scene.frame_start, scene.frame_end = 12, 46
    bpy.ops.export_scene.fbx(filepath=name, **options)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.fbx(filepath=name)
    return bpy.data.actions[0].frame_range[0]


usual = first_frame("a.fbx")
kept = first_frame("b.fbx", bake_anim_use_all_actions=False, bake_anim_use_nla_strips=False)
print("Blender", bpy.app.version_string, usual, kept)
assert (usual, kept) == (1.0, 13.0), (usual, kept)
PYTHON
