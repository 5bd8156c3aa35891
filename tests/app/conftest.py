"""Sessions on disk for the command line."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from keypose.app.cli import follow
from keypose.tracker import warm
from keypose.tracker.keypoints.model_files import cache_folder
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.tracks import save_result
from tests.app.cli_cases import tracker
from tests.app.full_disks import mounted
from tests.scenes import sample
from tests.tracker import session_cases as cases


@pytest.fixture(autouse=True)
def heeded_ctrl_c() -> Iterator[None]:
    """Ctrl+C as at a terminal, also where whoever started the tests has it ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache in which nothing was kept on an earlier day, but for the compiled loops: processes
    that a test starts would compile them, for half a minute."""
    loops, cache = cache_folder() / "kernels", tmp_path / "cache"
    loops.mkdir(parents=True, exist_ok=True, mode=0o700)
    (cache / "keypose").mkdir(parents=True)
    (cache / "keypose" / "kernels").symlink_to(loops)
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache))
    return cache


@pytest.fixture
def session_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A session on disk, not yet tracked; tracking is a fake."""
    monkeypatch.setattr(follow, "rerun", tracker())
    monkeypatch.setattr(warm, "is_warm", lambda *parts: True)
    folder = tmp_path / "job"
    folder.mkdir()
    return cases.write_session(folder)


@pytest.fixture
def tracked_path(session_path: Path) -> Path:
    """A tracked session on disk."""
    session = save_result(load_session(session_path), session_path, cases.result())
    save_session(session, session_path)
    (session_path.parent / "session.json.previous").unlink()
    return session_path


@pytest.fixture
def small_disk(tmp_path: Path) -> Iterator[Path]:
    """A disk with room for the session and a few edits."""
    with mounted(tmp_path / "disk", "640k") as place:
        yield place


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A session for the store."""
    return sample(tmp_path)
