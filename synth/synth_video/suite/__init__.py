"""Suites of clips under named conditions, and the score of what is counted on them."""
