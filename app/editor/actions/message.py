"""What a message is, and the numbers and words in it: checked where they enter.

Angles are degrees, sizes centimetres, places pixels of the main view, as on the page.
"""

from __future__ import annotations

from typing import Annotated, TypeAlias

from pydantic import BaseModel, ConfigDict, Field, FiniteFloat

Degrees: TypeAlias = Annotated[FiniteFloat, Field(ge=-1080, le=1080)]
Metres: TypeAlias = Annotated[FiniteFloat, Field(ge=-1e4, le=1e4)]
Coordinate: TypeAlias = Annotated[FiniteFloat, Field(ge=-1e6, le=1e6)]
Spot: TypeAlias = tuple[Coordinate, Coordinate]
Stroke: TypeAlias = Annotated[str, Field(min_length=1, max_length=60)]


class Message(BaseModel):
    """One message; fields it does not know are refused."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Edit(Message):
    """An action that changes the document; those of one stroke are one undo step."""

    stroke: Stroke | None = None
