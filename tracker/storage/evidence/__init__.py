"""Open, find and recognise the files of a session's evidence."""

from keypose.tracker.session.evidence import ByEvidence, FilmEvidence, SurfaceEvidence
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.evidence.files import (
    EvidenceFiles,
    FilmFiles,
    SurfaceFiles,
    surfaces_of,
    with_cameras_fingerprint,
)

__all__ = ["EvidenceFiles", "files_of", "surfaces_of", "with_cameras_fingerprint"]

FILES: ByEvidence[EvidenceFiles] = ByEvidence(
    {FilmEvidence: FilmFiles(), SurfaceEvidence: SurfaceFiles()}
)


def files_of(session: Session) -> EvidenceFiles:
    """The operations on the files of a session's evidence."""
    return FILES.of(session)
