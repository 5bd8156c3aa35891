"""Write a person's motion in the coordinates of OpenSim's full-body models, as .mot.

Names and signs are those of Model_Pose2Sim (Pagnon et al. 2021), which is Rajagopal's model (2016)
with a neck; of the lumbar joint a model's own names are taken where it has others. All rotations
but those of ankle and foot are `keypose.tracker.body.joint_angles`, whose order is the models'.
Where they differ:

    pelvis_tilt, pelvis_list    backward and to the right, the reverse of tilt and obliquity
    L5_S1_Flex_Ext, neck_flexion  backward, the reverse of flexion
    pro_sup                     0 with the palm forward, 90 with the thumb forward, as at rest
    ankle_angle, subtalar_angle about the model's two oblique axes, as near as they come
    pelvis_tx, _ty, _tz         of the pelvis' origin between the spines of the hip bones, which
                                the models have before and above the hips

The ground is the world of all files (`keypose.tracker.body.ground`). Toes stay straight. The axes
of elbow and knee, oblique and gliding in the models, are taken for straight ones; hips, shoulders,
ankles and wrists do what these hinges cannot (`keypose.tracker.formats.opensim.hinges`).

What the columns mean is in `keypose.tracker.formats.opensim.mot`. Frames must be tracked
from the first to the last, for OpenSim reads no gaps.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from typing import Final

import numpy as np

from keypose.tracker.body.joint_angles import (
    JOINTS,
    R_ANATOMICAL_PART,
    JointAngles,
    joint_rotations,
    joints_of,
)
from keypose.tracker.errors import FormatError
from keypose.tracker.formats.conventions import fixed_decimals
from keypose.tracker.formats.opensim.hinges import with_hinges
from keypose.tracker.formats.opensim.model import OpenSimModel, mid_hips, scaled
from keypose.tracker.formats.recording import Recording
from keypose.tracker.geometry.rotations import Array, exp_rotation, log_rotation, transpose

HIPS_IN_PELVIS_M: Final = (-0.0707, -0.0661, 0.0)
HIP_DISTANCE_M: Final = 0.167
"""The middle of the hips and their distance in Model_Pose2Sim's pelvis, where no model is given."""

ANKLE_AXIS: Final = (-0.10501355, -0.17402245, 0.97912632)
SUBTALAR_AXIS: Final = (0.78717961, 0.60474746, -0.12094949)
"""Of the right foot: about which the models turn it up, and inward."""

_OF_JOINTS: Final[Mapping[str, tuple[str, str, float, float]]] = {
    "pelvis_tilt": ("pelvis", "anterior_tilt", -1, 0),
    "pelvis_list": ("pelvis", "obliquity", -1, 0),
    "pelvis_rotation": ("pelvis", "rotation", 1, 0),
    "L5_S1_Flex_Ext": ("trunk", "flexion", -1, 0),
    "L5_S1_Lat_Bending": ("trunk", "bending", 1, 0),
    "L5_S1_axial_rotation": ("trunk", "rotation", 1, 0),
    "neck_flexion": ("neck", "flexion", -1, 0),
    "neck_bending": ("neck", "bending", 1, 0),
    "neck_rotation": ("neck", "rotation", 1, 0),
    "hip_flexion": ("hip", "flexion", 1, 0),
    "hip_adduction": ("hip", "adduction", 1, 0),
    "hip_rotation": ("hip", "internal_rotation", 1, 0),
    "knee_angle": ("knee", "flexion", 1, 0),
    "arm_flex": ("shoulder", "flexion", 1, 0),
    "arm_add": ("shoulder", "adduction", 1, 0),
    "arm_rot": ("shoulder", "internal_rotation", 1, 0),
    "elbow_flex": ("elbow", "flexion", 1, 0),
    "pro_sup": ("elbow", "pronation", 1, 90),
    "wrist_flex": ("wrist", "flexion", 1, 0),
    "wrist_dev": ("wrist", "ulnar_deviation", 1, 0),
}
"""By coordinate, without its side: joint, angle, sign, and what it is at rest, degrees."""

_ALSO_CALLED: Final[Mapping[str, str]] = {
    "L5_S1_Flex_Ext": "lumbar_extension",
    "L5_S1_Lat_Bending": "lumbar_bending",
    "L5_S1_axial_rotation": "lumbar_rotation",
}
_PLACES: Final = ("pelvis_tx", "pelvis_ty", "pelvis_tz")
_SIDES: Final = {"r": "right", "l": "left"}


def coordinates(recording: Recording, model: OpenSimModel | None = None) -> dict[str, Array]:
    """Every coordinate (N,) by its name, degrees and metres, NaN where not tracked.

    model: only the coordinates that it has, and its pelvis. FormatError where the body is no
    person's, or nothing is tracked.
    """
    recording = _with_hinges(recording)
    angles = {
        joint_angles.joint.name: joint_angles
        for joint_angles in recording.joint_angles_in(recording.world)
    }
    if len(angles) < len(JOINTS):
        raise FormatError(
            "OpenSim's joint angles are those of a whole person, and this body is no person's."
        )
    values_of: dict[str, Array] = dict(zip(_PLACES, _pelvis_m(recording, model).T, strict=True))
    for name, sign, at_rest, each, angle in _columns(angles):
        values_of[name] = sign * each[angle] + at_rest
    for s, side in _SIDES.items():
        ankle, subtalar = _ankle(recording, side)
        values_of |= {f"ankle_angle_{s}": ankle, f"subtalar_angle_{s}": subtalar}
        values_of[f"mtp_angle_{s}"] = 0.0 * ankle
    return values_of if model is None else _of_model(values_of, model.coordinates)


def expected_errors(recording: Recording) -> dict[str, Array] | None:
    """By which coordinates (N,) are expected to be off, degrees, by their names; None where that is
    not known of every frame, since OpenSim reads no gaps. Nothing is of places, ankles and toes."""
    recording = _with_hinges(recording)
    angles = {
        joint_angles.joint.name: joint_angles
        for joint_angles in recording.joint_angles_in(recording.world)
    }
    if len(angles) < len(JOINTS):
        return None
    errors = {name: each.error_deg(angle) for name, _, _, each, angle in _columns(angles)}
    known_errors = {name: error for name, error in errors.items() if error is not None}
    is_whole = all(np.isfinite(error).all() for error in known_errors.values())
    return known_errors if known_errors and is_whole else None


def _columns(
    angles: Mapping[str, JointAngles],
) -> Iterator[tuple[str, float, float, JointAngles, str]]:
    """Every coordinate that is a clinical angle: its name, sign, value at rest, and that angle."""
    for name, (joint, angle, sign, at_rest) in _OF_JOINTS.items():
        if joint in angles:
            yield name, sign, at_rest, angles[joint], angle
            continue
        for s, side in _SIDES.items():
            yield f"{name}_{s}", sign, at_rest, angles[f"{side}_{joint}"], angle


def _with_hinges(recording: Recording) -> Recording:
    """The motion by the joints that the models have; itself where the body is no person's."""
    tracks = recording.tracks
    if not joints_of(recording.skeleton.body):
        return recording
    Rs, is_tracked = tracks.Rs_parent_part.copy(), tracks.tracked
    Rs[is_tracked] = with_hinges(recording.skeleton.body, Rs[is_tracked])
    return replace(recording.with_ground(), tracks=replace(tracks, Rs_parent_part=Rs))


def trunk_flexion(model: OpenSimModel) -> str | None:
    """The model's own name of how far the trunk is bent against the pelvis; None if it is rigid."""
    name = "L5_S1_Flex_Ext"
    names = (name, _ALSO_CALLED[name])
    return next((each for each in names if each in model.coordinates), None)


def _of_model(values_of: Mapping[str, Array], names: Collection[str]) -> dict[str, Array]:
    """Keep those that a model has, under its names."""
    called = {name: name if name in names else _ALSO_CALLED.get(name, name) for name in values_of}
    return {called[name]: values for name, values in values_of.items() if called[name] in names}


def _pelvis_m(recording: Recording, model: OpenSimModel | None) -> Array:
    """(N, 3) The origin of the model's pelvis in the world; its hips are where ours are."""
    body = recording.skeleton.body
    hips = np.array([body.parts[body.index(f"{side}_thigh")].joint_m for side in _SIDES.values()])
    if model is None:
        wide = float(np.linalg.norm(hips[0] - hips[1])) / HIP_DISTANCE_M
        theirs = np.array(HIPS_IN_PELVIS_M) * wide
    else:
        theirs = mid_hips(model, scaled(model, body, ()).factors)
    p_root = hips.mean(axis=0) - R_ANATOMICAL_PART.T @ theirs
    T = recording.trajectory.transforms(recording.skeleton)[:, 0]
    return recording.world.points(T[:, :3, :3] @ p_root + T[:, :3, 3])


def _ankle(recording: Recording, side: str) -> tuple[Array, Array]:
    """(N,) twice: turns about the models' ankle and subtalar axes, degrees.

    The ankle brings the subtalar axis to where the foot has it, as seen along its own axis; what
    then is left of the foot's turn about the subtalar axis is the other.
    """
    joint = next(joint for joint in JOINTS if joint.name == f"{side}_ankle")
    unknown = np.eye(3)  # the shin carries it, so the ground does not matter
    R = joint_rotations(recording.skeleton.body, joint, recording.tracks.Rs_parent_part, unknown)
    is_finite = np.isfinite(R).all(axis=(1, 2))
    ankle, subtalar = np.full(len(R), np.nan), np.full(len(R), np.nan)
    up, inward = np.array(ANKLE_AXIS), np.array(SUBTALAR_AXIS)
    turned = R[is_finite] @ inward
    across = np.cross(up, inward)
    flat = inward - (inward @ up) * up
    ankle[is_finite] = np.arctan2(turned @ across, turned @ flat)
    left = transpose(exp_rotation(ankle[is_finite, None] * up)) @ R[is_finite]
    subtalar[is_finite] = log_rotation(left) @ inward
    return np.degrees(ankle), np.degrees(subtalar)


DECIMALS = 6
"""A microdegree, a micrometre, a microsecond."""


def mot(recording: Recording, model: OpenSimModel | None = None) -> str:
    """The text of the file. FormatError where frames between are not tracked, or no person is."""
    whole = recording.whole("MOT")
    return _table("Coordinates", whole.times_s, coordinates(whole, model))


def mot_files(recording: Recording, model: OpenSimModel | None = None) -> tuple[str, ...]:
    """The texts of the file, and of one with the degrees by which angles are expected to be off
    where that is known. FormatError as of `mot`."""
    whole = recording.whole("MOT")
    errors = expected_errors(whole)
    if errors is None:
        return (mot(whole, model),)
    errors = errors if model is None else _of_model(errors, model.coordinates)
    words = "Degrees by which an angle is expected to be off: half of all are off by less."
    return mot(whole, model), _table("Expected errors", whole.times_s, errors, words)


def _table(
    name: str,
    times_s: Array,
    columns: Mapping[str, Array],
    words: str = "Angles are degrees, lengths metres, times seconds; y is up, the floor at zero.",
) -> str:
    head = [
        name,
        "version=1",
        f"nRows={len(times_s)}",
        f"nColumns={len(columns) + 1}",
        "inDegrees=yes",
        "",
        words,
        "endheader",
        "\t".join(("time", *columns)),
    ]
    rows = np.column_stack([times_s, *columns.values()])
    return "\n".join([*head, *("\t".join(fixed_decimals(row, DECIMALS)) for row in rows)]) + "\n"
