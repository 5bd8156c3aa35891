"""Rigs in the programs they are for: whether these find what was written, where it should be.

A module for every program; each installs what it needs in a place of its own, and is left out by
name where that does not install. Another one is its name in `PROGRAMS` and a module with a function
of that name.
"""

from __future__ import annotations

import importlib

from bench.keeping import Absent
from bench.table import Report

PROGRAMS = ("readers", "blender", "blender_bones", "blender_cameras", "three_js", "opensim")


def rigs(report: Report) -> None:
    """The whole group."""
    for name in PROGRAMS:
        try:
            getattr(importlib.import_module(f"bench.rigs.{name}"), name)(report)
        except Absent as absent:
            report.note(f"{name}: left out, {absent} is not here")
