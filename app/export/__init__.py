"""Export motion, pictures and a report; import what other programs made."""
