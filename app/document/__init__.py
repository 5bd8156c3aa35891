"""A session as a person has it: begun, opened, kept, found again."""
