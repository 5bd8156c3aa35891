"""What the page asks the worker for."""

from __future__ import annotations

from typing import get_args

from keypose.app.editor import actions
from keypose.app.jobs.asked import JOBS, KINDS


def test_every_message_asks_for_one_job_at_most() -> None:
    assert sum(len(kind.asked) for kind in KINDS) == len(JOBS)


def test_what_asks_for_a_job_is_a_message_of_the_page() -> None:
    messages = {kind.model_fields["do"].default for kind in get_args(actions.Running)}
    assert set(JOBS) <= messages
    at_once = {"find_people", "look_before", "close_fit", "close_up"}
    previewing = {"preview_poses", "apply_sizes", "discard_sizes"}
    fitting = {kind.model_fields["do"].default for kind in get_args(actions.Fitting)}
    assert fitting - set(JOBS) == at_once | previewing
