"""Names of the bodies that come with the product, kept apart: a command's help loads no body."""

from __future__ import annotations

ADULTS = ("adult_male", "adult_female", "elderly_male", "elderly_female")
CHILDREN = ("child",)
PEOPLE = (*ADULTS, *CHILDREN)
ANIMALS = ("dog", "horse")
RIGID = ("box", "cylinder", "ball", "stick")
"""Things of one part, to which others can be added."""
OBJECTS = (*RIGID, "racket", "club", "bicycle")
PRESETS = (*PEOPLE, *ANIMALS, *OBJECTS)
