"""Word facts for a person: problems, places to review, imports, jobs."""
