"""Steps that cannot be used, in a sentence."""

from __future__ import annotations

from collections.abc import Mapping

from keypose.tracker.errors import numbers_listed


def describe_unusable(problems: Mapping[int, str]) -> str:
    """Which steps these are, and what is wrong with the first of them; empty where there are
    none.

    problems: of each step a sentence, which is enough where it is one step.
    """
    if len(problems) < 2:
        return "".join(problems.values())
    steps = numbers_listed(problems.keys())
    return f"Steps {steps} cannot be used. The first of them: {problems[min(problems)]}"
