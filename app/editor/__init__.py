"""Edit the document: one pure function from a state and an action to the next state.

Knows no page and no viser.
"""
