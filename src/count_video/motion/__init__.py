"""Which explanation of the tracks has the most evidence."""
