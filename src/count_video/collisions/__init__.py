"""Positions to collisions."""
