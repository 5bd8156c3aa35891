"""The bodies of people from measurements that were published.

Everything measured stands in the tables at the top, with its source; everything estimated is a
named constant or a method of `Person` that says so. Tables in millimetres or as ratios, the bodies
in metres. Limbs are frusta, so that they can taper; equal ends give a cylinder.

Sources
  [A] ANSUR II: Gordon et al., 2012 Anthropometric Survey of U.S. Army Personnel: Methods and
      Summary Statistics, NATICK/TR-15/007, 2014. Means of 4,082 men and 1,986 women.
  [D] Drillis and Contini, Body Segment Parameters, 1966, as printed in Winter, Biomechanics and
      Motor Control of Human Movement, figure 4.1. Fractions of stature.
  [L] de Leva, Adjustments to Zatsiorsky-Seluyanov's segment inertia parameters, Journal of
      Biomechanics 29, 1996, table 4. Between joint centres, young men and women.
  [N] Fryar et al., Anthropometric Reference Data for Children and Adults: United States,
      August 2021-August 2023 (NHANES), Vital and Health Statistics 3(50), 2025.
  [W] de Onis et al., Development of a WHO growth reference for school-aged children and
      adolescents, Bulletin of the World Health Organization 85, 2007. Median stature at 7 years.
  [J] American Academy of Orthopaedic Surgeons, Joint Motion: Method of Measuring and Recording,
      1965. Degrees from the upright stance, arms hanging: the rest pose.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from typing import TypeAlias

from keypose.tracker.body.body import Body, Dof, Limits, Part, Point, Twist
from keypose.tracker.body.shapes import Box, Cylinder, Frustum, Shape

Radii: TypeAlias = tuple[float, float]

ANSUR_MM: dict[str, tuple[float, float]] = {  # [A], men and women; whole numbers are rounded
    "stature": (1756.2, 1628.5),
    "bideltoid_breadth": (510.4, 450.3),
    "chest_depth": (253.8, 247.4),
    "waist_breadth": (326.0, 300.0),
    "waist_depth": (238.0, 213.0),
    "hip_breadth": (345.7, 353.8),
    "buttock_depth": (246.0, 233.0),
    "neck_circumference": (397.6, 329.8),
    "head_circumference": (574.4, 561.1),
    "head_breadth": (154.4, 147.7),
    "biceps_circumference_flexed": (358.1, 305.6),
    "forearm_circumference_flexed": (310.1, 264.1),
    "wrist_circumference": (176.0, 155.0),
    "hand_breadth": (88.0, 78.0),
    "thigh_circumference": (625.1, 616.1),
    "lower_thigh_circumference": (408.0, 399.0),
    "calf_circumference": (392.3, 373.3),
    "ankle_circumference": (229.0, 216.0),
    "foot_length": (271.0, 246.0),
    "foot_breadth": (102.0, 93.0),
}
ELDERLY_MM: dict[str, tuple[float, float]] = {
    "stature": (1724.0, 1583.0),  # [N] table 7, ages 70-79
}

# A child of 7 years, boys and girls together. Stature is [W]'s, the mean of 1217 and 1208; all
# else is estimated: a child's head and trunk are longer for its stature than an adult's, its legs
# shorter, its girths smaller.
CHILD_MM: dict[str, float] = {
    "stature": 1212.5,
    "bideltoid_breadth": 305.0,
    "chest_depth": 142.0,
    "waist_breadth": 192.0,
    "waist_depth": 150.0,
    "hip_breadth": 214.0,
    "buttock_depth": 150.0,
    "neck_circumference": 265.0,
    "head_circumference": 519.0,
    "head_breadth": 142.0,
    "biceps_circumference_flexed": 196.0,
    "forearm_circumference_flexed": 183.0,
    "wrist_circumference": 127.0,
    "hand_breadth": 62.0,
    "thigh_circumference": 370.0,
    "lower_thigh_circumference": 275.0,
    "calf_circumference": 250.0,
    "ankle_circumference": 170.0,
    "foot_length": 190.0,
    "foot_breadth": 75.0,
}

# [N], ages 70-79 over the mean of 20-29 and 30-39, men and women: what age changes within one
# survey, apart from what sets soldiers apart from others.
AGE_WAIST = (107.5 / 98.2, 99.6 / 94.15)  # table 12
AGE_HIP = (105.0 / 105.4, 108.6 / 109.3)  # table 14
AGE_ARM = (33.4 / 34.85, 32.1 / 32.9)  # table 16, mid-upper arm

# [L], over stature, men and women. [D] has the upper arm from the acromion, 0.186, and the joint
# lies under it.
UPPER_ARM = (281.7 / 1741, 275.1 / 1735)
SHOULDER_OVER_HIP = 0.5 * (515.5 / 1741 + 497.9 / 1735)
SHOULDER_DROP = 0.007
"""The joint lies under the bony point whose height [D] gives; anatomy has it 0.01 lower, and the
hip at the trochanter, 0.530; but then the trunk is shorter than [L] and motion capture have it."""


@dataclass(frozen=True)
class Proportions:
    """Heights above the floor, and lengths, over stature."""

    ankle: float
    knee: float
    acromion: float
    chin: float
    forearm: float
    hand: float
    shoulder_over_hip: float
    crotch: float
    root: float
    lumbar: float
    chest_top: float
    head_joint: float

    @property
    def shoulder(self) -> float:
        return self.acromion - SHOULDER_DROP

    @property
    def hip(self) -> float:
        return self.shoulder - self.shoulder_over_hip


ADULT = Proportions(
    ankle=0.039, knee=0.285, acromion=0.818, chin=0.870, forearm=0.146, hand=0.108,  # [D]
    shoulder_over_hip=SHOULDER_OVER_HIP,
    # Estimates: places inside the trunk that no survey measures from outside.
    crotch=0.490, root=0.555, lumbar=0.610, chest_top=0.832, head_joint=0.890,
)  # fmt: skip
CHILD = Proportions(  # estimates, all of them
    ankle=0.045, knee=0.268, acromion=0.795, chin=0.839, forearm=0.146, hand=0.110,
    shoulder_over_hip=0.300, crotch=0.452, root=0.520, lumbar=0.578, chest_top=0.808,
    head_joint=0.862,
)  # fmt: skip

# Estimates: a solid that is too thick claims points of the background, one that is too thin only
# loses some of its own, so all girths are taken slightly under.
LIMB = 0.95
TRUNK = 0.95
RELAXED = 0.94
"""Relaxed girth over flexed girth, which is what [A] measured on the arm."""

GIVE = 10
"""Estimate: what a wrist and an ankle yield about their own length."""
KNEE_GIVE = 4
ELBOW_GIVE = 6
"""Estimates: what hinges yield across their axis, the shin's own turn among it. Knees of people
who walk are adducted by up to 5°."""

# [J], by the name of the part without its side; left sides have y and z negated. Forward and
# sideways are angles about x and z, turning is about y. The forearm's turn is [J]'s pronation and
# supination. Estimates: neck and head share one range in [J], the head has all of it, as the neck
# is not tracked, and the neck half; how far a wrist turns and a foot points in or out.
RANGES: dict[str, Limits] = {
    "chest": {"x": (-30, 80), "y": (-45, 45), "z": (-35, 35)},
    "neck": {"x": (-22, 22), "y": (-30, 30), "z": (-22, 22)},
    "head": {"x": (-45, 45), "y": (-60, 60), "z": (-45, 45)},
    "upper_arm": {"x": (-180, 60), "y": (-70, 90), "z": (-45, 180)},
    "forearm": {"x": (-150, 0), "y": (-80, 80), "z": (-ELBOW_GIVE, ELBOW_GIVE)},
    "hand": {"x": (-20, 30), "y": (-GIVE, GIVE), "z": (-80, 70)},
    "thigh": {"x": (-120, 30), "y": (-45, 45), "z": (-30, 45)},
    "shin": {"x": (0, 135), "y": (-KNEE_GIVE, KNEE_GIVE), "z": (-KNEE_GIVE, KNEE_GIVE)},
    "foot": {"x": (-20, 50), "y": (-GIVE, GIVE), "z": (-35, 15)},
}

# How far upper arm and thigh turn about their own length, right side, outward positive. Textbooks
# give about 70° inward and 90° outward at the shoulder, 45° each way at the hip. From where that is
# counted changes with where the limb points, by up to 30°, and a hand behind the back turns the arm
# inward in the chest by more than the joint does, a thigh drawn up outward as much: the ranges have
# room for both, and for elbows of recordings that are set 20° aside. Swings are counted from an arm
# held forward and out, a thigh forward and down: what is not determined is an arm through the ribs,
# a thigh up behind.
TWISTS: dict[str, Twist] = {
    "upper_arm": Twist(range_deg=(-125, 125), toward=(-3, 2, -3)),
    "thigh": Twist(range_deg=(-80, 80), toward=(-1, 3, -3)),
}


@dataclass(frozen=True)
class Person:
    """The measured figures of one population, in metres, and the estimates made from them."""

    woman: bool
    elderly: bool
    child: bool = False

    @property
    def over_stature(self) -> Proportions:
        return CHILD if self.child else ADULT

    def mm(self, name: str) -> float:
        """A measured figure in metres."""
        if self.child:
            return CHILD_MM[name] / 1000
        table = ELDERLY_MM if self.elderly and name in ELDERLY_MM else ANSUR_MM
        return table[name][self.woman] / 1000

    def aged(self, ratios: tuple[float, float]) -> float:
        """Ratio by which age changes a girth of this population."""
        return ratios[self.woman] if self.elderly else 1.0

    @property
    def stature(self) -> float:
        return self.mm("stature")

    @property
    def adult_stature(self) -> float:
        """Arms, hands, feet and head keep the adult size: [N] table 18 finds no shorter arms."""
        return self.stature if self.child else ANSUR_MM["stature"][self.woman] / 1000

    def up(self, fraction: float) -> float:
        """Height above the floor, to 0.1 mm so that the parts add up to the stature exactly."""
        return round(fraction * self.stature, 4)

    def limb_radius(self, name: str, share: float = 1.0) -> float:
        """Radius of a limb's measured girth; legs are estimated to age as arms do."""
        bony = name.startswith(("wrist", "ankle"))
        age = 1.0 if bony else self.aged(AGE_ARM)
        return self.mm(name) / (2 * math.pi) * LIMB * share * age

    @property
    def hip_half(self) -> float:
        """Lower half-width of the waist part; the thighs beside it fill the hip breadth."""
        return self.mm("hip_breadth") * 0.44 * self.aged(AGE_HIP)

    @property
    def waist_radii(self) -> Radii:
        """Estimate the radii at the navel: age adds more depth than breadth; together they give the
        girth.
        """
        age = self.aged(AGE_WAIST)
        breadth = self.mm("waist_breadth") * age**0.5
        return breadth / 2 * TRUNK, self.mm("waist_depth") * age**1.5 / 2 * TRUNK

    @property
    def arm_radii(self) -> tuple[float, float, float]:
        """Estimate the radii at shoulder, elbow and wrist; the elbow is the mean of both
        muscles.
        """
        shoulder = self.limb_radius("biceps_circumference_flexed", RELAXED)
        forearm = self.limb_radius("forearm_circumference_flexed", RELAXED)
        return shoulder, 0.45 * (shoulder + forearm), self.limb_radius("wrist_circumference")

    @property
    def shoulder_x(self) -> float:
        """Joint from the midline: the arm's outside at the measured breadth over the deltoids,
        but far enough out that arms hanging straight down are clear of waist and hips."""
        shoulder, elbow, wrist = self.arm_radii
        age = self.stature / self.adult_stature
        measured = self.mm("bideltoid_breadth") * age / 2 - shoulder
        clear = max(self.waist_radii[0] + elbow, self.hip_half + (elbow + wrist) / 2)
        return max(measured, clear + 0.004)


def make_body(name: str) -> Body:
    """The preset of this name, made from the tables."""
    who = Person(name.endswith("female"), name.startswith("elderly"), name == "child")
    parts = [*_trunk(who), *_arm(who, "left"), *_arm(who, "right")]
    parts += [*_leg(who, "left"), *_leg(who, "right")]
    limbs = ("upper_arm", "forearm", "hand", "thigh", "shin", "foot")
    pairs = tuple((f"left_{limb}", f"right_{limb}") for limb in limbs)
    body = Body(name=name, parts=tuple(parts), mirror_pairs=pairs, source=_source(who))
    return Body.model_validate(_rounded(body.model_dump()))


def as_json(body: Body) -> str:
    """The text of a body file."""
    return json.dumps(body.model_dump(mode="json"), indent=1) + "\n"


def _trunk(who: Person) -> list[Part]:
    of = who.over_stature
    root, lumbar, top = who.up(of.root), who.up(of.lumbar), who.up(of.chest_top)
    head, crown = who.up(of.head_joint), who.up(1.0)
    hip = (who.hip_half, who.mm("buttock_depth") / 2 * 0.9 * who.aged(AGE_HIP))
    arm = who.arm_radii[0]
    # Breadth and depth at shoulder height are estimates: into the arms, and flatter than below.
    shoulders = (who.shoulder_x - 0.85 * arm, who.mm("chest_depth") / 2 * 0.78)
    neck = who.mm("neck_circumference") / (2 * math.pi) * TRUNK
    chin = who.adult_stature * (1 - of.chin) - (crown - head)
    waist = _frustum(root - who.up(of.crotch), root - lumbar, hip, who.waist_radii)
    ribs = _frustum(0.02, lumbar - top, who.waist_radii, shoulders)
    throat = Cylinder(start_m=0.03, end_m=top - head - 0.02, radius_m=neck)
    skull = _frustum(chin, head - crown, *_head_radii(who))
    return [
        _part("waist", None, (0, 0, 0), waist, ("tx", "ty", "tz", "rx", "ry", "rz")),
        _part("chest", "waist", (0, root - lumbar, 0), ribs, ("rx", "ry", "rz")),
        _part("neck", "chest", (0, lumbar - top, 0), throat),
        _part(
            *("head", "neck", (0, top - head, -0.015), skull, ("rx", "ry")),
            landmarks={"head_top": (0, head - crown, 0)},
        ),
    ]


def _head_radii(who: Person) -> tuple[Radii, Radii]:
    """Estimate the radii at chin and crown: depth from girth and breadth, the taper assumed."""
    across = who.mm("head_breadth") / 2
    deep = (who.mm("head_circumference") / math.pi - across) * LIMB
    return (0.78 * across, 0.82 * deep), (0.94 * across, 0.94 * deep)


def _arm(who: Person, side: str) -> list[Part]:
    out = 1 if side == "left" else -1
    of = who.over_stature
    lengths = (UPPER_ARM[who.woman], of.forearm, of.hand)
    upper, fore, hand = (round(f * who.adult_stature, 4) for f in lengths)
    shoulder, elbow, wrist = who.arm_radii
    joint_y = who.up(of.lumbar) - who.up(of.shoulder)
    # The upper arm reaches above its joint: the round of the shoulder.
    top = _frustum(-0.7 * shoulder, upper, (shoulder, shoulder), (elbow, elbow))
    low = _frustum(0, fore, (elbow, elbow), (wrist, wrist))
    palm = who.mm("hand_breadth") / 2 * 0.9
    box = Box(low_m=(-0.014, -0.01, -palm), high_m=(0.014, hand, palm))
    return [
        _part(f"{side}_upper_arm", "chest", (out * who.shoulder_x, joint_y, 0), top, ("rx", "rz")),
        _part(f"{side}_forearm", f"{side}_upper_arm", (0, upper, 0), low, ("rx",)),
        _part(
            *(f"{side}_hand", f"{side}_forearm", (0, fore, 0), box),
            landmarks={f"{side}_hand_tip": (0, hand, 0)},
        ),
    ]


def _leg(who: Person, side: str) -> list[Part]:
    out = 1 if side == "left" else -1
    of = who.over_stature
    hip, knee, ankle = who.up(of.hip), who.up(of.knee), who.up(of.ankle)
    top = who.limb_radius("thigh_circumference", 0.93)  # measured under the crotch, the thickest
    bend = who.limb_radius("lower_thigh_circumference", 0.95)
    low = who.limb_radius("ankle_circumference")
    hip_x = who.mm("hip_breadth") * 0.245  # estimate; the joints lie inside
    # The shin starts as wide as the knee: a straight taper cannot bulge where the calf does.
    thigh = _frustum(0, hip - knee, (top, top), (bend, bend))
    shin = _frustum(0, knee - ankle * 0.6, (bend, bend), (low, low))
    length, half = who.mm("foot_length"), who.mm("foot_breadth") / 2 * LIMB
    heel, toe = 0.25 * length, -0.75 * length  # estimate: where the ankle stands over the foot
    foot = Box(low_m=(-half, 0.3 * ankle, toe), high_m=(half, ankle, heel))
    marks = {f"{side}_toe": (0.0, ankle, toe), f"{side}_heel": (0.0, ankle, heel)}
    joint = (out * hip_x, who.up(of.root) - hip, 0)
    return [
        _part(f"{side}_thigh", "waist", joint, thigh, ("rx", "rz")),
        _part(f"{side}_shin", f"{side}_thigh", (0, hip - knee, 0), shin, ("rx",)),
        _part(f"{side}_foot", f"{side}_shin", (0, knee - ankle, 0), foot, landmarks=marks),
    ]


def _frustum(start: float, end: float, start_radii: Radii, end_radii: Radii) -> Frustum:
    return Frustum(start_m=start, end_m=end, start_radii_m=start_radii, end_radii_m=end_radii)


def _part(
    name: str,
    parent: str | None,
    joint_m: Point,
    shape: Shape,
    tracked: tuple[Dof, ...] = (),
    landmarks: dict[str, Point] | None = None,
) -> Part:
    return Part(
        name=name,
        parent=parent,
        joint_m=joint_m,
        shape=shape,
        tracked=tracked,
        landmarks=landmarks or {},
        limits_deg=_limits(name),
        twist=_twist(name),
    )


def _limits(name: str) -> Limits:
    """The table is for the right side; x is the same on both, y and z are mirrored."""
    ranges = RANGES.get(name.removeprefix("left_").removeprefix("right_"), {})
    if not name.startswith("left_"):
        return ranges
    return {a: r if a == "x" else (-r[1], -r[0]) for a, r in ranges.items()}


def _twist(name: str) -> Twist | None:
    """The limit of twist of the right side; the left is mirrored."""
    twist = TWISTS.get(name.removeprefix("left_").removeprefix("right_"))
    if twist is None or not name.startswith("left_"):
        return twist
    (low, high), (x, y, z) = twist.range_deg, twist.toward
    return Twist(range_deg=(-high, -low), toward=(-x, y, z))


def _rounded(value: object) -> object:
    """Round to 0.1 mm, as far as any of this is known."""
    if isinstance(value, float):
        return round(value, 4) + 0.0  # no −0.0
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(item) for item in value]
    return value


def _source(who: Person) -> str:
    if who.child:
        return (
            "Stature: WHO growth reference 2007 (de Onis et al.), median at 7 years, boys and "
            "girls. Estimated: all proportions and girths. Joint limits as of adults: American "
            "Academy of Orthopaedic Surgeons, Joint Motion, 1965."
        )
    sex = "women" if who.woman else "men"
    text = (
        "Segment lengths: Drillis and Contini 1966 as printed in Winter, Biomechanics and Motor "
        "Control of Human Movement, fractions of stature; upper arm, and shoulder over hip: de "
        "Leva 1996. Breadths, depths and girths: ANSUR II (Gordon et al. 2014, U.S. Army survey of "
        f"2012), means of {sex}. "
    )
    if who.elderly:
        text += (
            f"Stature: NHANES August 2021-August 2023 (Fryar et al. 2025), {sex} of 70-79. The "
            "girths of waist, hips and arms are ANSUR II's times the change with age in the same "
            "NHANES report. Estimated: legs thin as arms do; arms, hands, feet and head keep the "
            "adult size; the breadth over the shoulders shrinks with stature; no stoop. "
        )
    else:
        text += f"Stature: ANSUR II, {sex}. "
    return text + (
        "Estimated for every preset: head depth, joints inside the trunk, places of the shoulder "
        "joints, all tapers. Joint limits: American Academy of Orthopaedic Surgeons, Joint Motion, "
        "1965; estimated where it tells none. Limbs are frusta, of which the cylinder is the "
        "untapered case, taken slightly thinner than measured."
    )
