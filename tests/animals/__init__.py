"""A dog and a horse that walk, as a test knows them, and a network that sees them."""
