from __future__ import annotations

import numpy as np
import pytest

from count_video.records import Floats
from count_video.tracking.certainty import stated_sigmas

FRAMES = 400
NOISE_PX = 0.06
AGREEMENT = 0.2
"""So many frames know a standard deviation to 0.04, and to twice that if errors may last."""
STICKY_FRAMES = 2
CLOCK = np.arange(float(FRAMES))


def bouncing(frames: int = FRAMES) -> Floats:
    """A body that bounces every 40 frames, on a path that gravity bends."""
    time = np.arange(float(frames))
    return 2.0 * np.abs((time % 80.0) - 40.0) + 0.004 * (time % 40.0 - 20.0) ** 2


def approaching() -> Floats:
    """A slow body on a swing: its path bends and never turns."""
    time = np.arange(float(FRAMES)) - FRAMES / 2
    return 300.0 + 80.0 * np.sin(0.003 * time)


def stated(ball: Floats, heavy: Floats, white: float) -> list[Floats]:
    return stated_sigmas(CLOCK, [ball, heavy], [np.full(FRAMES, white)] * 2)


@pytest.mark.parametrize("seed", range(4))
def test_understated_uncertainties_grow_to_the_noise_of_the_track(seed: int) -> None:
    ball, heavy = np.random.default_rng(seed).normal(0.0, NOISE_PX, (2, FRAMES))

    grown = stated(bouncing() + ball, approaching() + heavy, NOISE_PX / 4)

    for sigma in grown:
        assert sigma == pytest.approx(np.full(FRAMES, NOISE_PX), rel=AGREEMENT)


@pytest.mark.parametrize("seed", range(4))
def test_errors_that_last_for_some_frames_are_covered(seed: int) -> None:
    held = np.random.default_rng(seed).normal(0.0, NOISE_PX, (2, FRAMES // STICKY_FRAMES + 1))
    ball, heavy = np.repeat(held, STICKY_FRAMES, axis=1)[:, :FRAMES]

    grown = stated(bouncing() + ball, approaching() + heavy, NOISE_PX / 4)

    for sigma in grown:
        assert sigma == pytest.approx(np.full(FRAMES, NOISE_PX), rel=2 * AGREEMENT)


def test_motion_is_not_taken_for_noise() -> None:
    rng = np.random.default_rng(5)
    swing = 60.0 * np.sin(CLOCK / 25.0)
    pushed = 200.0 + np.where(CLOCK < 200, -0.2 * CLOCK, -40 + 0.5 * (CLOCK - 200))
    noise = rng.normal(0.0, NOISE_PX, (2, FRAMES))

    grown = stated(swing + noise[0], pushed + noise[1], NOISE_PX / 4)

    for sigma in grown:
        assert sigma == pytest.approx(np.full(FRAMES, NOISE_PX), rel=AGREEMENT)


def test_a_contact_without_a_turn_ends_a_flight() -> None:
    noise = np.random.default_rng(1).normal(0.0, NOISE_PX, (2, FRAMES))
    ball = np.where(CLOCK < 200, 0.9 * CLOCK, 180.0 + 0.2 * (CLOCK - 200))
    heavy = 200.0 + np.where(CLOCK < 200, 0.3 * CLOCK, 60.0 + 0.4 * (CLOCK - 200))

    grown = stated(ball + noise[0], heavy + noise[1], NOISE_PX / 4)

    for sigma in grown:
        assert sigma == pytest.approx(np.full(FRAMES, NOISE_PX), rel=AGREEMENT)


@pytest.mark.parametrize("rest", [120, 1000])
def test_however_long_a_body_rests_its_errors_in_motion_are_covered(rest: int) -> None:
    ball = bouncing() + np.random.default_rng(0).normal(0.0, NOISE_PX, FRAMES)
    ball = np.concatenate([np.full(rest, ball[0]), ball])
    heavy = 400.0 - 0.1 * np.arange(float(len(ball)))

    grown = stated_sigmas(
        np.arange(float(len(ball))), [ball, heavy], [np.full(len(ball), NOISE_PX / 4)] * 2
    )

    assert grown[0] == pytest.approx(np.full(len(ball), NOISE_PX), rel=AGREEMENT)


def test_the_same_variance_is_added_in_all_frames() -> None:
    white = np.where(CLOCK % 2 == 0, 0.01, 0.02)
    ball = bouncing() + np.random.default_rng(0).normal(0.0, NOISE_PX, FRAMES)

    grown = stated_sigmas(CLOCK, [ball, approaching()], [white, white])

    added = grown[0] ** 2 - white**2
    assert added == pytest.approx(np.full(FRAMES, added[0]))
    assert added[0] == pytest.approx(NOISE_PX**2, rel=2 * AGREEMENT)


def test_uncertainties_that_cover_the_noise_stay() -> None:
    ball = bouncing() + np.random.default_rng(0).normal(0.0, NOISE_PX, FRAMES)

    assert stated(ball, approaching(), 2 * NOISE_PX)[0].tolist() == [2 * NOISE_PX] * FRAMES


def test_what_was_not_seen_stays_unknown() -> None:
    ball = bouncing() + np.random.default_rng(0).normal(0.0, NOISE_PX, FRAMES)
    white = np.full(FRAMES, NOISE_PX / 4)
    ball[100:110] = white[100:110] = np.nan

    grown = stated_sigmas(CLOCK, [ball, approaching()], [white, white])[0]

    assert np.flatnonzero(np.isnan(grown)).tolist() == list(range(100, 110))


def test_copies_among_even_pictures_are_no_errors() -> None:
    noise = np.random.default_rng(2).normal(0.0, NOISE_PX, (2, FRAMES))
    shown = CLOCK + CLOCK // 5  # a copy, left out of the track, after every fifth picture

    grown = stated_sigmas(
        shown, [bouncing() + noise[0], approaching() + noise[1]], [np.full(FRAMES, 0.01)] * 2
    )

    for sigma in grown:
        assert sigma == pytest.approx(np.full(FRAMES, NOISE_PX), rel=AGREEMENT)


@pytest.mark.parametrize("frames", [0, 1, 12])
def test_too_short_a_track_shows_nothing(frames: int) -> None:
    white = np.full(frames, 0.01)

    grown = stated_sigmas(
        np.arange(float(frames)), [bouncing(frames), bouncing(frames)], [white, white]
    )

    assert [sigma.tolist() for sigma in grown] == [white.tolist()] * 2


def test_of_two_flights_one_that_holds_a_release_is_no_measure() -> None:
    time = np.arange(120.0)
    # Held for 30 frames, let go, and turned round by an impact at frame 60.
    swing = np.where(time < 30, 0.0, 0.02 * (time - 30.0) ** 2)
    heavy = 300.0 - np.where(time < 60, swing, 18.0 - 1.0 * (time - 60.0))
    ball = 100.0 - np.where(time < 60, 0.0, 0.5 * (time - 60.0))
    noise = np.random.default_rng(2).normal(0.0, NOISE_PX, (2, len(time)))

    grown = stated_sigmas(time, [ball + noise[0], heavy + noise[1]], [np.full(120, 0.01)] * 2)

    assert grown[1] == pytest.approx(np.full(120, NOISE_PX), rel=2 * AGREEMENT)


def test_a_calm_rest_is_no_measure_of_the_one_flight_that_follows() -> None:
    time = np.arange(120.0)
    # An encoder shows the same picture of a ball at rest, again and again.
    noise = np.random.default_rng(4).normal(0.0, NOISE_PX, (2, len(time)))
    ball = 100.0 - np.where(time < 40, 0.0, 0.5 * (time - 40.0) + noise[0])
    heavy = 300.0 - np.where(time < 40, 2.0 * time, 80.0 - 0.5 * (time - 40.0))

    grown = stated_sigmas(time, [ball, heavy + noise[1]], [np.full(120, 0.01)] * 2)

    assert grown[0] == pytest.approx(np.full(120, NOISE_PX), rel=2 * AGREEMENT)
