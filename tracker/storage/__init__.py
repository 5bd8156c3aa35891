"""Store a session's files whole or not at all, journal its edits, and tell what is outdated."""
