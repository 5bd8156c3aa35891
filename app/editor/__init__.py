"""What a person edits, and the one function that changes it. Knows no page and no viser."""
