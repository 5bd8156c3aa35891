"""What a clip's pictures gave is found once, and forgotten with the clip."""

from __future__ import annotations

import gc
import weakref

import numpy as np
import pytest

from keypose.tracker.tracking.per_clip import PerClip
from keypose.tracker.video.pyramid import Clip


def clip() -> Clip:
    return Clip(0, (np.zeros((1, 2, 2, 4), np.int16),))


def test_a_result_is_found_once_a_key_and_the_oldest_go() -> None:
    kept, here, asked = PerClip[int](most=2), clip(), list[int]()
    for number in (1, 2, 1, 3, 1, 2):

        def find(number: int = number) -> int:
            asked.append(number)
            return number

        assert kept.get(here, number, find) == number
    assert asked == [1, 2, 3, 2]


def test_another_clip_has_results_of_its_own_and_takes_them_with_it() -> None:
    kept, one, other = PerClip[str](most=2), clip(), clip()
    assert kept.get(one, 0, lambda: "one") == "one"
    assert kept.get(other, 0, lambda: "other") == "other"
    gone = weakref.ref(one)
    del one
    gc.collect()
    assert gone() is None


def test_what_fails_is_not_kept() -> None:
    kept, here = PerClip[int](most=2), clip()
    with pytest.raises(ZeroDivisionError):
        kept.get(here, 0, lambda: 1 // 0)
    assert kept.get(here, 0, lambda: 7) == 7
