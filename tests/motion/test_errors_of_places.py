"""Stated uncertainties cover how places scatter about the flights."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from filmed_trials import Filming, film
from free_paths import alone, between_stops, body, noisy

from count_video.motion.errors_of_places import Errors
from count_video.motion.meeting import seen_impacts
from count_video.motion.seen import seen_collisions, with_errors
from count_video.physics.setup import Setup
from count_video.records import BodyTrack, Floats, Track

LIGHT_KG = 0.0105
NOISE_PX = 0.08
STATED_PX = NOISE_PX / 4
AGREEMENT = 0.25
"""Some 150 frames know a standard deviation to 0.06; if errors may last for some frames, to half
as well; twice that is allowed."""
HELD_FRAMES = 2


def trial(noise_px: float, seed: int) -> Track:
    """A trial with noise, whose uncertainties are understated."""
    track = film(Setup(heavy_mass_kg=16 * LIGHT_KG), Filming(960.0, noise_px=noise_px), seed).track
    return stating(track, np.full(len(track.frame), STATED_PX))


def stating(track: Track, sigma_px: Floats) -> Track:
    assert track.heavy is not None
    ball, heavy = (replace(one, sigma_px=sigma_px) for one in (track.ball, track.heavy))
    return replace(track, ball=ball, heavy=heavy)


def grown(track: Track) -> list[BodyTrack]:
    """Both bodies with the uncertainties that the fit of all contacts finds."""
    found = with_errors(track, seen_collisions(track).errors)
    assert found.heavy is not None
    return [found.ball, found.heavy]


@pytest.mark.parametrize("seed", range(4))
def test_understated_uncertainties_grow_to_the_noise_of_the_track(seed: int) -> None:
    for one in grown(trial(NOISE_PX, seed)):
        assert one.sigma_px == pytest.approx(np.full(len(one.sigma_px), NOISE_PX), rel=AGREEMENT)


@pytest.mark.parametrize("seed", range(4))
def test_errors_that_last_for_some_frames_are_covered(seed: int) -> None:
    track = trial(0.0, seed)
    frames = len(track.frame)
    new = np.random.default_rng(seed).normal(0.0, NOISE_PX, (2, frames // HELD_FRAMES + 1))
    held = np.repeat(new, HELD_FRAMES, axis=1)[:, :frames]
    assert track.heavy is not None
    ball, heavy = (
        replace(one, position_px=one.position_px + error)
        for one, error in zip((track.ball, track.heavy), held, strict=True)
    )

    for one in grown(replace(track, ball=ball, heavy=heavy)):
        assert one.sigma_px == pytest.approx(np.full(frames, NOISE_PX), rel=2 * AGREEMENT)


def test_the_same_variance_is_added_in_all_frames() -> None:
    track = trial(NOISE_PX, 0)
    white = np.where(track.frame % 2 == 0, 0.5, 1.0) * STATED_PX

    for one in grown(stating(track, white)):
        added = one.sigma_px**2 - white**2
        assert added == pytest.approx(np.full(len(added), added[0]))
        assert added[0] == pytest.approx(NOISE_PX**2, rel=2 * AGREEMENT)


def test_uncertainties_that_cover_the_noise_stay() -> None:
    track = trial(NOISE_PX, 0)
    white = np.full(len(track.frame), 2 * NOISE_PX)

    for one in grown(stating(track, white)):
        assert one.sigma_px.tolist() == white.tolist()


def test_what_was_not_seen_stays_unknown() -> None:
    track = trial(NOISE_PX, 0)
    ball = replace(
        track.ball, position_px=track.ball.position_px.copy(), sigma_px=track.ball.sigma_px.copy()
    )
    ball.position_px[5:12] = ball.sigma_px[5:12] = np.nan

    shown = grown(replace(track, ball=ball))[0]

    assert np.flatnonzero(np.isnan(shown.sigma_px)).tolist() == list(range(5, 12))


def test_one_body_alone_has_its_own() -> None:
    place, _ = between_stops(3.0, 150.0, 400)
    track = alone(noisy(place, NOISE_PX))
    track = replace(track, ball=replace(track.ball, sigma_px=np.full(400, STATED_PX)))

    shown = with_errors(track, seen_impacts(track).errors)

    assert shown.heavy is None
    assert shown.ball.sigma_px == pytest.approx(np.full(400, NOISE_PX), rel=AGREEMENT)


def test_where_flights_tell_nothing_third_differences_do() -> None:
    place = noisy(np.zeros(400), NOISE_PX)
    track = replace(alone(place), ball=replace(body(place), sigma_px=np.full(400, STATED_PX)))

    shown = with_errors(track, ())

    assert shown.ball.sigma_px == pytest.approx(np.full(400, NOISE_PX), rel=AGREEMENT)


def test_each_body_has_its_own() -> None:
    track = trial(NOISE_PX, 0)
    ball, heavy = (Errors(size**2, np.zeros(4)) for size in (0.2, 0.5))

    shown = with_errors(track, (ball, heavy))

    assert shown.heavy is not None
    assert shown.ball.sigma_px == pytest.approx(np.full(len(track.frame), 0.2))
    assert shown.heavy.sigma_px == pytest.approx(np.full(len(track.frame), 0.5))
