from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from synthetic_tracks import FilmedTrial, Filming, film

from count_video.answers import answer
from count_video.explanations import Explanation, by_fit, shown_at_wall
from count_video.motion.fitted import Between, fit_burst
from count_video.motion.parameters import (
    MOST_DEVIATIONS,
    Knowledge,
    deviation_places,
)
from count_video.motion.seen import seen_collisions
from count_video.physics.setup import Setup
from count_video.records import FootageInfo, FootageReport, TrialResult
from count_video.settings import TrialSettings
from energies import kept_shares
from tiers import rest_slow

FPS = 1000.0
LIGHT_KG = 0.0105
QUICK = 2500.0
RATIOS = rest_slow([QUICK, 10_000.0])
"""Mass ratios, of bursts of some 157 collisions and of 314."""
PROBABILITIES_OF = {301: 0.01, 303: 0.05, 305: 0.35, 307: 0.3, 309: 0.28, 311: 0.01}


@cache
def filmed(ratio: float) -> FilmedTrial:
    setup = Setup(
        heavy_mass_kg=ratio * LIGHT_KG,
        light_mass_kg=LIGHT_KG,
        wall_gap_m=0.05,
        bodies_gap_m=0.001,
        restitution_bodies=0.998,
        restitution_wall=0.996,
    )
    return film(setup, Filming(FPS, clock_phase=0.3), seed=2)


@cache
def fitted(ratio: float) -> Between:
    track = filmed(ratio).track
    known = Knowledge(FPS, ratio)
    between = fit_burst(track, seen_collisions(track), known)
    assert isinstance(between, Between)
    return between


@pytest.mark.parametrize("ratio", RATIOS)
def test_hundreds_of_collisions_are_counted_where_the_masses_are_known(ratio: float) -> None:
    assert filmed(ratio).shortest_frames < 5 / ratio**0.5
    assert filmed(ratio).count > 3 * ratio**0.5
    assert fitted(ratio).count == filmed(ratio).count


@pytest.mark.parametrize("ratio", RATIOS)
def test_most_of_them_are_called_inferred(ratio: float) -> None:
    inferred = sum(not collision.seen for collision in fitted(ratio).collisions)
    assert inferred > 0.8 * filmed(ratio).count


@pytest.mark.parametrize("ratio", RATIOS)
def test_the_sum_of_the_losses_is_measured(ratio: float) -> None:
    # Each contact's own losses trade off with the other's; together they are what is left.
    true_share = float(kept_shares(filmed(ratio).motion)[-1])
    assert fitted(ratio).energy_kept[-1] == pytest.approx(true_share, rel=0.02)


def test_each_collision_of_a_short_burst_deviates_by_itself() -> None:
    for count in (1, 2, 31, MOST_DEVIATIONS):
        assert np.array_equal(deviation_places(count), np.arange(count))


def test_neighbours_of_a_kind_share_a_deviation_in_a_long_burst() -> None:
    places = deviation_places(314)
    assert len(np.unique(places)) == MOST_DEVIATIONS
    assert np.array_equal(places % 2, np.arange(314) % 2)
    sharing = np.bincount(places)
    assert sharing.max() - sharing.min() <= 1


def explained(count: int, chances: dict[int, float], *, masses_known: bool = True) -> Explanation:
    shown = shown_at_wall(filmed(QUICK).track, seen_collisions(filmed(QUICK).track))
    fit = replace(fitted(QUICK), count=count, probability=chances)
    return by_fit(shown, fit, masses_known=masses_known)


def stated(count: int, chances: dict[int, float], *, masses_known: bool = True) -> TrialResult:
    info = FootageInfo(Path("trial.mp4"), 640, 240, 0, None, 30.0, FPS, "option")
    report = FootageReport(len(filmed(QUICK).track.frame), None, ())
    one = explained(count, chances, masses_known=masses_known)
    return answer(one, info, report, TrialSettings())


def test_a_count_is_given_only_if_it_is_likelier_than_all_others_together() -> None:
    assert not explained(305, PROBABILITIES_OF).counts
    assert not explained(305, {303: 0.3, 305: 0.36, 307: 0.3, 309: 0.04}).counts
    assert explained(305, {303: 0.3, 305: 0.6, 307: 0.1}).counts


def test_counts_of_which_none_is_likelier_than_the_others_are_named_and_none_is_given() -> None:
    count = fitted(QUICK).count
    chances = {count - 2: 0.3, count: 0.36, count + 2: 0.31, count + 4: 0.03}
    result = stated(count, chances)
    assert (result.status, result.count) == ("not_counted", None)
    assert result.reason is not None
    assert all(str(count + step) in result.reason for step in (-2, 0, 2))


def test_a_probable_count_leaves_nothing_open() -> None:
    count = fitted(QUICK).count
    result = stated(count, {count: 0.9, count + 2: 0.1})
    assert (result.status, result.reason) == ("counted", None)


def test_a_count_that_stays_open_is_given_as_a_range_with_what_would_help() -> None:
    chances = dict.fromkeys(range(295, 315, 2), 0.1)
    unknown = stated(305, chances, masses_known=False)
    assert "every count from 295 to 313" in (unknown.reason or "")
    assert "--masses" in (unknown.what_to_do or "")
    wide = dict.fromkeys(range(271, 305, 2), 0.05)
    assert "about 290" in (stated(287, wide).reason or "")
    assert "--masses" not in (stated(305, chances).what_to_do or "")
