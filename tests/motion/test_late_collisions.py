"""The last collision of a burst is often slow, and comes long after all the others."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from filmed_trials import RESOLVED_FRAMES, FilmedTrial, Filming, film_motion, part, resolving_fps

from count_video.motion.fitted import Between, fit_burst
from count_video.motion.observations import observe
from count_video.motion.parameters import Knowledge, prior_of
from count_video.motion.rivals import HOPELESS, Rivals
from count_video.motion.seen import SeenCollisions, seen_collisions
from count_video.motion.starting import rough_values
from count_video.physics.setup import Setup
from count_video.physics.simulator import simulate
from tiers import rest_slow

SETUPS = (
    (10, 0.015, 0.99),
    (36, 0.005, 0.98),
    (49, 0.007, 0.98),
    (80, 0.01, 1.0),
    (100, 0.03, 0.99),
)
"""Mass ratios, gaps in metres and restitutions by which the last flight is longer than twice all
those before it."""
RATIOS = (4, 9, 10, 16, 25, 36, 49, 50, 64, 80, 100)
HARD_SEEDS = (0, 1104)
"""Of 250 random trials those for which the search once ended in a local minimum, two collisions
off."""
CUT_FRAMES = 20
"""So long before its last collision a clip ends that does not show it."""
LIKELY = 0.5


def set_up(ratio: float, gap_m: float, bodies: float, wall: float) -> Setup:
    return Setup(
        ratio * 0.002,
        0.002,
        wall_gap_m=gap_m,
        restitution_bodies=bodies,
        restitution_wall=wall,
    )


@cache
def filmed(ratio: float, gap_m: float, restitution: float) -> FilmedTrial:
    motion = simulate(set_up(ratio, gap_m, restitution, restitution))
    trial = film_motion(motion, Filming(resolving_fps(motion, RESOLVED_FRAMES)), 1)
    flights = trial.frames[-1] - trial.frames[-2], trial.frames[-2] - trial.frames[0]
    assert flights[0] > 2 * flights[1]
    return trial


def without_last(trial: FilmedTrial) -> SeenCollisions:
    """What is seen of a trial, but for the last collision."""
    found, before = seen_collisions(trial.track), len(trial.frames) - 1
    return replace(found, collisions=found.collisions[:before], burst=before)


@pytest.mark.parametrize("setup", rest_slow(map(pytest.param, SETUPS), quick=2))
def test_a_late_last_collision_that_was_missed_is_counted(setup: tuple[float, ...]) -> None:
    trial = filmed(*setup)
    fit = fit_burst(trial.track, without_last(trial))
    assert isinstance(fit, Between)
    assert fit.count == len(trial.frames)
    late = fit.collisions[-1]
    assert abs(late.frame - trial.frames[-1]) < 4 * late.frame_sigma


@pytest.mark.parametrize("setup", rest_slow(map(pytest.param, SETUPS), quick=2))
def test_one_after_the_end_of_the_clip_is_foreseen(setup: tuple[float, ...]) -> None:
    trial = filmed(*setup)
    shown = part(trial.track, 0, int(trial.frames[-1]) - CUT_FRAMES)
    fit = fit_burst(shown, without_last(trial))
    assert isinstance(fit, Between)
    assert fit.count == len(trial.frames) - 1
    assert fit.following.get(1, 0.0) > LIKELY


def test_a_motion_that_lacks_its_last_collision_is_also_one_of_one_collision_fewer() -> None:
    motion = simulate(set_up(1.3, 0.026, 1.0, 1.0))  # the ball follows the cylinder slowly
    trial = film_motion(motion, Filming(resolving_fps(motion, RESOLVED_FRAMES)), 1)
    found, known = seen_collisions(trial.track), Knowledge()
    observed, count = observe(trial.track, found), len(trial.frames)
    rough = rough_values(observed, found, known)
    prior = prior_of(rough, known, shows_heavy=True)
    right = Rivals(observed, prior).grow(rough)
    assert right.loss < len(observed.frame)

    rivals = Rivals(observed, prior)
    rivals.add(count + 1, right.values)

    assert rivals.best.count == count
    assert rivals.best.loss < right.loss + 1.0


def drawn(seed: int) -> FilmedTrial:
    rng = np.random.default_rng(seed)
    ratio, gap_m = float(rng.choice(RATIOS)), rng.uniform(0.005, 0.03)
    bodies, wall = rng.uniform(0.97, 1.0), rng.uniform(0.97, 1.0)
    motion = simulate(set_up(ratio, gap_m, bodies, wall))
    fps = resolving_fps(motion, rng.choice([1.0, 2.5, 4.0]))
    return film_motion(motion, Filming(fps, rng.choice([0.03, 0.1])), seed)


@pytest.mark.parametrize("seed", HARD_SEEDS)
def test_the_search_does_not_end_two_collisions_off(seed: int) -> None:
    trial = drawn(seed)
    fit = fit_burst(trial.track, seen_collisions(trial.track))
    assert isinstance(fit, Between)
    assert fit.count == len(trial.frames)


def test_a_heavy_body_that_left_the_picture_comes_back_after_the_burst_only() -> None:
    setup = Setup(
        heavy_mass_kg=1.02 * 0.0105,
        mounting="free",
        wall_gap_m=0.023,
        bodies_gap_m=0.003,
        heavy_velocity_m_s=-0.9,
        restitution_bodies=0.97,
        restitution_wall=0.9,
    )
    trial = film_motion(simulate(setup), Filming(200.0, tail_frames=40))
    heavy = trial.track.heavy
    assert heavy is not None
    left = trial.track.frame > trial.frames[-2] + 40
    gone = replace(heavy, position_px=np.where(left, np.nan, heavy.position_px))

    found = seen_collisions(replace(trial.track, heavy=gone))

    assert trial.frames[-1] > trial.frames[-2] + 80
    assert found.burst == len(trial.frames)
    assert not found.shortcomings


def test_a_ball_that_turns_next_to_the_wall_may_have_struck_it() -> None:
    """It turns half a pixel before it: with one collision more all fits as well."""
    motion = simulate(
        Setup(
            0.084,
            0.0105,
            heavy_thread_m=0.7073,
            light_thread_m=0.7073,
            wall_gap_m=0.0425,
            release_m=0.07125,
            restitution_bodies=0.97657,
            restitution_wall=0.96225,
        )
    )
    filming = Filming(254.0, 0.3, lead_frames=60, tail_frames=100, px_per_m=600.0)
    track = film_motion(motion, filming, 1).track
    observed = observe(track, seen_collisions(track))
    rough = rough_values(observed, seen_collisions(track), Knowledge())
    rivals = Rivals(observed, prior_of(rough, Knowledge(), shows_heavy=True))
    beginning = rivals.grow(rough).values
    as_it_is = rivals.add(motion.count, beginning)
    rivals.climb(beginning)
    more = rivals.fits[motion.count + 1]
    assert more.reached == motion.count + 1
    assert more.loss < as_it_is.loss + HOPELESS
