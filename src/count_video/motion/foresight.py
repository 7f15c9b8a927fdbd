"""What follows the clip's last frame, as far as two pendulums let it be foreseen.

After the last collision the ball may still drift to the wall, or the cylinder slow down before the
ball does; whether they meet once more before the cylinder turns round is then a matter of their
threads. Both swing at the rate measured on the cylinder, the ball about the place where it hung at
first, and the paths are followed until the cylinder's turn. A cylinder that has left the picture is
followed from where it was last seen.
"""

from __future__ import annotations

import numpy as np

from count_video.motion.gaps import Gaps
from count_video.motion.pieces import HALF_EXPOSURE
from count_video.motion.swing import Swing
from count_video.records import Floats

STATE_FRAMES = 64.0
"""The state at the end is fitted to at most so many frames."""
POINTS_AT_LEAST = 4
RATE_SIGMAS = 4.0
"""The swing must be measured this clearly to foresee anything by it."""
SWING_SHARE = 0.05
"""A cylinder that swings by less than this share of the way it has come is as good as at rest: when
it turns round is not known."""
SAMPLES = 400
CLEARANCE_SHARE = 0.005
"""Paths that come nearer than this share of the bodies' distance to rest are too near to call."""


def parted_until_turn(
    gaps: Gaps, swing: Swing | None, burst: tuple[float, float], struck: float
) -> bool:
    """Whether ball, cylinder and wall stay apart from the last frame to the cylinder's turn.

    Parameters
    ----------
    gaps
        The clip's distances.
    swing
        The cylinder's swing; without it nothing can be foreseen.
    burst
        Frames of the first and the last collision.
    struck
        Frame of the last collision of the cylinder.
    """
    if swing is None or swing.rate_squared < RATE_SIGMAS * swing.rate_squared_sigma:
        return False
    final, gone = float(gaps.frame[-1]), last_seen(gaps.frame, gaps.heavy_px)
    before = gaps.ball_px[gaps.frame < burst[0]]
    if not np.isfinite(before).any():
        return False
    rest = float(np.nanmedian(before))
    rate = float(np.sqrt(swing.rate_squared))
    # What the ball meets meanwhile changes nothing for a cylinder out of the picture.
    since = burst[1] if gone == final else struck
    heavy = _state(gaps.frame, gaps.heavy_px - swing.centre_px, rate, (since, gone))
    ball = _state(gaps.frame, gaps.ball_px - rest, rate, (burst[1], final))
    way = float(np.nanmax(gaps.heavy_px) - np.nanmin(gaps.heavy_px))
    if heavy is None or ball is None or np.hypot(*heavy) < SWING_SHARE * way:
        return False
    unseen = rate * (final - gone)
    turn = np.pi / 2 - np.arctan2(*heavy) - unseen
    if turn <= 0:
        return False
    phase = np.linspace(0.0, turn, SAMPLES)
    heavy_path = swing.centre_px + _away(heavy, unseen + phase)
    ball_path = rest + _away(ball, phase)
    contact = float(np.nanmin(gaps.heavy_px - gaps.ball_px))
    wall = float(np.nanmin(gaps.ball_px))
    clear_wall = ball_path - wall > CLEARANCE_SHARE * (rest - wall)
    clear_heavy = heavy_path - ball_path - contact > 0
    return bool(np.all(clear_wall) and np.all(clear_heavy))


def last_seen(frame: Floats, signal: Floats) -> float:
    """Last frame that shows a signal, shape (n,); -inf if none does."""
    return float(frame[np.isfinite(signal)].max(initial=-np.inf))


def _state(
    frame: Floats, away: Floats, rate: float, between: tuple[float, float]
) -> tuple[float, float] | None:
    """Fit a swing about its centre, as its cosine and sine parts at the second of two frames."""
    since, until = between
    chosen = np.isfinite(away) & (frame > max(since + HALF_EXPOSURE, until - STATE_FRAMES))
    chosen &= frame <= until
    if chosen.sum() < POINTS_AT_LEAST:
        return None
    phase = rate * (frame[chosen] - until)
    swing = np.column_stack([np.cos(phase), np.sin(phase)])
    cosine, sine = np.linalg.lstsq(swing, away[chosen], rcond=None)[0]
    return float(cosine), float(sine)


def _away(state: tuple[float, float], phase: Floats) -> Floats:
    """Distances of a pendulum from its centre at phases after a state."""
    return state[0] * np.cos(phase) + state[1] * np.sin(phase)
