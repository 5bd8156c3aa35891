"""Where a segment starts from: the ways to a first trajectory, the most promising one first."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from keypose.tracker.body.trajectory import Pass, Trajectory
from keypose.tracker.tracking.frame_pair import capped_score, printed_score
from keypose.tracker.tracking.initial.chains import Chains, blend_chains, follow_both
from keypose.tracker.tracking.initial.lifting import lift
from keypose.tracker.tracking.initial.planar import planar_start
from keypose.tracker.tracking.initial.templates import limb_tracks
from keypose.tracker.tracking.method import Keypose, Paper
from keypose.tracker.tracking.scene import Scene
from keypose.tracker.tracking.segment import Segment, distance_px, extent_px, is_sound

DOUBT = 0.5
"""Distance between the two chains, as a share of that between them and plain interpolation, above
which interpolation may still be the better one and is scored as well."""
UNSURE = 0.25
"""Distance between a mark's two chains, as a share of the body's extent in the picture, above which
limbs are looked for by templates as well, which takes longer than all the rest."""
CHAIN_LOST = "the body was lost on the way from a keyframe: interpolated instead"
NO_TEMPLATES = "no limb could be followed by templates: the whole body was followed instead"
TEMPLATES_LOST = "templates led out of sight"
NOT_REACHED = "the imported motion does not reach over this segment"


@dataclass(frozen=True, eq=False)
class Starts:
    """First trajectories of a segment.

    ways: the first is where tracking begins; the others remain candidates for the result. Scored
        where there are several and the method judges.
    chains: the body followed from both keyframes; None where it was not, or left the scene.
    notes: sentences for a person about what could not be done as asked.
    """

    ways: tuple[Pass, ...]
    chains: Chains | None = None
    notes: tuple[str, ...] = ()


def starts(scene: Scene, segment: Segment, method: Keypose) -> Starts:
    """The ways that the method's `initial` allows; auto takes the one that scores best."""
    chains = follow_both(scene, segment, method)
    interpolated = Pass("interpolation", segment.interpolated(), None)
    ways, notes = [interpolated], [CHAIN_LOST]
    if chains is not None:
        both = Pass("both ways", blend_chains(scene, *chains), None)
        ways, notes = [both], []
        if method.judged and _is_doubtful(scene, chains, interpolated.trajectory, both.trajectory):
            ways += [interpolated]
    proposed_starts = [_by_templates(scene, segment, method, chains, ways[0].trajectory)]
    proposed_starts += [_imported(scene, segment, method)]
    for start in proposed_starts:
        notes += start.notes
        ways += start.ways
    return _rank(scene, segment, method, ways, chains, notes)


def printed_start(scene: Scene, segment: Segment, method: Paper) -> Starts:
    """The printed method's one start: interpolation, unless the settings say otherwise.

    An imported motion is taken where it scores better as printed.
    """
    interpolated = Pass("interpolation", segment.interpolated(), None)
    match method.initial:
        case "templates":
            start = planar_start(scene, segment, method.left_out)
            if is_sound(scene, segment, start.trajectory):
                return Starts((Pass("templates", start.trajectory, None),), None, start.notes)
            return Starts((interpolated,), None, (f"{TEMPLATES_LOST}: interpolated instead",))
        case "import":
            imported = _imported(scene, segment, method)
            return Starts((*imported.ways, interpolated)[:1], None, imported.notes)
        case "auto":
            imported = _imported(scene, segment, method)
            tried = [*imported.ways, interpolated]
            scores = [
                printed_score(scene, segment.clip, initial_pass.trajectory)
                for initial_pass in tried
            ]
            return Starts((tried[int(np.argmin(scores))],))


def _rank(
    scene: Scene,
    segment: Segment,
    method: Keypose,
    ways: list[Pass],
    chains: Chains | None,
    notes: list[str],
) -> Starts:
    """The ways by their scores, one asked for by name before all others."""
    if len(ways) > 1:
        ways = [
            replace(start, score=capped_score(scene, segment.clip, start.trajectory, method.stride))
            for start in ways
        ]
    ways = sorted(ways, key=lambda start: (start.what != method.initial, start.score))
    if not method.judged:
        ways = [replace(ways[0], score=None)]
    return Starts(tuple(ways), chains, tuple(notes))


def _by_templates(
    scene: Scene, segment: Segment, method: Keypose, chains: Chains | None, base: Trajectory
) -> Starts:
    """The base with its limbs fitted to their tracks, where asked for or promising."""
    asked = method.initial == "templates"
    allowed = method.initial == "auto" and method.templates
    if not asked and not (allowed and _is_unsure(scene, chains, base)):
        return Starts(())
    tracks = limb_tracks(scene, segment, method.left_out, chains)
    notes = tracks.notes if asked else ()
    if not np.isfinite(tracks.uv).any():
        return Starts((), None, (*notes, NO_TEMPLATES) if asked else ())
    trajectory = lift(scene, segment, base, tracks)
    if not is_sound(scene, segment, trajectory):
        return Starts((), None, (f"{TEMPLATES_LOST}: followed from both keyframes instead",))
    return Starts((Pass("templates", trajectory, None),), None, notes)


def _imported(scene: Scene, segment: Segment, method: Keypose | Paper) -> Starts:
    """The imported motion, where it may be started from and lies before the camera."""
    imported = segment.imported
    if method.initial not in ("auto", "import"):
        return Starts(())
    if imported is None or not is_sound(scene, segment, imported):
        return Starts((), None, (NOT_REACHED,) if method.initial == "import" else ())
    return Starts((Pass("import", imported, None),))


def _is_doubtful(scene: Scene, chains: Chains, interpolated: Trajectory, both: Trajectory) -> bool:
    """Whether interpolation may be better than the chains."""
    apart = distance_px(scene, *chains).mean()
    return bool(apart > DOUBT * distance_px(scene, interpolated, both).mean())


def _is_unsure(scene: Scene, chains: Chains | None, base: Trajectory) -> bool:
    """Whether the chains lie so far apart somewhere that templates may be better."""
    if chains is None:
        return True
    if len(base) < 3:
        return False
    share = np.linspace(0.0, 1.0, len(base))[1:-1]
    apart = np.nan_to_num(distance_px(scene, *chains)[1:-1], nan=np.inf)
    return bool((apart.T * 4 * share * (1 - share)).max() > UNSURE * extent_px(scene, base))
