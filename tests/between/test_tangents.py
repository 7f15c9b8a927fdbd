from __future__ import annotations

import numpy as np
import pytest

from count_video.motion.exposures import sample, sampled_tangents
from count_video.motion.parameters import FIRST_DEVIATION, Column
from count_video.motion.pendulums import Paths, follow, tangents_of
from count_video.records import Floats

START = -61.0
FRAME = np.arange(-60.0, 120.0)
ROUNDING_PX = 1e-9
"""Paths of some hundred px over a hundred flights, each rounded to 1e-16."""
STEP = 1e-6
DERIVATIVE_SHARE = 1e-4
"""Central differences err by the square of the step and by rounding over the step."""


def values(count: int, seed: int = 3) -> Floats:
    """Draw parameters of a burst near 1:80 that swings, loses and has parallax."""
    rng = np.random.default_rng(seed)
    base = np.zeros(FIRST_DEVIATION)
    base[Column.HEAVY] = base[Column.BALL_REST] = 230.0
    base[Column.HEAVY_RATE], base[Column.HEAVY_PULL] = -2.1, -0.003
    base[Column.SWING], base[Column.BALL_SWING] = np.log(0.013), 0.02
    base[Column.WALL], base[Column.CONTACT], base[Column.EXPOSURE] = 140.0, 0.1, 0.4
    base[Column.LIGHTNESS], base[Column.PARALLAX] = -np.log(80.0), 0.01
    base[Column.BODIES], base[Column.BOUNCE], base[Column.DAMPING] = 0.97, 0.96, -4.5
    base[Column.SPEED] = 0.02
    return np.concatenate([base, rng.normal(0.0, 0.003, count)])


@pytest.mark.parametrize("count", [1, 2, 26, 60])
def test_one_motion_alone_is_the_same_as_among_many(count: int) -> None:
    sets = np.stack([values(count, seed) for seed in range(3)])
    together = follow(sets, count, START)
    for place, row in enumerate(sets):
        alone = follow(row[None], count, START)
        happens = np.isfinite(alone.time[0])
        assert np.array_equal(happens, np.isfinite(together.time[place]))
        assert np.allclose(alone.time[0, happens], together.time[place, happens], atol=ROUNDING_PX)
        states = together.states[:, place, happens]
        assert np.allclose(alone.states[:, 0, happens], states, atol=ROUNDING_PX)


def test_a_motion_that_ends_has_no_further_events() -> None:
    paths = follow(values(200)[None], 200, START)
    assert np.isfinite(paths.time[0, :20]).all()
    assert np.isinf(paths.time[0, -1])


def test_slow_collisions_lose_a_smaller_share_of_their_speed() -> None:
    at = values(0)
    paths = follow(at[None], 12, START)
    arriving, leaving = paths.before[:, 0, 1:], paths.states[:, 0, 1:]
    closing, opening = (
        np.where(np.arange(12) % 2 == 1, state[3], state[1] - state[3])
        for state in (arriving, leaving)
    )
    usual = at[[Column.BODIES, Column.BOUNCE] * 6]
    expected = usual + at[Column.SPEED] * (0.5 - closing / at[Column.HEAVY_RATE])
    assert np.allclose(-opening / closing, expected, atol=ROUNDING_PX)


@pytest.mark.parametrize(("count", "most"), [(26, 60), (69, 60)])
def test_collisions_after_those_that_were_fitted_leave_these_as_they_are(
    count: int, most: int
) -> None:
    """Of long bursts neighbours share a deviation: of more collisions they would be others."""
    sets = values(min(count, most))[None]
    sets[:, [Column.BODIES, Column.BOUNCE]] = 1.0
    sets[:, Column.LIGHTNESS] = -np.log(700.0)
    fitted, beyond = follow(sets, count, START), follow(sets, count + 12, START, fitted=count)
    assert np.isfinite(fitted.time[0, :40]).all()
    assert np.array_equal(fitted.time, beyond.time[:, : count + 1])


@pytest.mark.parametrize("column", range(FIRST_DEVIATION + 26))
def test_derivatives_are_those_of_the_motion(column: int) -> None:
    at = values(26)
    step = np.zeros_like(at)
    step[column] = STEP * (1e-3 if column == Column.HEAVY_PULL else 1.0)
    above, below = measured(at + step), measured(at - step)
    differences = [(a - b) / (2 * step[column]) for a, b in zip(above, below, strict=True)]
    for exact, difference in zip(derivatives(at), differences, strict=True):
        scale = np.abs(difference).max() + np.abs(exact).max()
        assert np.allclose(exact[:, column], difference, atol=DERIVATIVE_SHARE * max(scale, 1e-9))


@pytest.mark.parametrize("column", range(FIRST_DEVIATION + 12))
def test_velocities_before_a_collision_change_as_those_of_the_motion(column: int) -> None:
    at = values(12)
    step = np.zeros_like(at)
    step[column] = STEP * (1e-3 if column == Column.HEAVY_PULL else 1.0)
    above, below = (motion(at + side * step).before[[1, 3], 0, 1:] for side in (1, -1))
    tangents, paths = tangents_of(motion(at), at), motion(at)
    heavy, _, ball, _ = paths.before[:, 0, 1:]
    rate, rest, ball_rate, decay, ball_rest = paths.laws[:, 0]
    ball_velocity = paths.before[3, 0, 1:]
    slowing = 2 * decay * ball_velocity - decay**2 * (ball_rest - ball)
    pulls = [rate**2 * (rest - heavy), ball_rate**2 * (ball_rest - ball) - slowing]
    # A tangent is taken at a fixed time; the collision moves, and the pull acts for longer.
    exact = tangents.arriving[:, [1, 3], column].T + pulls * tangents.time[:, column]
    difference = (above - below) / (2 * step[column])
    scale = np.abs(difference).max() + np.abs(exact).max()
    assert np.allclose(exact, difference, atol=DERIVATIVE_SHARE * max(scale, 1e-9))


def measured(at: Floats) -> tuple[Floats, Floats, Floats]:
    paths = motion(at)
    sampled = sample(paths, at[None], FRAME + at[Column.SKIP])
    return sampled.ball[0], sampled.heavy[0], paths.time[0, 1:]


def derivatives(at: Floats) -> tuple[Floats, Floats, Floats]:
    paths = motion(at)
    tangents = tangents_of(paths, at)
    ball, heavy = sampled_tangents(sample(paths, at[None], FRAME), tangents, at)
    return ball, heavy, tangents.time


def motion(at: Floats) -> Paths:
    return follow(at[None], len(at) - FIRST_DEVIATION, START)
