"""Cut the state into the sections that the page receives, each sent anew only when it changed."""

from __future__ import annotations

from keypose.app.store.sections.changes import PLACES, Sections
from keypose.app.store.sections.film_values import film_version
from keypose.app.store.sections.scene_values import image_version

__all__ = ["PLACES", "Sections", "film_version", "image_version"]
