"""Theory and event-driven simulator; knows no video."""
