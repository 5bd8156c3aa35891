"""Session files of other versions: older ones are migrated to the present one, in memory.

Version 2 keeps fields it does not know, has a journal beside it, and may name a first motion.
Version 3 has verdicts as facts, where version 2 had sentences.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any, Final, TypeAlias

from keypose.tracker.errors import SessionError
from keypose.tracker.session.version_2 import migrate_to_3

PRESENT: Final = 3

Data: TypeAlias = dict[str, Any]

_NUMBER = re.compile(rb'"schema_version"\s*:\s*(\d{1,9})\s*[,}]')
_HEAD_BYTES = 4096


def _from_1(data: Data) -> Data:
    """Everything in version 1 still means the same."""
    return data


STEPS: Mapping[int, Callable[[Data], Data]] = {1: _from_1, 2: migrate_to_3}
"""From each older version to the one after it."""


def migrate(data: Any, name: str) -> Data:
    """A session's JSON as one of the present version; a newer one stays as it is.

    Checked first: another version's fields would give misleading errors.
    SessionError, with the file's name, where it is not a session.
    """
    if not isinstance(data, dict):
        raise SessionError(f"{name} is not a session: its JSON is not an object.")
    if "schema_version" not in data:
        raise SessionError(
            f"{name}: schema_version is missing; a session of this Keypose says {PRESENT}."
        )
    version = data["schema_version"]
    if type(version) is not int or not 1 <= version <= 10**9:
        raise SessionError(f"{name}: schema_version must be a number from 1 to {PRESENT}.")
    present: Data = data
    while version < PRESENT:
        present = STEPS[version](present)
        version += 1
        present = {**present, "schema_version": version}
    return present


def version_in(content: bytes) -> int | None:
    """The version named in the first bytes of a file; None where there is none."""
    found = _NUMBER.search(content[:_HEAD_BYTES])
    return None if found is None else int(found[1])
