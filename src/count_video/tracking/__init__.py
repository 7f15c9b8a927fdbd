"""Frames to positions with uncertainty."""
