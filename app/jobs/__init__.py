"""Tracking and fitting: a worker process of their own, so that the page stays quick."""

from __future__ import annotations

from app.jobs.messages import (
    Drafted,
    Drafting,
    DraftOrder,
    FitOrder,
    Fitted,
    JobFailed,
    JobFinished,
    PassFinished,
    PoseFitted,
    PoseFitting,
    PoseOrder,
    Ready,
    Report,
    SegmentFinished,
    SizesFitted,
    SizesOrder,
    SpaceOrder,
    SpaceSolved,
    Started,
    Wanted,
    Warming,
)
from app.jobs.progress import Progress, seconds_left
from app.jobs.tracking import LIVE, Tracking

__all__ = [
    "LIVE",
    "DraftOrder",
    "Drafted",
    "Drafting",
    "FitOrder",
    "Fitted",
    "JobFailed",
    "JobFinished",
    "PassFinished",
    "PoseFitted",
    "PoseFitting",
    "PoseOrder",
    "Progress",
    "Ready",
    "Report",
    "SegmentFinished",
    "SizesFitted",
    "SizesOrder",
    "SpaceOrder",
    "SpaceSolved",
    "Started",
    "Tracking",
    "Wanted",
    "Warming",
    "seconds_left",
]
