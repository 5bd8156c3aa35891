"""Names of the bodies that come with the product, kept apart: a command's help loads no body."""

from __future__ import annotations

ADULTS = ("adult_male", "adult_female", "elderly_male", "elderly_female")
CHILDREN = ("child",)
PEOPLE = (*ADULTS, *CHILDREN)
ANIMALS = ("dog", "horse")
OBJECTS = ("box", "cylinder")
"""Rigid things of one part, to which others can be added."""
PRESETS = (*PEOPLE, *ANIMALS, *OBJECTS)
