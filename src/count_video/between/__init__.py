"""Collisions between the frames: an event-driven model fitted to the track."""
