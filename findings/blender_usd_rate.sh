#!/usr/bin/env bash
# Blender 5.0.1 takes the first and last time code of a USD stage as its scene's frames, and leaves
# the scene at 24 frames a second whatever timeCodesPerSecond says: a stage of 60 a second plays 2.5
# times too long. Seen: frames 12 to 46, rate 24.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3.11 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet bpy==5.0.1
cd "$folder"
cat > a.usda <<'USD'
#usda 1.0
(
    startTimeCode = 12
    endTimeCode = 46
    timeCodesPerSecond = 60
    metersPerUnit = 1
    upAxis = "Y"
)

def Xform "moved"
{
    double3 xformOp:translate.timeSamples = { 12: (0, 0, 0), 46: (1, 0, 0) }
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
USD
venv/bin/python - <<'PYTHON' | tail -n 1
import bpy

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath="a.usda")
scene = bpy.context.scene
found = (scene.frame_start, scene.frame_end, scene.render.fps)
print("Blender", bpy.app.version_string, found)
assert found == (12, 46, 24), found
PYTHON
