"""A body whose markings change, followed by its outline beside one that was found."""
