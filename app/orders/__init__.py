"""What may be asked for, declared once for command line, page and batch: an option is one field."""
