"""Outlines that do not meet where the bodies touch show that the ball's width is no measure."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from filmed_trials import Filming, film

from count_video.answers import answer
from count_video.explanations import leaves_doubt, shown_at_wall
from count_video.motion.seen import seen_collisions
from count_video.physics.setup import Setup
from count_video.reasons import Cause
from count_video.records import FootageInfo, FootageReport, Track, TrialResult
from count_video.settings import TrialSettings

BALL_MM = 40.0
CONTACT_PX = 0.3
"""Contacts are known to a few times the noise of the places, 0.05 px."""
INFO = FootageInfo(Path("a.mp4"), 640, 360, 0, None, 30.0, None, "unknown")


@pytest.fixture(scope="module")
def track() -> Track:
    setup = Setup(heavy_mass_kg=0.2, light_mass_kg=0.01, wall_gap_m=0.03, release_m=0.06)
    return film(setup, Filming(capture_fps=960.0)).track


def narrowed(track: Track, share: float) -> Track:
    """Make the ball's outline narrower by a share of its width, from both sides."""
    off = share * track.ball_diameter_px / 2
    ball = track.ball
    narrow = replace(ball, low_edge_px=ball.low_edge_px + off, high_edge_px=ball.high_edge_px - off)
    return replace(track, ball=narrow, ball_diameter_px=track.ball_diameter_px - 2 * off)


def answered(track: Track) -> TrialResult:
    explained = shown_at_wall(track, seen_collisions(track))
    report, settings = FootageReport(100, None, ()), TrialSettings(ball_diameter_mm=BALL_MM)
    return answer(explained, INFO, report, settings)


def test_outlines_that_are_right_meet_and_give_a_scale(track: Track) -> None:
    assert seen_collisions(track).outlines_apart_px == pytest.approx(0.0, abs=CONTACT_PX)
    assert answered(track).millimetres_per_px == pytest.approx(BALL_MM / track.ball_diameter_px)


@pytest.mark.parametrize(("heavy_kg", "capture_fps"), [(1.05, 60.0), (0.5, 240.0)])
def test_where_collisions_are_missed_the_surest_contacts_show_whether_outlines_meet(
    heavy_kg: float, capture_fps: float
) -> None:
    """Next to one that is missed the flights do not lead to where the bodies touched."""
    setup = Setup(heavy_mass_kg=heavy_kg, light_mass_kg=0.01, wall_gap_m=0.03, release_m=0.06)
    trial = film(setup, Filming(capture_fps=capture_fps))
    found = seen_collisions(trial.track)

    assert found.burst < len(trial.frames)
    assert found.outlines_apart_px == pytest.approx(0.0, abs=CONTACT_PX)


@pytest.mark.parametrize("share", [0.15, 0.4, -0.3])
def test_a_ball_of_the_wrong_width_gives_no_scale_but_its_count(track: Track, share: float) -> None:
    wrong = narrowed(track, share)
    result = answered(wrong)
    off = share * track.ball_diameter_px / 2
    assert seen_collisions(wrong).outlines_apart_px == pytest.approx(off, abs=CONTACT_PX)
    assert result.count == answered(track).count
    assert result.millimetres_per_px is None
    assert any("millimetres" in warning for warning in result.warnings)


def test_outlines_further_apart_than_the_bodies_are_long_leave_a_count_to_the_model(
    track: Track,
) -> None:
    assert track.heavy is not None
    small = narrowed(track, 0.6)  # 0.4 of the ball, and as much of the cylinder, further away
    length, off = 0.4 * track.ball_diameter_px, 0.6 * track.ball_diameter_px
    heavy = replace(
        track.heavy, position_px=track.heavy.position_px + off, low_edge_px=0.0, high_edge_px=length
    )
    found = seen_collisions(replace(small, heavy=heavy))

    assert found.outlines_apart_px > 2 * length
    assert Cause.NEVER_TOUCH in [doubt.cause for doubt in found.doubts]
    assert leaves_doubt(found)
