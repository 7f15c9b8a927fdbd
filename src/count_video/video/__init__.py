"""Files to frames and times, and back: the one door to PyAV."""
