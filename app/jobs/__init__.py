"""Tracking jobs: a worker process of their own, so that the page stays quick."""

from __future__ import annotations

from app.jobs.progress import Progress
from app.jobs.reports import (
    JobFailed,
    JobFinished,
    PassFinished,
    Ready,
    Report,
    SegmentFinished,
    Started,
    Wanted,
    Warming,
)
from app.jobs.tracking import LIVE, Tracking

__all__ = [
    "LIVE",
    "JobFailed",
    "JobFinished",
    "PassFinished",
    "Progress",
    "Ready",
    "Report",
    "SegmentFinished",
    "Started",
    "Tracking",
    "Wanted",
    "Warming",
]
