r"""Distinguish an impact from the turn of a swing by the law that the swing's acceleration follows.

    acceleration                         acceleration
     |.                                   | |            the spike of an impact:
     | `.     a swing: linear in          | |            no law of the flights on
     |   `.   the place, turns            |_|_________   both sides gives it
     |     `. included                    |
     +-------`--> place                   +-----------> place

Of a pendulum, a spring and a throw the acceleration is linear in the place, so are the differences
of places so far apart that they show it above the noise,

    x(t + m) - 2 x(t) + x(t - m) = a + b x(t),

exactly, for any step m, however few pictures show a swing. The law is fitted to both flights clear
of the turn, and what it leaves over at the turn is the jump of the velocity that an impact adds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from count_video.motion.flight import Motion, Rows
from count_video.records import Floats

STEP_SHARE = 0.25
"""Step of the differences, as a share of the shorter flight clear of the contact."""
LONGER_AT_MOST = 2.0
FLIGHT_PICTURES = 6.0
"""The longer flight is taken along to this factor of the shorter one, or so many pictures."""
PARAMETERS = 2
EXCESS_SHARE = 0.4
EXCESS_SIGMAS = 3.0
EXCESS_SIGMA_AT_MOST = 0.2
"""At an impact the law of a swing leaves more than this share of the bend over, clear of the noise;
where the share is known to less than the second, an impact's share of 1 differs from a swing's 0.
"""
SECOND_DIFFERENCE = 6.0
"""Variance of a second difference of white noise, over that of the noise."""


@dataclass(frozen=True)
class Excess:
    """What the law of a swing leaves over at a turn, as a share of the turn's whole bend."""

    share: float
    """0 where the turn is that of a swing, 1 between straight flights, more where these bend the
    other way, as under gravity."""
    sigma: float
    """Its standard uncertainty."""


def is_sharp(left: Excess) -> bool:
    """Whether a turn is surely no swing's."""
    return left.share > max(EXCESS_SHARE, EXCESS_SIGMAS * left.sigma)


def is_smooth(left: Excess) -> bool:
    """Whether a turn is surely that of a swing."""
    return left.share <= EXCESS_SHARE and left.sigma <= EXCESS_SIGMA_AT_MOST


def excess(
    motion: Motion, turn: float, limits: tuple[float, float], contact: float
) -> Excess | None:
    """Measure how much sharper a turn is than that of a swing; None if too few pictures show it.

    Parameters
    ----------
    turn
        Frame of the corner, in pictures.
    limits
        Where the flights before and after it begin and end.
    contact
        Half the time that a contact takes, in pictures.
    """
    begin, end = _window(motion, turn, limits)
    step = max(1, round(STEP_SHARE * (min(turn - begin, end - turn) - contact)))
    rows = np.flatnonzero((motion.frame >= begin) & (motion.frame <= end))
    if len(rows) <= 2 * step:
        return None
    rows = rows[step:-step]
    bend = _differences(motion, rows, step)
    rows, bend = rows[np.isfinite(bend)], bend[np.isfinite(bend)]
    away = np.abs(motion.frame[rows] - turn)
    clear = away > step + contact
    weight = np.clip(1 - away / step, 0.0, None)
    if clear.sum() < PARAMETERS or not weight.any():
        return None
    return _left_over(motion, rows, bend, (clear, weight / float(weight @ weight)))


def _window(motion: Motion, turn: float, limits: tuple[float, float]) -> tuple[float, float]:
    """Both flights, where the body is seen, neither much longer than the other."""
    seen = motion.frame[np.isfinite(motion.place_px)]
    before = turn - max(limits[0], float(seen[0]))
    after = min(limits[1], float(seen[-1])) - turn
    longest = max(LONGER_AT_MOST * min(before, after), FLIGHT_PICTURES)
    return turn - min(before, longest), turn + min(after, longest)


def _differences(motion: Motion, rows: Rows, step: int) -> Floats:
    place = motion.place_px
    return np.asarray(place[rows + step] - 2 * place[rows] + place[rows - step])


def _left_over(
    motion: Motion, rows: Rows, bend: Floats, chosen: tuple[NDArray[np.bool_], Floats]
) -> Excess | None:
    """Fit the law to the clear rows, and weigh what it leaves over at the turn."""
    clear, weight = chosen
    design = np.column_stack([np.ones(len(rows)), motion.place_px[rows]])
    inverse = np.linalg.pinv(design[clear].T @ design[clear])
    left_over = bend - design @ (inverse @ (design[clear].T @ bend[clear]))
    whole = float(weight @ bend)
    if whole == 0.0:
        return None
    freedom = max(int(clear.sum()) - PARAMETERS, 1)
    noise = SECOND_DIFFERENCE * motion.sigma_px**2
    variance = max(noise, float(left_over[clear] @ left_over[clear]) / freedom)
    lever = weight @ design
    sigma = np.sqrt(variance * float(weight @ weight + lever @ inverse @ lever))
    return Excess(float(weight @ left_over) / whole, float(sigma) / abs(whole))
