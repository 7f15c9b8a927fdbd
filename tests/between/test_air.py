"""Air slows the light ball: its swing decays, and the heavy body may catch up with it for that.

The simulator knows no air. The motion is integrated here step by step, by another library.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from synthetic_tracks import TAIL_FRAMES

from count_video.motion.exposures import sample
from count_video.motion.fitted import Between, fit_burst
from count_video.motion.parameters import FIRST_DEVIATION, Column
from count_video.motion.pendulums import follow
from count_video.motion.seen import seen_collisions
from count_video.records import BodyTrack, Floats, MotionLine, Track

RATE, BALL_RATE = 0.013, 0.0133
HEAVY_REST, BALL_REST, WALL = 232.0, 230.0, 140.0
LIGHTNESS, BODIES, BOUNCE = 1 / 40, 0.97, 0.96
SPEED, EXPOSURE = 2.1, 0.4
START, FLIGHT_AT_MOST = -61.0, 400.0
DAMPING = 0.02
"""A strong one, of a ball of foam: one of steel has a tenth of it."""
EXACT = {"rtol": 1e-12, "atol": 1e-12}
INTEGRATED = 1e-6
"""Frames and px by which motions integrated to 1e-12 a step differ at most after some thousand."""
SIGMAS, NOISE_PX = 4.0, 0.01


@dataclass(frozen=True)
class Integrated:
    """A motion from the first collision on: its collisions, and its paths between them."""

    times: list[float]
    flights: list[object]
    """Solutions of each flight, over the time since its beginning."""

    def at(self, time: float) -> Floats:
        """State at a time after the first collision."""
        piece = int(np.searchsorted(self.times, time, side="right")) - 1
        state: Floats = self.flights[piece](time - self.times[piece])  # type: ignore[operator]
        return state


@cache
def integrated(damping: float) -> Integrated:
    """Integrate a burst from its first collision, at the ball's rest, to the heavy body's turn."""
    decay = damping * BALL_RATE

    def law(_: float, state: Floats) -> list[float]:
        heavy, heavy_rate, ball, ball_rate = state
        pull = (BALL_RATE**2 + decay**2) * (BALL_REST - ball) - 2 * decay * ball_rate
        return [heavy_rate, RATE**2 * (HEAVY_REST - heavy), ball_rate, pull]

    state, times, flights = np.array([BALL_REST, -SPEED, BALL_REST, 0.0]), [0.0], []
    while True:
        blow = len(times) % 2 == 1
        if blow:
            given = (1 + BODIES) * (state[1] - state[3]) / (1 + LIGHTNESS)
            state = state + given * np.array([0.0, -LIGHTNESS, 0.0, 1.0])
        else:
            state = state * [1.0, 1.0, 1.0, -BOUNCE]

        def gap(_: float, at: Floats, to_wall: bool = blow) -> float:
            return float(at[2] - WALL if to_wall else at[0] - at[2])

        gap.terminal, gap.direction = True, -1.0  # type: ignore[attr-defined]
        # A step away from the contact, where the gap is 0 to rounding.
        flight = solve_ivp(
            law,
            (0.0, FLIGHT_AT_MOST),
            state,
            events=gap,
            dense_output=True,
            first_step=1e-3,
            max_step=5.0,
            **EXACT,
        )
        flights.append(flight.sol)
        turned = state[1] > 0 > flight.y[1, -1]
        if flight.status != 1 or turned:
            return Integrated(times, flights)
        times.append(times[-1] + float(flight.t_events[0][0]))
        state = flight.y_events[0][0]


def values(damping: float) -> Floats:
    """The same motion as a set of parameters."""
    sets = np.zeros(FIRST_DEVIATION)
    sets[Column.HEAVY] = sets[Column.BALL_REST] = BALL_REST
    sets[Column.HEAVY_RATE], sets[Column.HEAVY_PULL] = -SPEED, RATE**2 * (HEAVY_REST - BALL_REST)
    sets[Column.SWING], sets[Column.BALL_SWING] = np.log(RATE), np.log(BALL_RATE / RATE)
    sets[Column.WALL], sets[Column.EXPOSURE] = WALL, EXPOSURE
    sets[Column.LIGHTNESS], sets[Column.DAMPING] = np.log(LIGHTNESS), np.log(damping)
    sets[Column.BODIES], sets[Column.BOUNCE] = BODIES, BOUNCE
    return sets


@pytest.mark.parametrize("damping", [0.002, 0.01, DAMPING])
def test_the_model_moves_as_its_law_integrated(damping: float) -> None:
    true = integrated(damping)
    paths = follow(values(damping)[None], len(true.times), START)
    assert np.allclose(paths.time[0, 1:], true.times, rtol=0.0, atol=INTEGRATED)


def test_a_frame_shows_the_mean_of_the_decaying_path_over_its_exposure() -> None:
    true, frame = integrated(DAMPING), np.array([5.3, 40.3, 60.0, 200.0])
    paths = follow(values(DAMPING)[None], len(true.times), START)
    seen = sample(paths, values(DAMPING)[None], frame).ball[0]
    for place, middle in zip(seen, frame, strict=True):
        ends = middle - EXPOSURE / 2, middle + EXPOSURE / 2
        inside = [time for time in true.times if ends[0] < time < ends[1]]
        mean = quad(lambda time: true.at(time)[2], *ends, points=inside or None)[0] / EXPOSURE
        assert abs(place - mean) < INTEGRATED


def filmed(damping: float, seed: int) -> Track:
    """Film the motion until some frames after the last collision."""
    true, rng = integrated(damping), np.random.default_rng(seed)
    frame = np.arange(np.ceil(START), true.times[-1] + TAIL_FRAMES)
    states = np.array([_mean(true, time) for time in frame])
    noise = rng.normal(0.0, NOISE_PX, (2, len(frame)))
    sigma = np.full(len(frame), NOISE_PX)
    ball = BodyTrack(states[:, 2] + noise[0], sigma, -40.0, 40.0)
    heavy = BodyTrack(states[:, 0] + 40.0 + noise[1], sigma, 0.0, 100.0)
    line = MotionLine(0.0, 100.0, 0.0, upright=False)
    return Track(frame - frame[0], ball, heavy, "left", 80.0, line, ())


def _mean(true: Integrated, middle: float) -> Floats:
    """Mean state over an exposure; before the first collision the heavy body swings freely."""
    times = middle + EXPOSURE * ((np.arange(24) + 0.5) / 24 - 0.5)
    return np.mean([true.at(time) if time > 0 else _free(time) for time in times], axis=0)


def _free(time: float) -> Floats:
    from_rest, angle = BALL_REST - HEAVY_REST, RATE * time
    heavy = HEAVY_REST + from_rest * np.cos(angle) - SPEED / RATE * np.sin(angle)
    return np.array([heavy, 0.0, BALL_REST, 0.0])


@pytest.mark.parametrize("seed", range(3))
def test_strong_damping_changes_neither_count_nor_mass_ratio(seed: int) -> None:
    track = filmed(DAMPING, seed)
    fit = fit_burst(track, seen_collisions(track))
    assert isinstance(fit, Between)
    assert fit.count == len(integrated(DAMPING).times)
    assert abs(fit.mass_ratio.value - 1 / LIGHTNESS) < SIGMAS * fit.mass_ratio.sigma
    assert abs(fit.restitution_wall.value - BOUNCE) < SIGMAS * fit.restitution_wall.sigma
    # The root mean square of n normal residuals scatters by its 1 / sqrt(2 n)th.
    assert fit.misfit_px < NOISE_PX * (1 + SIGMAS / np.sqrt(2 * len(track.frame)))
