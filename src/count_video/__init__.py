"""Count the collisions in slow-motion footage of the "pi by collisions" experiment."""

__version__ = "0.1.0"
