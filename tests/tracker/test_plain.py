"""What processes send each other is as it was, and what is sent to harm is no message."""

from __future__ import annotations

import json
import random
import struct
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.app.jobs.side_process import WorkState
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import ChoiceError, KeyposeError
from keypose.tracker.keypoints.model_files import THUNDER
from keypose.tracker.plain import NotPlain, from_bytes, to_bytes
from tests.fuzzing import kinds

MOTION = Trajectory(3, np.tile(np.eye(3), (4, 2, 1, 1)), np.arange(12.0).reshape(4, 3))
VALUES: dict[str, Any] = {
    "nothing": None,
    "numbers": (1, 2.5, float("inf"), True, "äöü", [1, [2, ()]], -(2**70)),
    "an array of its type": np.arange(6, dtype="<u2").reshape(2, 3),
    "an empty array": np.zeros((0, 3), np.float32),
    "texts": np.array(["a", "bcd"]),
    "a path": Path("/tmp/a b"),
    "a map by tuples": {("a", 1): (2.0,), ("b", 2): ()},
    "a model of pydantic": THUNDER,
    "a data class": MOTION,
    "a state of work": WorkState("failed", 3, 9, "It failed."),
    "within one another": WorkState("done", result={"motion": MOTION, "all": frozenset("xy")}),
}


@pytest.mark.parametrize("what", VALUES)
def test_a_value_comes_as_it_was(what: str) -> None:
    message = to_bytes(VALUES[what])
    found = from_bytes(message)
    assert type(found) is type(VALUES[what])
    assert to_bytes(found) == message
    if not what.startswith(("an array", "an empty", "texts", "a data", "within")):
        assert found == VALUES[what]


def test_a_data_class_has_read_only_arrays_as_if_it_had_been_made_here() -> None:
    found = from_bytes(to_bytes(MOTION))
    np.testing.assert_array_equal(found.ps_camera_root, MOTION.ps_camera_root)
    assert not found.Rs_parent_part.flags.writeable
    assert found.last_frame == 6


def test_an_error_says_what_it_said() -> None:
    found = from_bytes(to_bytes(ChoiceError("Several: choose.", "--individual", ("rat", "mouse"))))
    assert isinstance(found, ChoiceError)
    assert (str(found), found.choices) == ("Several: choose.", ("rat", "mouse"))


def test_whatever_a_reader_makes_of_a_file_can_be_sent(tmp_path: Path) -> None:
    for name, kind in kinds(tmp_path).items():
        path = tmp_path / kind.file
        path.write_bytes(kind.content)
        try:
            message = to_bytes(kind.read(path))
        except KeyposeError as error:  # such as of a library that is not installed
            message = to_bytes(error)
        assert to_bytes(from_bytes(message)) == message, name


@pytest.mark.parametrize("value", [object(), len, {"f": lambda: 1}, np.array([object()]), [sys]])
def test_what_is_not_plain_is_not_sent(value: Any) -> None:
    with pytest.raises(NotPlain):
        to_bytes(value)


def message_of(value: Any, arrays: Any = (), content: bytes = b"") -> bytes:
    header = json.dumps({"value": value, "arrays": arrays}).encode()
    return struct.pack("<Q", len(header)) + header + content


def made_of(name: str, **fields: Any) -> bytes:
    return message_of({"class": name, "fields": fields})


HARMFUL: dict[str, bytes] = {
    "nothing": b"",
    "a pickle": b"cos\nsystem\n(S'true'\ntR.",
    "a class of others": made_of("subprocess:Popen", args="true"),
    "a function": made_of("keypose.tracker.plain:to_bytes"),
    "the program": made_of("keypose.app.__main__:main"),
    "a class by another name": made_of("keypose.tracker.scratch:Path"),
    "a class that is no data": made_of("keypose.tracker.scratch:Scratch"),
    "other fields": made_of("keypose.tracker.body.trajectory:Trajectory"),
    "no such module": made_of("keypose.tracker.nothing:Thing"),
    "an array that is not there": message_of({"array": 7}),
    "an array of objects": message_of({"array": 0}, [["|O", 1]], b"12345678"),
    "an endless array": message_of({"array": 0}, [["<f8", 2**62, 2**62]], b"1234"),
    "a negative array": message_of({"array": 0}, [["<f8", -1]], b""),
    "too many bytes": message_of({"array": 0}, [["<f8", 1]], b"1" * 9),
    "a deep list": struct.pack("<Q", 10**6) + b"[" * 10**6,
    "a key that is none": message_of({"map": [[[], 1]]}),
    "an endless header": struct.pack("<Q", 2**64 - 1) + b"{}",
}


@pytest.mark.parametrize("harm", HARMFUL)
def test_what_is_sent_to_harm_is_no_message(harm: str) -> None:
    with pytest.raises(NotPlain):
        from_bytes(HARMFUL[harm])


def test_a_mutant_of_a_message_is_a_value_or_none_and_loads_no_foreign_module() -> None:
    chance, message = random.Random(5), to_bytes(VALUES["within one another"])
    known = set(sys.modules)
    for _ in range(2000):
        changed = bytearray(message)
        for _ in range(chance.randint(1, 4)):
            changed[chance.randrange(len(changed))] = chance.randrange(256)
        try:
            from_bytes(bytes(changed))
        except NotPlain:
            continue
    assert not {name for name in set(sys.modules) - known if not name.startswith("keypose.")}
