"""A ball alone shows the whole law of a trial: nothing is seen of the body that strikes it."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from filmed_trials import RESOLVED_FRAMES, FilmedTrial, Filming, film, resolving_fps

from count_video.answers import answer
from count_video.explanations import Explanation
from count_video.motion import fitted as fitted_bursts
from count_video.motion.fitted import Between, fit_burst
from count_video.motion.parameters import Knowledge
from count_video.motion.starting import rough_values
from count_video.motion.struck import struck_ball
from count_video.physics.setup import Setup
from count_video.physics.simulator import simulate
from count_video.reasons import Cause
from count_video.records import Floats, FootageInfo, FootageReport, Track, WallSide
from count_video.scenes import of_one
from count_video.settings import TrialSettings
from tiers import rest_slow

SIGMAS = 4.0
"""Of a dozen numbers none is off by more standard uncertainties, but once in a thousand."""
RATIOS = (4.0, 10.0, 30.0, 100.0)
UNRESOLVED_FRAMES = 1.0
"""At this shortest interval the frames show about half of the collisions."""


def trial(
    ratio: float, side: WallSide = "left", interval: float = RESOLVED_FRAMES, tail: int = 60
) -> FilmedTrial:
    setup = Setup(ratio * 0.002, 0.002, wall_gap_m=0.03, restitution_bodies=0.97)
    fps = resolving_fps(simulate(setup), interval, at_least_fps=120.0)
    return film(setup, Filming(fps, tail_frames=tail, wall_side=side))


def alone(filmed: FilmedTrial) -> Track:
    """Leave the heavy body out, and which side the wall is on."""
    return replace(filmed.track, heavy=None, wall_side="left")


@cache
def fitted(ratio: float, side: WallSide = "left", interval: float = RESOLVED_FRAMES) -> Between:
    shown = struck_ball(alone(trial(ratio, side, interval)))
    assert shown is not None
    fit = fit_burst(*shown)
    assert isinstance(fit, Between)
    return fit


def explained(track: Track, *, seen_only: bool = False) -> Explanation:
    return of_one(track, Knowledge(seen_only=seen_only), lambda _: False)


@pytest.mark.parametrize("side", rest_slow(["left", "right"]))
@pytest.mark.parametrize("ratio", RATIOS)
def test_the_ball_alone_gives_count_times_and_kinds(ratio: float, side: WallSide) -> None:
    filmed, fit = trial(ratio, side), fitted(ratio, side)
    apart = [one.frame - true for one, true in zip(fit.collisions, filmed.frames, strict=True)]

    assert fit.count == len(filmed.frames)
    assert tuple(one.kind for one in fit.collisions) == filmed.kinds
    assert np.all(np.abs(apart) < SIGMAS * np.array([one.frame_sigma for one in fit.collisions]))


@pytest.mark.parametrize("ratio", RATIOS)
def test_it_gives_the_masses_and_the_unseen_velocities(ratio: float) -> None:
    filmed, fit = trial(ratio), fitted(ratio)
    scale = 2000.0 / resolving_fps(filmed.motion, RESOLVED_FRAMES, at_least_fps=120.0)
    true = scale * np.array([one.heavy_after_m_s for one in filmed.motion.burst])
    heavy = [one.velocity_after for one in fit.collisions]
    off = np.array([one.heavy_px_frame for one in heavy]) - true
    sigma = np.array([one.heavy_sigma_px_frame for one in heavy])

    assert abs(fit.mass_ratio.value - ratio) < SIGMAS * fit.mass_ratio.sigma
    assert np.all(np.abs(off) < SIGMAS * sigma)


@pytest.mark.parametrize("ratio", [30.0, 100.0])
def test_collisions_that_no_frame_shows_are_counted(ratio: float) -> None:
    fit = fitted(ratio, interval=UNRESOLVED_FRAMES)

    assert fit.count == len(trial(ratio).frames)
    assert fit.shown < fit.count


@pytest.mark.parametrize("seed", rest_slow(range(4)))
def test_the_count_does_not_hang_on_rounding(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    shown = struck_ball(alone(trial(30.0, interval=UNRESOLVED_FRAMES)))
    rng = np.random.default_rng(seed)

    def nearly(*asked: Any) -> Floats:
        values = rough_values(*asked)
        return values * (1 + 1e-9 * rng.normal(size=values.shape))

    monkeypatch.setattr(fitted_bursts, "rough_values", nearly)
    assert shown is not None
    fit = fit_burst(*shown)

    assert isinstance(fit, Between)
    assert fit.count == len(trial(30.0).frames)


@pytest.mark.parametrize("side", ["left", "right"])
def test_the_wall_stands_where_the_blow_sends_the_ball(side: WallSide) -> None:
    shown = struck_ball(alone(trial(10.0, side)))

    assert shown is not None
    assert shown[0].wall_side == side


def test_what_follows_when_the_heavy_body_comes_back_is_reported_apart() -> None:
    filmed = trial(4.0, tail=700)
    shown = struck_ball(alone(filmed))

    assert shown is not None
    assert len(shown[1].collisions) > shown[1].burst
    assert explained(alone(filmed)).count == len(filmed.frames)


def test_the_explanation_says_that_the_cylinder_is_not_seen() -> None:
    filmed = trial(10.0)
    one = explained(alone(filmed))
    frames = len(filmed.track.frame)
    info = FootageInfo(*(Path("clip"), 640, 240, 0), *(frames, 30.0, None, "unknown"))
    result = answer(one, info, FootageReport(frames, frames, ()), TrialSettings())

    assert (one.scene, one.counts, one.count) == ("wall", True, len(filmed.frames))
    assert [note.cause for note in one.notes] == [Cause.HEAVY_UNSEEN]
    assert any("cylinder could not be followed" in warning for warning in result.warnings)


def test_only_what_is_seen_says_nothing_of_a_body_that_is_not() -> None:
    one = explained(alone(trial(10.0)), seen_only=True)

    assert not one.counts
    assert [reason.cause for reason in one.against] == [Cause.STRUCK]


def struck_by_others(places: list[float], after_px: list[float]) -> Explanation:
    """A ball at rest at the first place is struck there, and at the others on its way back.

    Each blow sends it off at so many px a frame, towards a wall 100 px away that takes a tenth.
    """
    rest, path, place, speed = places[0], [], places[0], 0.0
    blows = list(zip(places, after_px, strict=True))
    for step in range(400 * 50):
        if step % 50 == 0:
            path.append(place)
        if blows and (step == 30 * 50 if len(path) < 32 else speed > 0 and place >= blows[0][0]):
            speed = -blows.pop(0)[1]
        place += speed / 50
        if place < rest - 100.0:
            place, speed = rest - 100.0, -0.9 * speed
    places_px = np.array(path)[: int(np.argmax(np.array(path) > rest + 150.0)) or None]
    places_px += np.random.default_rng(3).normal(0.0, 0.05, len(places_px))
    ball = replace(
        trial(10.0).track.ball, position_px=places_px, sigma_px=np.full(len(places_px), 0.05)
    )
    frame = np.arange(float(len(places_px)))
    return explained(replace(trial(10.0).track, frame=frame, ball=ball, heavy=None))


@pytest.mark.parametrize(
    ("places", "after_px"),
    [
        pytest.param([200.0], [3.0], id="a cue that strikes once"),
        pytest.param([200.0, 170.0], [3.0, 3.0], id="two blows, which any masses explain"),
        pytest.param([200.0] * 6, [3.0] * 6, id="two fixed stops, of which one gives speed"),
        pytest.param([200.0, 150.0, 180.0, 140.0], [3.0, 2.0, 4.0, 3.0], id="a hand that dribbles"),
    ],
)
def test_a_ball_that_anything_else_strikes_is_not_that_of_a_trial(
    places: list[float], after_px: list[float]
) -> None:
    one = struck_by_others(places, after_px)

    assert not one.counts
    assert [reason.cause for reason in one.against] in ([Cause.STRUCK], [Cause.STRUCK_MOVING])
