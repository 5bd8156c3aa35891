"""Express the moving body as the named bones of a skeleton that other programs know.

A rig's rest pose is the one that its users expect, T, A or the body's own; its bones have the
body's lengths. Each bone turns with one part of the body: aligned with it in the rest pose, it
stays so. Of several bones on one part, such as those of a spine on the chest, the first one turns
and the others lie still on it. `tables/` says what the bones of each rig are called, where they
begin and how their axes lie; `rig.py` makes them of a body, and a body's motion the bones'.

This module knows the names alone, for a command line to list.
"""

from __future__ import annotations

from typing import Final

OWN: Final = "keypose"
"""The rig of the body's own names and rest pose, which every body has."""

RIGS: Final[dict[str, str]] = {
    OWN: "the body's own names and rest pose",
    "mixamo": "Mixamo, T-pose",
    "ue5": "Unreal Engine 5, Manny and Quinn, A-pose",
    "metahuman": "MetaHuman, A-pose",
    "vrm": "VRM humanoid, T-pose",
    "cmu": "CMU motion capture, T-pose",
    "smpl": "SMPL, T-pose",
}
"""The rigs by name, with what they are."""
