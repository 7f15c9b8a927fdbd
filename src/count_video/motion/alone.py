"""The impacts that a clip of one body alone shows, or of two that meet nothing but each other."""

from __future__ import annotations

from count_video.motion.batches import fit_contacts
from count_video.motion.cadence import frames_per_picture, in_frames, in_pictures
from count_video.motion.flight import motion_of
from count_video.motion.impacts import find_impacts
from count_video.motion.joint import Fitting, collisions_of
from count_video.motion.meeting import seen_meetings
from count_video.motion.model import Paths
from count_video.motion.reasons import Cause, Reason
from count_video.motion.seen import shows_motion
from count_video.motion.weighing import SeenImpacts, weighed
from count_video.records import Track


def seen_impacts(track: Track) -> SeenImpacts:
    """Find the impacts of one body alone (kind ``wall``), or of two on each other (``bodies``)."""
    if not shows_motion(track):
        return SeenImpacts((), (Reason(Cause.NO_IMPACT),), (), {})
    pace = frames_per_picture(track)
    slow = in_pictures(track, pace)
    if slow.heavy is not None:
        return seen_meetings(slow, slow.heavy, pace)
    motion = motion_of(slow.frame, slow.ball.position_px)
    impacts, contact = find_impacts(motion)
    fitted = fit_contacts(
        Paths(slow.frame, slow.ball.position_px, None),
        ["wall" if impact.side < 0 else "far" for impact in impacts],
        [impact.frame for impact in impacts],
        Fitting(touching=contact),
    )
    collisions = [in_frames(collision, pace) for collision in collisions_of(fitted)]
    return weighed(motion, impacts, (contact, pace), collisions)
