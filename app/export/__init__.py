"""What is taken home: motion as files and a report; and what is brought along."""
