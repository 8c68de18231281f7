"""Linear models of any part of the loop, and what they say about it."""
