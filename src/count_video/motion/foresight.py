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
from count_video.motion.onesided import Side, fit_side, side_frames
from count_video.motion.swing import Swing
from count_video.records import Floats
from count_video.signals import sigma_of

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
    # What the ball meets meanwhile changes nothing for a cylinder out of the picture.
    heavy = _state(gaps, gaps.heavy_px, (burst[1] if gone == final else struck, gone))
    ball = _state(gaps, gaps.ball_px, (burst[1], final))
    before = gaps.ball_px[gaps.frame < burst[0]]
    if heavy is None or ball is None or not np.isfinite(before).any():
        return False
    rest = float(np.nanmedian(before))
    rate = float(np.sqrt(swing.rate_squared))
    away = heavy.value - swing.centre_px
    way = float(np.nanmax(gaps.heavy_px) - np.nanmin(gaps.heavy_px))
    if np.hypot(away, heavy.slope / rate) < SWING_SHARE * way:
        return False
    unseen = rate * (final - gone)
    turn = np.pi / 2 - np.arctan2(rate * away, heavy.slope) - unseen
    if turn <= 0:
        return False
    phase = np.linspace(0.0, turn, SAMPLES)
    heavy_path = _path(heavy, swing.centre_px, rate, unseen + phase)
    ball_path = _path(ball, rest, rate, phase)
    contact = float(np.nanmin(gaps.heavy_px - gaps.ball_px))
    wall = float(np.nanmin(gaps.ball_px))
    clear_wall = ball_path - wall > CLEARANCE_SHARE * (rest - wall)
    clear_heavy = heavy_path - ball_path - contact > 0
    return bool(np.all(clear_wall) and np.all(clear_heavy))


def last_seen(frame: Floats, signal: Floats) -> float:
    """Last frame that shows a signal, shape (n,); -inf if none does."""
    return float(frame[np.isfinite(signal)].max(initial=-np.inf))


def _state(gaps: Gaps, signal: Floats, between: tuple[float, float]) -> Side | None:
    """Value and slope of a path at the second of two frames, from what lies between them."""
    since, until = between
    chosen = side_frames(gaps.frame, signal, until + 1.0, since, STATE_FRAMES)
    side = fit_side(gaps.frame[chosen], signal[chosen], until, sigma_of(signal))
    return side if side is not None and side.points >= POINTS_AT_LEAST else None


def _path(state: Side, centre: float, rate: float, phase: Floats) -> Floats:
    """Positions of a pendulum at phases after a state."""
    return centre + (state.value - centre) * np.cos(phase) + state.slope / rate * np.sin(phase)
