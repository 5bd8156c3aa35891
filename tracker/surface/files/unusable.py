"""Steps that cannot be used, in a sentence."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Set

from keypose.tracker.errors import listed

MOST_NAMED = 8
"""Steps, or runs of them, that are called by their numbers."""


def describe_unusable(problems: Mapping[int, str]) -> str:
    """Which steps these are, and what is wrong with the first of them; empty where there are
    none.

    problems: of each step a sentence, which is enough where it is one step.
    """
    if len(problems) < 2:
        return "".join(problems.values())
    runs = list(_runs(problems.keys()))
    names = [f"{first}" if first == last else f"{first}–{last}" for first, last in runs]
    more = sum(last - first + 1 for first, last in runs[MOST_NAMED:])
    named = listed([*names[:MOST_NAMED], *([f"{more} more"] if more else [])])
    return f"Steps {named} cannot be used. The first of them: {problems[runs[0][0]]}"


def _runs(steps: Set[int]) -> Iterator[tuple[int, int]]:
    """The first and the last of those that follow one another."""
    starts = [step for step in sorted(steps) if step - 1 not in steps]
    ends = [step for step in sorted(steps) if step + 1 not in steps]
    yield from zip(starts, ends, strict=True)
