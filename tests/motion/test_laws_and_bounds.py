from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from filmed_trials import PX_PER_M, FilmedTrial, Filming, film, make_track, part

from count_video.motion.seen import seen_collisions
from count_video.physics.setup import Setup
from count_video.reasons import LEFT_TO_THE_FIT, Cause
from count_video.records import BodyTrack, Track

SETUP = Setup(heavy_mass_kg=0.0105 * 16, wall_gap_m=0.03)
FILMING = Filming(600.0, 0.04, tail_frames=150)


def trial(filming: Filming = FILMING) -> FilmedTrial:
    return film(SETUP, filming)


def places(track: Track) -> list[tuple[str, float]]:
    found = seen_collisions(track)
    return [(c.kind, round(c.frame, 3)) for c in found.collisions[: found.burst]]


def test_the_mirrored_track_shows_the_same() -> None:
    assert places(trial(replace(FILMING, wall_side="right")).track) == places(trial().track)


@pytest.mark.parametrize("shift_px", [-3000.0, 0.0, 5000.0])
def test_where_the_picture_begins_makes_no_difference(shift_px: float) -> None:
    assert places(trial(replace(FILMING, shift_px=shift_px)).track) == places(trial().track)


def test_scale_of_positions_makes_no_difference() -> None:
    larger = replace(FILMING, px_per_m=2 * PX_PER_M, noise_px=2 * FILMING.noise_px)

    assert places(trial(larger).track) == places(trial().track)


@pytest.mark.parametrize("stretch", [1.5, 3.0])
def test_a_higher_rate_stretches_the_frames_alone(stretch: float) -> None:
    faster = film(SETUP, replace(FILMING, capture_fps=stretch * FILMING.capture_fps))

    found = seen_collisions(faster.track)

    assert [c.kind for c in found.collisions[: found.burst]] == list(faster.kinds)


def test_a_few_frames_not_seen_change_no_count() -> None:
    whole = trial()
    gone = (int(whole.frames[0]) - 12, int(whole.frames[-1]) + 20)
    track = replace(whole.track, ball=hidden(whole.track.ball, gone))

    assert [kind for kind, _ in places(track)] == list(whole.kinds)


def hidden(body: BodyTrack, begins: tuple[int, ...]) -> BodyTrack:
    place = body.position_px.copy()
    for begin in begins:
        place[begin : begin + 5] = np.nan
    return replace(body, position_px=place)


def test_a_clip_that_starts_after_the_first_collision_says_so() -> None:
    whole = trial()

    found = seen_collisions(part(whole.track, int(whole.frames[0]) + 8))

    assert any(
        reason.cause in {Cause.STARTS_MOVING, Cause.STARTS_LATE} for reason in found.shortcomings
    )


def test_a_clip_that_ends_within_the_burst_says_so() -> None:
    whole = trial()
    middle = int((whole.frames[4] + whole.frames[5]) / 2)

    found = seen_collisions(part(whole.track, 0, middle))

    assert any(reason.cause in LEFT_TO_THE_FIT for reason in found.shortcomings)


@pytest.mark.parametrize("share", [0.2, 0.5, 0.8])
def test_a_cylinder_that_equal_masses_brought_to_rest_has_not_turned_back(share: float) -> None:
    whole = film(Setup(heavy_mass_kg=0.0105, wall_gap_m=0.02), Filming(capture_fps=240.0))
    wall, last = whole.frames[1], whole.frames[2]
    found = seen_collisions(part(whole.track, 0, int(wall + share * (last - wall))))
    assert found.shortcomings


def test_collisions_after_the_cylinder_turned_back_are_kept_apart() -> None:
    whole = trial(replace(FILMING, tail_frames=1500))
    assert len(whole.motion.collisions) > whole.motion.count

    found = seen_collisions(whole.track)

    assert found.burst == whole.motion.count
    assert len(found.collisions) > found.burst


def test_jitter_at_rest_is_no_collision() -> None:
    still = np.full(400, 0.03)

    found = seen_collisions(make_track(still, still + 0.06, 0.04, Filming(600.0, 0.1)))

    assert found.collisions == ()
    assert found.burst == 0


def test_a_collision_that_no_picture_shows_follows_from_the_flights_and_is_not_seen() -> None:
    whole = trial()
    number = whole.kinds.index("wall", 3)
    begin, end = whole.frames[number - 1] + 3, whole.frames[number + 1] - 3
    hole = (whole.track.frame > begin) & (whole.track.frame < end)
    place = np.where(hole, np.nan, whole.track.ball.position_px)
    track = replace(whole.track, ball=replace(whole.track.ball, position_px=place))

    found = seen_collisions(track)

    assert found.burst == whole.motion.count
    assert [one.seen for one in found.collisions].index(False) == number
    assert found.shown == whole.motion.count - 1


def test_a_ball_that_swings_back_before_the_wall_has_not_struck_it() -> None:
    setup = Setup(heavy_mass_kg=0.0143, wall_gap_m=0.068, bodies_gap_m=0.0034, release_m=0.0503)
    for seed in range(10):
        swung = film(setup, Filming(240.0, 0.08), seed)
        assert "wall" not in swung.kinds

        assert [kind for kind, _ in places(swung.track)] == list(swung.kinds)
