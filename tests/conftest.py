"""How properties are tested: on a build machine the same examples every time."""

from __future__ import annotations

import os

from hypothesis import settings

# No deadlines: the first example of a test may compile a loop.
settings.register_profile("here", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("ci" if os.environ.get("CI") else "here")
