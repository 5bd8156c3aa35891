"""One order of the page to draft an animal."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

from keypose.app.document.new import new_session
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.drafted import drafting_model, require_draftable
from keypose.app.jobs.draft import DraftClip
from keypose.app.jobs.job import Finished, Progress
from keypose.tracker.body.body import preset
from keypose.tracker.errors import KeypointError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.keypoints import model_files
from keypose.tracker.session import Session
from keypose.tracker.storage.networks import add_own, remove_network
from keypose.tracker.video import Video
from tests.animals.dot_network import dot_network
from tests.animals.walking import CAMERA, Walk, error_share
from tests.app.jobs.job_cases import NUMBER, reported_until

WALK = Walk("horse", frames=10)
LONG = Walk("horse", frames=40)


@pytest.fixture(autouse=True)
def _with_network(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    path, content = tmp_path / "ap10k.onnx", dot_network()
    path.write_bytes(content)
    add_own("paws", path, hashlib.sha256(content).hexdigest())


@pytest.fixture
def film(tmp_path: Path) -> Path:
    return WALK.film(tmp_path / "film")


def session_of(film: Path, body: str = WALK.name) -> Session:
    with Video.open(film) as video:
        session = new_session(video, film / "session.json")
    camera = Camera.model_validate(CAMERA.model_dump())
    return session.changed({"body": preset(body), "camera": camera})


def order(film: Path, walk: Walk = WALK) -> DraftClip:
    content = session_of(film).model_dump_json().encode()
    frames = (0, walk.frames - 1)
    return DraftClip(content, str(film), "", 0, walk.box(), frames, proportions=False)


def test_an_animal_is_drafted_and_its_progress_rises(film: Path) -> None:
    *progress, end = reported_until(order(film), None)
    assert isinstance(end, Finished)
    draft, network, detected = end.result[0]
    assert detected is None
    assert network.endswith("-animal")
    assert error_share(WALK, dict(draft.poses)) < 0.06
    words = [each.words for each in progress if isinstance(each, Progress) and each.words]
    assert words[0].startswith("Looking for the animal: ")
    assert words[-1] == "Posing: 10 of 10 frames"


def test_a_draft_of_an_animal_that_is_cancelled_at_once_reports_nothing(film: Path) -> None:
    *progress, end = reported_until(order(film), 2)
    assert end == Finished(NUMBER, cancelled=True)
    assert len(progress) == 2


def test_one_that_is_cancelled_later_keeps_what_the_network_has_seen(tmp_path: Path) -> None:
    *_, end = reported_until(order(LONG.film(tmp_path / "long"), LONG), 30)
    assert isinstance(end, Finished)
    assert not end.cancelled
    (draft, _, detected), last = end.result[0], LONG.frames - 1
    assert detected is not None
    assert detected[0] == 0
    assert 15 <= detected[1] < last
    assert sorted(draft.poses) == list(range(detected[1] + 1))


def test_the_network_that_is_chosen_comes_before_others_that_were_added(
    film: Path, tmp_path: Path
) -> None:
    session = session_of(film)
    assert drafting_model(session).name == "paws"
    content = dot_network()
    path = tmp_path / "ap10k.onnx"
    add_own("apaws", path, hashlib.sha256(content).hexdigest())
    assert drafting_model(session).name == "apaws"
    settings = session.settings.model_copy(update={"network": "paws"})
    assert drafting_model(session.changed({"settings": settings})).name == "paws"


def test_what_cannot_be_drafted_is_refused_in_one_sentence(film: Path) -> None:
    box, frames = WALK.box(), (0, 9)
    require_draftable(session_of(film), 0, box, frames)
    with pytest.raises(ActionRefused, match=r"need a person's or an animal's body: choose .*horse"):
        require_draftable(session_of(film, "box"), 0, box, frames)
    remove_network("paws")
    with pytest.raises(KeypointError, match="models add NAME --from FILE --sha256 DIGEST --anim"):
        require_draftable(session_of(film), 0, box, frames)
    assert model_files.added_models() == ()
