"""Sentences about what is wrong with a document."""

from __future__ import annotations

from typing import Annotated, Any

import pytest
from pydantic import BaseModel, Field, ValidationError, field_validator

from keypose.tracker.errors import one_sentence
from keypose.tracker.session.settings import SceneId


class _Inner(BaseModel):
    number: int


class _Outer(BaseModel):
    inner: _Inner
    several: tuple[_Inner, ...] = ()
    sizes: Annotated[tuple[int, ...], Field(min_length=1, max_length=2)] = (1,)
    pair: tuple[int, int] = (1, 2)
    id: SceneId = "inner"

    @field_validator("pair")
    @classmethod
    def _rises(cls, pair: tuple[int, int]) -> tuple[int, int]:
        if pair[0] > pair[1]:
            raise ValueError("pair: the first is the smaller one")
        return pair


@pytest.mark.parametrize(
    ("document", "sentence"),
    [
        ([], "Should be an object, with a name for every value."),
        ({"inner": 3}, "inner: should be an object, with a name for every value."),
        ({"inner": {"number": 3}, "several": [3]}, "several.0: should be an object, with a name "
         "for every value."),
        ({"inner": {"number": "x"}}, "inner.number: input should be a valid integer, unable to "
         "parse string as an integer."),
        ({"inner": {"number": 3}, "sizes": []}, "sizes: should hold at least 1, not 0."),
        ({"inner": {"number": 3}, "sizes": [1, 1, 1]},
         "sizes: should hold at most 2, not 3."),
        ({"inner": {"number": 3}, "pair": [1, 2, 3]}, "pair: should hold at most 2, not 3."),
        ({"inner": {"number": 3}, "pair": [2, 1]}, "pair: the first is the smaller one."),
        ({"inner": {"number": 3}, "id": "Rex II"},
         "id: should be 1 to 40 lower-case letters, digits, hyphens and underscores."),
    ],
)  # fmt: skip
def test_a_sentence_names_the_field_and_no_class_of_the_program(
    document: Any, sentence: str
) -> None:
    with pytest.raises(ValidationError) as refused:
        _Outer.model_validate(document)
    assert one_sentence(refused.value) == sentence
