"""The one owner of the page's state, and what keeps it going."""
