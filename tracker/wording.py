"""Sentences: of a validation error, one that a person can act on; names one after another."""

from __future__ import annotations

from collections.abc import Sequence

from pydantic import ValidationError


def one_sentence(error: ValidationError) -> str:
    """The first problem as a sentence that names the field and says what is allowed."""
    first = error.errors(include_url=False)[0]
    place = ".".join(str(step) for step in first["loc"])
    text = first["msg"].removeprefix("Value error, ").rstrip(".")
    text = text[:1].lower() + text[1:]
    more = error.error_count() - 1
    rest = f" (and {more} more)" if more else ""
    return f"{place}: {text}{rest}." if place else f"{text[:1].upper()}{text[1:]}{rest}."


def listed(names: Sequence[str]) -> str:
    """ "head", "head and neck", "head, neck and chest"."""
    return " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))
