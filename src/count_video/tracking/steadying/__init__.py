"""How the camera moved, told by what stands still."""
