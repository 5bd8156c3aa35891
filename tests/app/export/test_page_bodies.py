"""What the page saves of several bodies is what the command line writes of them."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import pytest

from keypose.app.cli.main import main
from keypose.app.document.open import edit_state, open_for_editing
from keypose.app.export.motion_files import motion_archive
from tests.app.bodies_cases import two_tracked


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return two_tracked(tmp_path_factory.mktemp("two"))


@pytest.mark.parametrize(("format_name", "names"), [
    ("glb", ["motion.glb"]),
    ("bvh", ["body.bvh", "second.bvh"]),
])  # fmt: skip
def test_the_page_saves_all_bodies_as_the_command_line_does(
    format_name: str, names: list[str], path: Path
) -> None:
    out = path.parent / f"out-{format_name}"
    assert main(["export", str(path), "--format", format_name, "--out", str(out)]) == 0
    written = {file.name: file.read_bytes() for file in out.iterdir()}
    assert sorted(written) == names
    opened = open_for_editing(path, lambda _: path)
    edit, _ = edit_state(opened)
    file = motion_archive(format_name, edit)  # type: ignore[arg-type]
    opened.video.close()
    if len(names) == 1:
        assert file.content == written[names[0]]
        return
    with zipfile.ZipFile(io.BytesIO(file.content)) as archive:
        assert {name: archive.read(name) for name in archive.namelist()} == written
