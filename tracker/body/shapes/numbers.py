"""The numbers that shapes are made of, metres."""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import Field, FiniteFloat

Size: TypeAlias = Annotated[FiniteFloat, Field(ge=1e-6, le=100)]
Length: TypeAlias = Annotated[FiniteFloat, Field(ge=-100, le=100)]
Point: TypeAlias = tuple[Length, Length, Length]
