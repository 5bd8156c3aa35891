"""Own the page's state: actions in, sections out, and what keeps it going."""
