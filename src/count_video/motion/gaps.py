"""The turn-over: positions in the picture become distances from the wall, and gaps.

Everything that finds collisions works in these terms: distances grow away from the wall,
whichever side of the picture it stands on, and a contact is a gap that closes.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from count_video.records import CollisionKind, Floats, Track


@dataclass(frozen=True)
class Gaps:
    """Distances away from the wall and the gap between the bodies; arrays have shape (n,)."""

    frame: Floats
    """Frame coordinates."""
    ball_px: Floats
    """The ball's centre, away from the wall, from an arbitrary origin; NaN where not seen."""
    heavy_px: Floats
    """The heavy body's face turned to the ball, from the same origin."""
    gap_px: Floats
    """From the ball's outline to the heavy body's face, by the outlines; about 0 at contact."""
    sign: int
    """+1 where distances grow with the position in the picture, -1 where they fall."""

    def closing(self, kind: CollisionKind) -> Floats:
        """Gap that closes in a collision of a kind; for the wall, the ball's distance."""
        return self.ball_px if kind == "wall" else self.gap_px

    @property
    def near_edge_px(self) -> float:
        """From the ball's centre to its outline on the side of the heavy body."""
        return float(np.nanmedian(self.heavy_px - self.ball_px - self.gap_px))


def gaps_of(track: Track) -> Gaps:
    """Turn a track with both bodies over into distances from the wall."""
    if track.heavy is None:
        raise ValueError("a track of one body has no gap between bodies")
    sign = 1 if track.wall_side == "left" else -1
    near_edge = track.ball.high_edge_px if sign > 0 else -track.ball.low_edge_px
    ball = sign * track.ball.position_px
    heavy = sign * track.heavy.position_px
    return Gaps(
        frame=track.frame,
        ball_px=ball,
        heavy_px=heavy,
        gap_px=heavy - ball - near_edge,
        sign=sign,
    )
