"""The clock that a clip was made by, and the collisions by it.

Frames are usually as even as the camera took them. Converters put copies between them, and
slow-motion exports leave pictures out in a part of the clip; what is then found by an even clock
has to be told by the frames that show it.
"""

from __future__ import annotations

from dataclasses import replace

from count_video.collisions.cadence import Cadence, cadence_of
from count_video.collisions.ramps import Ramp, ramps_of
from count_video.collisions.seen import SeenCollisions, seen_collisions
from count_video.records import Track, TrialResult

Clock = Cadence | Ramp


def seen_by_clock(track: Track) -> tuple[Clock | None, Track, SeenCollisions]:
    """Find the collisions by the clock that the clip was made by.

    Returns the clock (None where the frames are even), the track by that clock, and what it shows.
    """
    cadence = cadence_of(track)
    even = cadence.evened(track) if cadence else track
    found = seen_collisions(even)
    if found.borne_out and not found.doubts:
        return cadence, even, found
    for ramp in ramps_of(track):
        steady = ramp.evened(track)
        other = seen_collisions(steady, pace=1.0)
        sure = other.borne_out and not other.doubts and not other.shortcomings
        if sure and ramp.resolves(other.collisions):
            return ramp, steady, other
    return cadence, even, found


def as_shown(result: TrialResult, clock: Clock | None) -> TrialResult:
    """Tell collisions by the frames that show them, where these were not taken evenly."""
    if clock is None:
        return result
    warnings = (*result.warnings, clock.warning) if isinstance(clock, Ramp) else result.warnings
    return replace(result, collisions=tuple(map(clock.shown, result.collisions)), warnings=warnings)
