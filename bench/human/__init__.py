"""A scripted person at the product: what they see, what their hands do, and what is counted."""
