"""What tracking found, as one page to read, print and send: no server, no outside reference."""
