"""Things that get into the picture besides the apparatus."""
