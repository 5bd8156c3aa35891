"""Every standard deviation that residuals are divided by, and every scale of noise, once.

What compares something with a body takes its σ from here. Lengths in pixels are those of the
pictures worked on, at the body's usual distance; shares are of the body's height in the picture.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array


@dataclass(frozen=True)
class MotionSigma:
    """Standard deviations of a motion: radians of a turn; of the root's shift pixels, or metres
    where a pixel is said to span one."""

    turn_rad: float
    shift: float

    def precision(self, skeleton: Skeleton, pixel_m: float = 1.0) -> Array:
        """(D,) 1/σ² of every degree of freedom."""
        sigma = np.where(skeleton.dof_turns == 1, self.turn_rad, self.shift * pixel_m)
        return np.asarray(sigma**-2.0)


# --- joints

LIMIT_RAD: Final = np.radians(2.0)
"""Of an angle past its limit. Tables of limits are those of most people, not of all."""

# --- keypoints of a detector

KEYPOINT_SHARE: Final = 0.007
"""Of a sure keypoint beside where the detector puts it on that body."""
SURE = 0.6
BLUR = 3.0
"""Visibility from which a keypoint is sure, and how many times wider it is at visibility 0."""
ENDS_WIDER: Final = 2.0
"""How many times wider keypoints of head and feet are: bodies differ there."""
KEYPOINT_DEPTH_M: Final = 0.08
"""Of a sure keypoint's depth beside the root's, once corrected at keyframes."""
TRUNK_DEPTH_M: Final = {"hip": 0.027, "shoulder": 0.04}
"""The same in drafts of a hip and a shoulder, whose depths say how the trunk is turned: their
distance in the picture, which a network has too small or too large, turned it by up to 60°."""
LEAST_DEPTH_M: Final = 0.015
"""Of a depth that tells its own standard deviation, at least."""
LIFTED_BEND_RAD: Final = np.radians(8.0)
"""Of how an elbow or a knee bends, by depth that was lifted."""
FOOT_DEPTH_M: Final = 0.05
"""Of heels and toes in depth beside their ankle."""
ON_PART_M = 0.02
ON_PART_BY_EYE_M = 0.012
FACE_ON_PART_M = 0.05
"""Of where on its part a detector puts a joint: shown by keyframes, by keyframes that were posed by
eye, whose own error is in it, and of a face, which the body's head does not have."""
ANIMAL_KEYPOINT_SHARE: Final = 0.012
"""Of a sure keypoint of an animal, a share of the animal's extent in the picture: animals of one
kind differ more than people, and networks see them less exactly."""
BY_HAND_SHARE: Final = 0.0025
"""Of a keypoint that a person set, as exact as a keyframe: a pixel of 400."""
LEARNED_ON_PART_M = 0.019
LEARNED_DEPTH_M = 0.136
"""Of where on its part a detector puts a joint, and of how far its depth is off, before posed
drafts show either: recorded people."""
POSED_PX = 4.5
POSED_DEPTH_M = 0.06
SHAKES_M = 0.01
"""Of how somebody poses a joint of a draft, in the picture and in depth, and of how a keypoint
shakes from frame to frame."""
TILT = 0.2
TILT_BIAS = 0.2
"""Of a bone's tilt as a detector sees it, a sine, and of what lasts of that for many frames."""
ARM_BACKWARD = 0.2
ARM_FORWARD = 0.45
"""Of how far an arm hangs behind and before the trunk, a sine: recorded walks, jumps, washing and
dancing."""


def keypoint_blur(visibility: Array) -> Array:
    """How many times wider keypoints of these visibilities are than sure ones."""
    return np.asarray(1 + (BLUR - 1) * np.clip((SURE - visibility) / SURE, 0.0, 1.0))


# --- motion from frame to frame

DOUBT_FLOOR: Final = 0.03
"""Share of the prior's variance that a step keeps where all is observable: pictures may mislead."""
BEND = MotionSigma(np.radians(3.0), 2.5)
"""Of the motion's change from frame to frame."""
STEP = MotionSigma(np.radians(2.0), 1.4)
"""Of one step about what the picture shows, where it shows nothing."""
PREDICTED = MotionSigma(np.radians(1.0), 0.7)
"""Of one step about its prediction, while the body is followed in the picture."""
BEND_IN_PICTURE = MotionSigma(np.radians(1.0), 1.1)
"""Of the motion's change where every frame is compared with both keyframes' textures."""
BEND_FROM_START = MotionSigma(np.radians(1.0), 0.7)
"""Of how the change differs from that of the start, where tracks are lifted into space."""
KNOWN_STEP = MotionSigma(np.radians(0.3), 0.3)
"""Of a step and its change about a motion of before. Three times as much makes the worst error of
rendered films by half larger, half as much leaves more of an imported motion's error."""
NEXT_POSE = MotionSigma(np.radians(12.0), 25.0)
"""Of a pose about the one before it, where keypoints alone are followed."""
TRUSTED = MotionSigma(np.radians(20.0), 30.0)
"""Of misses well below which two chains count alike: small ones hardly show which is right."""

# --- poses about where they were

POSED = MotionSigma(np.radians(3.0), 0.015)
"""Of how a person poses, the shift in metres."""
HELD = MotionSigma(np.radians(0.3), 0.3)
"""Of a draft that stays."""
DRAFTED = MotionSigma(np.radians(90.0), 2500.0)
"""Of a draft about its first pose, for what nothing else decides."""
DRAFTED_ENDS = MotionSigma(np.radians(25.0), 1.0)
"""The same of head and feet, whose root does not move."""
ANIMAL_REST_RAD = np.radians(35.0)
ANIMAL_LEAN_RAD = np.radians(12.0)
ANIMAL_HEADING_RAD = np.radians(90.0)
"""Of an animal's legs and neck about the pose at rest, of its trunk about level, and of its heading
about the one it was posed from."""
ANIMAL_SIZE_SHARE: Final = 0.2
"""Of an animal's leg, neck or head beside its trunk, a share of the size that the shelf's has."""
ANYWHERE = MotionSigma(np.radians(180.0), 30.0)
"""Of a pose fitted to joints, for what they do not decide, the shift in metres."""
LIFTED_LIMB_RAD = np.radians(14.0)
LIFTED_TRUNK_RAD = np.radians(4.0)
LIFTED_SHIFT_PX = 4.0
"""Of a limb's part, of a part that carries several limbs, and of the root, from the start."""
JOINT_M = 0.005
JOINT_PX = 2.0
"""Of a joint that a pose is fitted to, in space and in the picture."""

# --- limbs keyed alone

END_M = 1e-4
BETWEEN_M = 0.02
BETWEEN_SEEN_M = 0.005
"""Of the last joint of a limb; of those before it, in space, and where they were seen: they were
put there by eye, and their depth follows from the hand's or foot's."""
LIMB_RAD: Final = np.radians(15.0)
"""Of the turns of its parts."""

# --- tracks and textures

TRACK_PX = 0.3
SLIP_PX = 0.02
MOST_SLIP_PX = 0.7
ALONE_PX = 0.5
"""Of a followed place, with every frame farther from the keyframe and at most, and with every frame
in which nothing confirms it."""
RENEWED_PX: Final = 0.12
"""Of how a renewed patch slips in a frame."""
LEAST_TRACK_PX: Final = 0.5
"""Of a track at best, where a motion in space is fitted to it."""
PATCH_STRAY: Final = np.array([3.0, 3.0, np.radians(12.0), 0.04])
"""Of u, v, turn and log scale of a patch from where its refinement starts."""
PATCH_GREY2: Final = 60.0
"""Grey levels² that a pixel is off by, ten times: neighbouring pixels share texture and noise."""
FIRST_GREY = (6.0, 12.0, 20.0)
"""Grey levels of a texture's noise before it is known, by level of the pyramid."""
FIRST_GREY_OF_SEGMENT: Final = 12.0
"""The same where a whole segment is compared."""
SCORE_GREY2: Final = 2.0
"""Grey levels² of a score by the noise of the pictures alone."""

# --- outlines and sizes

EDGE_PX = 1.0
MOST_EDGE_PX = 4.0
"""Of an edge, at best, and at most for a body that fits: shapes are not exact."""
THICKNESS_M: Final = 0.016
"""Of how far the edges of a part lie outward together."""
CONTOUR_PX = 1.0
POSED_JOINT_PX = 3.0
"""Of a contour as seen, and of a joint as posed, where sizes are fitted."""
TURNS_RAD = tuple(np.radians([8.0, 15.0, 8.0]).tolist())
TRUNK_RAD = tuple(np.radians([3.0, 15.0, 3.0]).tolist())
STIFF_RAD = (1e-4, 1e-4, 1e-4)
POSED_SHIFT_M = 0.015
POSED_DEPTH_SHARE = 0.01
"""Of a pose as set, where sizes are fitted: turns about a limb's x, y and z, those of the trunk,
and where these are not to be changed; the root across and along the view, a share of its depth. A
limb's turns out of the picture made up for wrong lengths, so they are off by more than a person's
own error; a twist, about y, is hard to see. A trunk, neck and head that lean toward the camera
would make up for any length."""
PROPOSED_RAD = tuple(np.radians([8.0, 4.0, 8.0]).tolist())
"""Of a limb's turns that are proposed: a twist is left as it was set, mostly."""
HEIGHT_SHARE: Final = 0.02
"""Of the body's height, a share of it."""
LENGTH_SHARE = 0.06
WIDTH_SHARE = 0.15
FOCAL_SHARE = 0.2
DISTANCE_SHARE = 0.05
APART_SHARE = 0.1
TRUNK_SHARES = 0.02, 0.04
"""Of lengths, widths, the focal length, the distance, and how far other films' cameras are away,
shares of each, and of length and width of
waist, chest, neck and head, whose proportions differ least; people, and what they wear, differ more
in girth than in length."""
FEW_SHARE: Final = 0.015
"""Of a size that is right, a share of it."""

# --- space

SEEN_SHARE: Final = 0.003
"""Of where a tracked motion was seen."""
SEEN_ENDS_WIDER: Final = 8.0
"""How many times wider that is of heel and toe of a foot on the floor."""
FADE_S: Final = 0.2
"""For how long before a foot stands and afterwards this fades, seconds."""
PIN_CHANGE_M_S2: Final = 6.0
"""Of how evenly a pin's change of the motion comes and goes over that time."""
KNEE_RAD: Final = np.radians(2.0)
"""Of a knee about how it was tracked, while its foot is pinned somewhere."""
TILT_GIVES_RAD: Final = np.radians(0.15)
"""Of what is up about what it was taken for, where standing feet have their say: a floor tilts by
some degrees, but all frames have one such residual, beside thousands of others."""
PIN_M = 0.001
FLOOR_M = 0.0005
"""Of a pinned point about its place, and of that place about the floor. A floor is uneven by
some millimetres, but all frames of a place have one such residual, beside thousands of others."""
BOND_M: Final = 0.0002
"""Of a point that a bond holds about where it meets the other: both ends are solved for by
themselves, and come as near as this lets each."""
KEY_RAD = np.radians(4.0)
KEY_SEEN_SHARE = 0.003
KEY_DEPTH_SHARE = 0.05
"""Of a soft keyframe: turns, where it is seen, and its depth, a share of that."""
EXACT_SEEN_SHARE: Final = 0.001
"""Of where a keyframe is seen that is soft in depth alone."""
UNDECIDED_PER_M: Final = 0.03
"""1/σ of a place about where it began, as long as nothing else decides."""
LEVEL_M = 0.03
LEAN_RAD = np.radians(5.0)
"""Of how far a standing foot is off the common level (soles, grass, an uneven floor), and of how
far the camera leans beyond what is known of it."""
ROLL_RAD = np.radians(3.0)
TILT_RAD = np.radians(20.0)
"""Of how far a camera is held off the level, and of how far it looks down or up."""
STANCE_DEPTH: Final = 0.02
"""Of how far away a foot stands, as a share of that: keyframes are posed at such distances."""
UPRIGHT_ACROSS_RAD = np.radians(2.0)
UPRIGHT_ALONG_RAD = np.radians(4.0)
"""Of how far the mean line from the feet that stand to the centre of mass is off the vertical,
across the view and along it: seven films of four calibrated cameras, of a man on a beam and of a
man who walks and squats."""
USUAL_FORWARD_RAD = np.radians(3.0)
FORWARD_LEAN_RAD = np.radians(4.0)
"""How far that leans forward of the ankles, and the standard deviation of that."""
JERK_M_S3: Final = {
    "waist": 225.0,
    "chest": 350.0,
    "neck": 350.0,
    "head": 350.0,
    "upper_arm": 250.0,
    "forearm": 500.0,
    "hand": 750.0,
    "thigh": 400.0,
    "shin": 800.0,
    "foot": 1200.0,
}
"""Of the jerk of a part's joint, by its name without its side; wide enough for throws, kicks and
jumps."""
OTHER_JERK_M_S3: Final = 750.0
"""Of all other parts: of things that a hand moves."""
