"""JSON on stdout: strict, in ASCII, with null for what is not a finite number."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from keypose.tracker.formats.verdict_words import verdict_words
from keypose.tracker.session.verdict import Verdict


def print_json(value: object, *, indent: int | None = None) -> None:
    """One document on a line of its own (or indented), sent at once."""
    print(json.dumps(json_value(value), allow_nan=False, indent=indent), flush=True)


def verdict_fields(verdict: Verdict | None) -> dict[str, Any]:
    """A verdict in the fields of its segment; null where there is none yet."""
    if verdict is None:
        return dict.fromkeys(("verdict", "words", "cause", "part", "frames", "go"))
    return {
        "verdict": verdict.kind,
        "words": verdict_words(verdict),
        "cause": verdict.cause,
        "part": verdict.part,
        "frames": verdict.frames,
        "go": verdict.go,
    }


def print_written(files: Iterable[Path], as_json: bool) -> None:
    """The files a command has written: a line for each, or one JSON object with the list."""
    if as_json:
        print_json({"written": [str(file) for file in files]})
        return
    for file in files:
        print(f"Written: {file}")


def json_value(value: Any) -> Any:
    """Dataclasses, mappings and sequences as JSON's own types."""
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        fields = dataclasses.fields(value)
        return {field.name: json_value(getattr(value, field.name)) for field in fields}
    if isinstance(value, Mapping):
        return {str(key): json_value(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [json_value(item) for item in value]
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    return value
