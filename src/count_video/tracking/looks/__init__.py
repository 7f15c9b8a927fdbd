"""What a body looks like, and where in a picture it is that looks so."""
