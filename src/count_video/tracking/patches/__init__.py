"""What stands out from a scenery that stands still, and the paths it takes."""
