"""A minute of a scripted person's hand on a session that is tracked."""

from __future__ import annotations

from pathlib import Path

import pytest

from bench.human.clips import of_poses
from bench.human.minute import worked
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.storage.files import load_session, save_session
from tests.scenes import sample


@pytest.mark.parametrize("seconds", [0.0, 8.0, 60.0])
def test_a_person_takes_no_longer_than_they_have(tmp_path: Path, seconds: float) -> None:
    path = sample(tmp_path)
    known = load_session(path)
    found = [k.model_copy(update={"drafted": True}) for k in known.subject.keyframes]
    session = known.changed({"keyframes": tuple(found)})
    save_session(session, path)
    skeleton = Skeleton.of(session.subject.body)
    poses = {k.frame: k.pose(skeleton) for k in session.subject.keyframes}
    film = path.parent / session.view.video.path
    clip = of_poses("sample", film, session, poses)
    done = worked(clip, path, 0, seconds)
    assert done.effort.seconds <= seconds
    assert done.looked <= 1 + len(session.subject.keyframes) + done.offered
    assert (done.looked == 0) == (seconds == 0.0)
