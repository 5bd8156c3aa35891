"""What a problem is put down to."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import pytest

from keypose.tracker.review.problems import blames_keys
from keypose.tracker.session.verdict import Verdict


@pytest.mark.parametrize(
    ("verdict", "last", "blamed"),
    [
        (Verdict.not_followed(1), 1, True),
        (Verdict.not_followed(1), 2, False),
        (Verdict.check("uncertain", (0, 1), "head"), 1, False),
        (Verdict.nothing_seen(0, 40), 40, True),
        (Verdict.contradiction(0, 1), 40, True),
        (None, 1, False),
    ],
)
def test_keyframes_are_to_blame_where_they_are_wrong_or_nothing_lies_between(
    verdict: Verdict | None, last: int, blamed: bool
) -> None:
    kind = None if verdict is None else verdict.kind
    track = SimpleNamespace(verdict=verdict, kind=kind, first=0, last=last)
    assert blames_keys(cast(Any, track)) is blamed
