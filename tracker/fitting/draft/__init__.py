"""Draft the poses of a whole clip from keypoints with depth, before anything is posed."""

from keypose.tracker.fitting.draft.animal_clip import draft_animal
from keypose.tracker.fitting.draft.clip import (
    ClipDraft,
    DraftProgress,
    draft_clip,
    draft_from_keypoints,
    draft_people,
)
from keypose.tracker.fitting.draft.proposals import Proposal
from keypose.tracker.fitting.draft.refit import refit_drafts

__all__ = [
    "ClipDraft",
    "DraftProgress",
    "Proposal",
    "draft_animal",
    "draft_clip",
    "draft_from_keypoints",
    "draft_people",
    "refit_drafts",
]
