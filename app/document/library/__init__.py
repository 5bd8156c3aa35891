"""List what can be opened, and where it lives: recent sessions, files, samples, uploads.

library = Library(workspace, roots)
library.contents()                     # what the start screen shows
library.find("recent", id)             # the path behind an id of the contents
library.session_for(video)             # where the session of a video lives
with library.upload("jump.mp4", size) as upload:
    upload.write(chunk)
    id = upload.finish()               # find("upload", id) is its path
library.discard(id)                    # when it turns out to be no video
"""

from __future__ import annotations

from keypose.app.document.library.library import Library
from keypose.app.document.library.recents import id_of
from keypose.app.document.library.session_files import usual_folders
from keypose.app.document.library.uploads import LARGEST_BYTES, Upload

__all__ = ["LARGEST_BYTES", "Library", "Upload", "id_of", "usual_folders"]
