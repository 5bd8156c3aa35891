"""What the joints of other recordings are called, and what `tests.rendering.mocap` calls them.

A joint bears the name of the bone that ends in it, as in the recordings of walk and jump: "lfemur"
is the left knee.
"""

from __future__ import annotations

JUMPING_JACKS = {
    "Hips": "root",
    "Chest": "lowerback",
    "Chest2": "upperback",
    "Neck": "lowerneck",
    "Head": "upperneck",
    "Head_end": "head",
    **{
        f"{side}{joint}": f"{side[0].lower()}{name}"
        for side in ("Left", "Right")
        for joint, name in (
            ("Shoulder", "clavicle"),
            ("Elbow", "humerus"),
            ("Wrist", "radius"),
            ("Hip", "hipjoint"),
            ("Knee", "femur"),
            ("Ankle", "tibia"),
            ("Toe", "foot"),
        )
    },
}
PIROUETTE = {
    "hip": "root",
    "abdomen": "lowerback",
    "chest": "upperback",
    "neck": "lowerneck",
    "head": "upperneck",
    **{
        f"{s}{joint}": f"{s}{name}"
        for s in "lr"
        for joint, name in (
            ("Shldr", "clavicle"),
            ("ForeArm", "humerus"),
            ("Hand", "radius"),
            ("Thigh", "hipjoint"),
            ("Shin", "femur"),
            ("Foot", "tibia"),
            ("Foot_end", "foot"),
        )
    },
}
HEAD_M = 0.2
"""Where a head ends that was recorded without an end, along its own upward axis."""
