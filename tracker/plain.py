"""Send values between two processes as plain facts: nothing of what is received is executed.

A message is a length (8 bytes), so much JSON, and the bytes of the arrays that it counts. Beside
JSON's own there are tuples, paths, arrays, and values of Keypose's own classes: data classes,
models of pydantic and errors, which are made anew of their fields.
"""

from __future__ import annotations

import dataclasses
import json
import struct
from collections.abc import Mapping
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from keypose.tracker.errors import KeyposeError

_KINDS: Final = "biufSU"
"""Of the numbers and texts that arrays may hold."""
_PACKAGE: Final = "keypose."
_DEEPEST: Final = 60
"""Values within one another."""


class NotPlain(ValueError):
    """A value that cannot be sent, or a message that is none."""


def to_bytes(value: Any) -> bytes:
    """A value as a message; NotPlain where it holds what is not plain."""
    arrays: list[NDArray[Any]] = []
    facts = _facts(value, arrays, 0)
    shapes = [[array.dtype.str, *array.shape] for array in arrays]
    header = json.dumps({"value": facts, "arrays": shapes}).encode()
    content = (np.ascontiguousarray(array).tobytes() for array in arrays)
    return b"".join((struct.pack("<Q", len(header)), header, *content))


def from_bytes(message: bytes) -> Any:
    """The value of a message; NotPlain where it is none."""
    try:
        (length,) = struct.unpack_from("<Q", message)
        header = json.loads(message[8 : 8 + length])
        arrays = _arrays(header["arrays"], memoryview(message)[8 + length :])
        return _value(header["value"], arrays)
    except NotPlain:
        raise
    except (ArithmeticError, AttributeError, ImportError, LookupError, RecursionError) as error:
        raise NotPlain(str(error)) from None
    except (TypeError, ValueError, MemoryError, struct.error) as error:
        raise NotPlain(str(error)) from None


def _facts(value: Any, arrays: list[NDArray[Any]], depth: int) -> Any:
    """A value as JSON has it; every array is its number."""
    if depth > _DEEPEST:
        raise NotPlain("values lie too deep within one another")
    if isinstance(value, np.generic) and value.dtype.kind in _KINDS:
        value = value.item()
    if value is None or type(value) in (bool, int, float, str):
        return value

    def each(values: Any) -> list[Any]:
        return [_facts(one, arrays, depth + 1) for one in values]

    match value:
        case list():
            return each(value)
        case tuple() if type(value) is tuple:
            return {"tuple": each(value)}
        case np.ndarray() if value.dtype.kind in _KINDS:
            arrays.append(value)
            return {"array": len(arrays) - 1}
        case bytes():
            return {"bytes": value.hex()}
        case Path():
            return {"path": str(value)}
        case frozenset():
            return {"set": each(sorted(value, key=repr))}
        case Mapping():
            return {"map": [each(pair) for pair in value.items()]}
        case BaseModel():
            return {"class": _name_of(value), "json": value.model_dump_json()}
        case KeyposeError():
            fields = {"args": value.args, **vars(value)}
        case tuple() if hasattr(value, "_asdict"):
            fields = value._asdict()
        case _ if dataclasses.is_dataclass(value):
            fields = {f.name: getattr(value, f.name) for f in dataclasses.fields(value)}
        case _:
            raise NotPlain(f"{type(value).__name__} is not plain")
    named = {name: _facts(one, arrays, depth + 1) for name, one in fields.items()}
    return {"class": _name_of(value), "fields": named}


def _name_of(value: Any) -> str:
    kind = type(value)
    if not kind.__module__.startswith(_PACKAGE) or "." in kind.__qualname__:
        raise NotPlain(f"{kind.__qualname__} is not one of Keypose's classes")
    return f"{kind.__module__}:{kind.__qualname__}"


def _arrays(shapes: list[Any], content: memoryview) -> list[NDArray[Any]]:
    kinds = [np.dtype(str(kind)) for kind, *_ in shapes]
    sizes = [tuple(int(size) for size in shape) for _, *shape in shapes]
    if any(kind.kind not in _KINDS for kind in kinds) or any(n < 0 for size in sizes for n in size):
        raise NotPlain("an array of what is not plain")
    lengths = [
        int(np.prod(s, dtype=object)) * k.itemsize for s, k in zip(sizes, kinds, strict=True)
    ]
    ends = np.cumsum([0, *lengths], dtype=object)
    if int(ends[-1]) != len(content):
        raise NotPlain("arrays that do not fit the message")
    spans = pairwise(map(int, ends))
    return [
        np.frombuffer(content[a:b], kind).reshape(size).copy()
        for (a, b), kind, size in zip(spans, kinds, sizes, strict=True)
    ]


def _value(facts: Any, arrays: list[NDArray[Any]]) -> Any:
    if isinstance(facts, list):
        return [_value(one, arrays) for one in facts]
    if not isinstance(facts, dict):
        return facts
    match facts:
        case {"tuple": list(each)}:
            return tuple(_value(one, arrays) for one in each)
        case {"array": int(number)}:
            return arrays[number]
        case {"bytes": str(text)}:
            return bytes.fromhex(text)
        case {"path": str(text)}:
            return Path(text)
        case {"set": list(each)}:
            return frozenset(_value(one, arrays) for one in each)
        case {"map": list(pairs)}:
            return {_value(key, arrays): _value(one, arrays) for key, one in pairs}
        case {"class": str(name), "json": str(text)}:
            model = _class_of(name)
            if issubclass(model, BaseModel):
                return model.model_validate_json(text)
        case {"class": str(name), "fields": dict(fields)}:
            return _made(_class_of(name), {key: _value(one, arrays) for key, one in fields.items()})
    raise NotPlain("a value that is not plain")


def _class_of(name: str) -> type[Any]:
    """One of Keypose's own classes, by its module and name."""
    module, _, kind = name.partition(":")
    if not module.startswith(_PACKAGE) or module.endswith("__main__") or not kind.isidentifier():
        raise NotPlain(f"{name!r} is not one of Keypose's classes")
    found = getattr(import_module(module), kind)
    if not isinstance(found, type) or found.__module__ != module:
        raise NotPlain(f"{name!r} is not one of Keypose's classes")
    return found


def _made(kind: type[Any], fields: dict[str, Any]) -> Any:
    """A value of its fields, as it was, its arrays read-only: no code of the class runs."""
    if issubclass(kind, KeyposeError):
        error = kind.__new__(kind)
        error.args = tuple(fields.pop("args"))
        error.__dict__.update(fields)
        return error
    if issubclass(kind, tuple) and hasattr(kind, "_fields"):
        return kind(**fields)
    if not dataclasses.is_dataclass(kind) or set(fields) != {
        f.name for f in dataclasses.fields(kind)
    }:
        raise NotPlain(f"{kind.__name__} has other fields")
    made = object.__new__(kind)
    for name, value in fields.items():
        if isinstance(value, np.ndarray):
            value.flags.writeable = False
        object.__setattr__(made, name, value)
    return made
