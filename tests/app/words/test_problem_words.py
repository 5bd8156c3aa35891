"""What is said of how far a motion may be off."""

from __future__ import annotations

import pytest

from keypose.app.words.problems import off_words


@pytest.mark.parametrize(
    ("cm", "px", "words"),
    [
        (262.31, 3.44, "262 cm and 3.4 px"),
        (0.0, None, "0.0 cm"),
        (None, 12_345.6, "12346 px"),
    ],
)
def test_lengths_are_plain_numbers_however_large(
    cm: float | None, px: float | None, words: str
) -> None:
    assert off_words(cm, px) == words
