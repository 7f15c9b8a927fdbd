"""Campaigns of many synthetic trials with known truth."""
