"""Simulator to rendered clip with truth."""
