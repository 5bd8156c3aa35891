"""What a person can have done by the worker besides tracking, by what asks for it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from keypose.app.jobs.adding_film import AddFilm, PlaceFilm
from keypose.app.jobs.ahead import FollowAhead
from keypose.app.jobs.draft import DraftClip
from keypose.app.jobs.find_camera import FindCamera
from keypose.app.jobs.find_up import FindUp
from keypose.app.jobs.fit import Fit
from keypose.app.jobs.fit_pose import FitPose
from keypose.app.jobs.fit_sizes import FitSizes
from keypose.app.jobs.lift import LiftDrafts
from keypose.app.jobs.reduce import ReduceMotion
from keypose.app.jobs.stand import StandOnFloor

KINDS: Final = (
    FitPose,
    FitSizes,
    DraftClip,
    FollowAhead,
    ReduceMotion,
    StandOnFloor,
    LiftDrafts,
    FindUp,
    FindCamera,
    AddFilm,
    PlaceFilm,
)

JOBS: Final[Mapping[str, type[Fit]]] = {name: kind for kind in KINDS for name in kind.asked}
"""By the name of the message that asks for it."""
