"""Sentences about what is wrong with a document."""

from __future__ import annotations

from typing import Any

import pytest
from pydantic import BaseModel, ValidationError

from keypose.tracker.errors import one_sentence


class _Inner(BaseModel):
    number: int


class _Outer(BaseModel):
    inner: _Inner
    several: tuple[_Inner, ...] = ()


@pytest.mark.parametrize(
    ("document", "sentence"),
    [
        ([], "Should be an object, with a name for every value."),
        ({"inner": 3}, "inner: should be an object, with a name for every value."),
        ({"inner": {"number": 3}, "several": [3]}, "several.0: should be an object, with a name "
         "for every value."),
        ({"inner": {"number": "x"}}, "inner.number: input should be a valid integer, unable to "
         "parse string as an integer."),
    ],
)  # fmt: skip
def test_a_sentence_names_the_field_and_no_class_of_the_program(
    document: Any, sentence: str
) -> None:
    with pytest.raises(ValidationError) as refused:
        _Outer.model_validate(document)
    assert one_sentence(refused.value) == sentence
