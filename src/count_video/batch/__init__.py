"""Many clips as a campaign that keeps its results."""
