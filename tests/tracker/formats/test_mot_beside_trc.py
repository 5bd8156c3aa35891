"""MOT and TRC of one motion agree: the angles put the body's joints where the markers are."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
import pytest

from keypose.tracker.body.body import Body
from keypose.tracker.body.joint_angles import R_ANATOMICAL_PART, R_PALM_FORWARD
from keypose.tracker.formats.marker_files import trc
from keypose.tracker.formats.opensim.mot import (
    ANKLE_AXIS,
    HIP_DISTANCE_M,
    HIPS_IN_PELVIS_M,
    SUBTALAR_AXIS,
    mot,
)
from keypose.tracker.formats.recording import Recording
from keypose.tracker.geometry.rotations import Array, exp_rotation
from tests.tracker.formats import recordings
from tests.tracker.formats.test_markers_out import read_trc
from tests.tracker.formats.test_opensim_out import read_mot

SIDES = {"left": "l", "right": "r"}
MIRRORED = np.diag([1.0, 1.0, -1.0])
SAMPLES = {"walk": 0.02, "person": 0.02, "balance": 0.02}
"""By sample how far off joints may be, root mean square, metres."""


def about(axis: str | tuple[float, ...], degrees: Array) -> Array:
    """(N, 3, 3) turns about x forward, y up, z right, or another axis."""
    along = np.eye(3)["xyz".index(axis)] if isinstance(axis, str) else np.array(axis)
    return exp_rotation(np.radians(degrees)[:, None] * along)


def zxy(table: pd.DataFrame, z: str, x: str, y: str) -> Array:
    flexed, aside, turned = (table[name].to_numpy() for name in (z, x, y))
    return np.asarray(about("z", flexed) @ about("x", aside) @ about("y", turned))


def limb_rotations(table: pd.DataFrame, s: str) -> dict[str, Array]:
    """(N, 3, 3) of a right limb's parts in those that carry them, as the models' joints turn."""
    at = {name: table[f"{name}_{s}"].to_numpy() for name in (
        "knee_angle", "ankle_angle", "subtalar_angle", "elbow_flex", "pro_sup",
    )}  # fmt: skip
    return {
        "thigh": zxy(table, f"hip_flexion_{s}", f"hip_adduction_{s}", f"hip_rotation_{s}"),
        "shin": about("z", -at["knee_angle"]),
        "foot": about(ANKLE_AXIS, at["ankle_angle"]) @ about(SUBTALAR_AXIS, at["subtalar_angle"]),
        "upper_arm": zxy(table, f"arm_flex_{s}", f"arm_add_{s}", f"arm_rot_{s}"),
        "forearm": about("z", at["elbow_flex"]) @ about("y", at["pro_sup"] - 90.0),
        "hand": R_PALM_FORWARD.T
        @ about("z", table[f"wrist_flex_{s}"].to_numpy())
        @ about("x", table[f"wrist_dev_{s}"].to_numpy())
        @ R_PALM_FORWARD,
    }


def rotations(table: pd.DataFrame) -> dict[str, Array]:
    """(N, 3, 3) of every part in its carrier, axes x forward, y up, z right."""
    found = {
        "waist": zxy(table, "pelvis_tilt", "pelvis_list", "pelvis_rotation"),
        "chest": zxy(table, "L5_S1_Flex_Ext", "L5_S1_Lat_Bending", "L5_S1_axial_rotation"),
    }
    for side, s in SIDES.items():
        for part, R in limb_rotations(table, s).items():
            found[f"{side}_{part}"] = R if side == "right" else MIRRORED @ R @ MIRRORED
    return found


def joints(body: Body, table: pd.DataFrame) -> dict[str, Array]:
    """(N, 3) of the body's joints in the world, metres, by forward kinematics."""
    turned = rotations(table)
    offsets = {part.name: R_ANATOMICAL_PART @ np.array(part.joint_m) for part in body.parts}
    hips = (offsets["left_thigh"] + offsets["right_thigh"]) / 2
    wide = np.linalg.norm(offsets["left_thigh"] - offsets["right_thigh"]) / HIP_DISTANCE_M
    p_pelvis = table[["pelvis_tx", "pelvis_ty", "pelvis_tz"]].to_numpy()
    Rs = {"waist": turned["waist"]}
    ps = {"waist": p_pelvis + Rs["waist"] @ (np.array(HIPS_IN_PELVIS_M) * wide - hips)}
    for part in body.parts[1:]:
        carrier = str(part.parent)
        if part.name in turned and carrier in Rs:
            ps[part.name] = ps[carrier] + Rs[carrier] @ offsets[part.name]
            Rs[part.name] = Rs[carrier] @ turned[part.name]
    return ps


def distances_m(made: Recording) -> Mapping[str, Array]:
    """(N,) between a joint of the angles and its marker."""
    markers = read_trc(trc(made))
    found = joints(made.skeleton.body, read_mot(mot(made)))
    return {
        name: np.linalg.norm(p - markers.positions[:, markers.names.index(name)] / 1000.0, axis=1)
        for name, p in found.items()
    }


@pytest.mark.parametrize("name", SAMPLES)
def test_joints_by_the_angles_are_where_the_markers_are(name: str) -> None:
    off = distances_m(recordings.recording(name))
    assert {"left_hand", "right_foot", "chest"} <= set(off)
    for joint, distances in off.items():
        assert np.sqrt(np.mean(distances**2)) < SAMPLES[name], joint
