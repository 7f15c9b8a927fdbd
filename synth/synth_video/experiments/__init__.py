"""Other experiments than ball, cylinder and wall: one body alone, two like ones, five."""
