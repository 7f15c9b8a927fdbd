"""Let the outlines touch where the collisions say they do.

A body's face is learnt from the picture, and a rim, a shadow or a reflection can pass for it. The
track is not wrong by that, only shifted by a constant; and the collisions between the bodies tell
the constant, for there the heavy body's face is where the ball's outline is.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from count_video.records import Collision, Track
from count_video.reports.material import contact_px


def touching(track: Track, collisions: tuple[Collision, ...]) -> Track:
    """Shift the heavy body's reference point to where the ball touches it, in the median."""
    if track.heavy is None:
        return track
    seen = np.isfinite(track.heavy.position_px)
    contacts = [c for c in collisions if c.kind == "bodies" and c.seen]
    if not contacts or not seen.any():
        return track
    face = np.interp([c.frame for c in contacts], track.frame[seen], track.heavy.position_px[seen])
    shift = float(np.median(np.array([contact_px(c, track) for c in contacts]) - face))
    heavy = replace(
        track.heavy,
        position_px=track.heavy.position_px + shift,
        low_edge_px=track.heavy.low_edge_px - shift,
        high_edge_px=track.heavy.high_edge_px - shift,
    )
    return replace(track, heavy=heavy)
