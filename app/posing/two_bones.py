"""Two bones and a hinge: shoulder, elbow and hand, or hip, knee and foot, in closed form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from keypose.app.posing.gesture_context import GestureContext
from keypose.app.posing.hinge import Hinge
from keypose.app.posing.moving import Aim
from keypose.app.posing.pointer_view import PointerView
from keypose.app.posing.reach_limit import within_reach
from keypose.app.posing.swinging import Swing
from keypose.app.posing.untwisting import EASED_M, untwisted
from keypose.app.posing.vectors import across, cross, length, signed_angle, smooth_step, turn, unit
from keypose.tracker.geometry.rotations import Array


@dataclass(frozen=True, eq=False)
class Reached:
    """What a limb's solution is.

    rotations: (3, 3) of the parts that turn, in their parents' frames, by part.
    centre, radius_m: the sphere that the end cannot leave.
    """

    rotations: dict[int, Array]
    centre: Array
    radius_m: float


@dataclass(frozen=True, eq=False)
class TwoBones:
    """A limb of an upper and a lower part; tip (3,) is its end in the lower part's frame."""

    context: GestureContext
    upper: int
    lower: int
    tip: Array
    hinge: Hinge

    @classmethod
    def of(cls, context: GestureContext, upper: int, lower: int, tip: Array) -> TwoBones:
        return cls(context, upper, lower, tip, Hinge.of(context, lower, tip))

    @property
    def centre(self) -> Array:
        """(3,) shoulder or hip, in the camera frame."""
        return self.context.joint(self.upper)

    @property
    def end(self) -> Array:
        """(3,) hand or foot before the drag, in the camera frame."""
        return self.context.placed(self.lower, self.tip)

    def reach(self, view: PointerView, goal: Aim) -> Reached:
        """The limb with its end at the goal, or as near as it can come.

        The hinge alone sets the distance; then the whole limb is swung there, and the plane in
        which it is bent goes along without turning about the limb. The hinge keeps its limits; the
        upper joint is led by the middle of its range but not held, or the end could not follow;
        where its part would be twisted too far, the whole limb turns about the line to its end.
        """
        hinge = self.hinge
        place = within_reach(view, goal, self.centre, hinge.nearest_m, hinge.farthest_m, self.end)
        return self._at(place, length(goal.p_camera - self.end))

    def toward(self, place: Array) -> Reached:
        """The limb with its end at a place (3,) in the camera frame, or straight toward it."""
        hinge, way = self.hinge, place - self.centre
        away = min(max(length(way), hinge.nearest_m), hinge.farthest_m)
        return self._at(self.centre + away * unit(way), length(place - self.end))

    def _at(self, place: Array, drawn_m: float) -> Reached:
        """The limb with its end at a place within reach. drawn_m: how far that was drawn."""
        hinge, context = self.hinge, self.context
        bend = self._eased(hinge.bend_for(length(place - self.centre)), drawn_m)
        lower = turn(hinge.axis, bend - hinge.bend)
        direction = unit(place - self.centre)
        to_parent = context.R_camera_parent(self.upper).T
        R_upper = to_parent @ self._swung(lower, direction)
        rotations = {
            self.upper: untwisted(context, self.upper, R_upper, to_parent @ direction, drawn_m),
            self.lower: lower @ context.pose.Rs_parent_part[self.lower],
        }
        return Reached(rotations, self.centre, hinge.farthest_m)

    def _eased(self, bend: float, drawn_m: float) -> float:
        """Where the pose is bent the wrong way, it stays so at first: nothing jumps."""
        hinge = self.hinge
        if hinge.bend * hinge.side >= 0:
            return bend
        share = 1.0 - smooth_step(drawn_m / EASED_M)
        return bend + share * (hinge.bend - hinge.side * abs(hinge.bend))

    def _swung(self, lower: Array, direction: Array) -> Array:
        """(3, 3) R_camera_upper that points the limb, its hinge turned by `lower`, to there.

        `lower` (3, 3) is a turn in the upper part's frame.
        """
        hinge = self.hinge
        R_before = self.context.R_camera_part(self.upper)
        before, after = hinge.upper + hinge.lower, hinge.upper + lower @ hinge.lower
        # Bending turns the line from joint to end inside the limb; it is turned back in its plane.
        back = 0.0
        if length(across(after, hinge.axis)) > 1e-9 and length(across(before, hinge.axis)) > 1e-9:
            back = signed_angle(after, before, hinge.axis)
        R_flat = R_before @ turn(hinge.axis, back)
        swing = self.swing
        return np.asarray(swing.to(direction, unit(R_flat @ after)) @ R_flat)

    @property
    def swing(self) -> Swing:
        """How the limb as a whole is swung."""
        start = unit(self.end - self.centre)
        rest = self.context.skeleton.joints[self.lower] + self.tip
        resting = self.context.resting_direction(self.upper, rest)
        normal = self.context.R_camera_part(self.upper) @ self.hinge.axis
        return Swing.of(start, resting, cross(normal, start))
