"""The image installs exact versions that Keypose is made for, each known by its digests."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

from packaging.requirements import Requirement

ROOT = Path(__file__).parents[1]
PACKAGE = re.compile(r"^([\w.-]+)==(\S+) \\$")
DIGEST = re.compile(r"^    --hash=sha256:[0-9a-f]{64}( \\)?$")


def test_all_that_is_needed_is_in_the_lock_at_one_version_with_digests() -> None:
    text = (ROOT / "requirements.lock").read_text("utf-8")
    versions, digests, name = {}, {}, ""
    for line in text.splitlines():
        if found := PACKAGE.match(line):
            name = found[1]
            assert name not in versions
            versions[name], digests[name] = found[2], 0
        elif not line.startswith("#"):
            assert DIGEST.match(line), line
            digests[name] += 1
    assert all(digests.values())
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    for needed in map(Requirement, project["dependencies"]):
        assert versions[needed.name] in needed.specifier, needed


def test_the_image_is_built_of_the_lock_alone() -> None:
    text = (ROOT / "Dockerfile").read_text("utf-8")
    installs = re.findall(r"pip install [^&]*", text.replace("\\\n", " "))
    assert all("--require-hashes" in one or "--no-deps" in one for one in installs)
    assert len(installs) == 2
