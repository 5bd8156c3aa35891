"""Write what tracking found as one page to read, print and send, with no outside reference."""
