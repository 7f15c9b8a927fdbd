"""Many clips: one after the other, or as a campaign that keeps its results."""

from count_video.campaign.folder import VIDEO_SUFFIXES, clips_in
from count_video.campaign.one_by_one import Outcome, count_clips

__all__ = ["VIDEO_SUFFIXES", "Outcome", "clips_in", "count_clips"]
