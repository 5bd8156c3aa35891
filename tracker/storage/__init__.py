"""A session's files on disk: whole or not there, and never lost."""
