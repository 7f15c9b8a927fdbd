"""Two bodies that could collide, found by how they move in a few short runs."""
