from __future__ import annotations

import numpy as np

from count_video.tracking.patches.surroundings import filled_in, without_resting

SHAPE = (60, 120)
SIDE = slice(20, 40)
NOISE_LEVELS = 5.0


def rail() -> np.ndarray:
    """A wall with a brighter rail along the bottom of where bodies stand."""
    picture = np.full(SHAPE, 100.0, dtype=np.float32)
    picture[38:44] = 140.0
    return picture


def test_a_body_that_rests_most_of_the_time_gives_way_to_what_lies_around_it() -> None:
    stack = np.array([rail() for _ in range(50)])
    stack[10:, SIDE, 50:70] = 60.0  # it comes early and stays

    settled = without_resting(stack, np.median(stack, axis=0), NOISE_LEVELS)

    assert float(np.abs(settled - rail()).max()) < 1.0


def test_a_body_that_creeps_where_it_rests_gives_way_to_what_lay_there_at_first() -> None:
    stack = np.array([rail() for _ in range(60)])
    for number in range(3, 60):  # few pictures show the scenery, and fewer agree on its left end
        left = 50 + number // 6
        stack[number, SIDE, left : left + 20] = 60.0 + 5 * (number % 3)

    settled = without_resting(stack, np.median(stack, axis=0), NOISE_LEVELS)

    assert float(np.abs(settled - rail()).max()) < NOISE_LEVELS


def test_a_title_at_the_start_is_no_scenery() -> None:
    stack = np.array([rail() for _ in range(60)])
    stack[:4] = 20.0
    usual = np.median(stack, axis=0)

    settled = without_resting(stack, usual, NOISE_LEVELS)

    assert float(np.abs(settled - rail()).max()) < 1.0


def test_scenery_before_which_a_body_rests_for_a_while_stays() -> None:
    stack = np.array([rail() for _ in range(50)])
    stack[:15, SIDE, 50:70] = 60.0

    settled = without_resting(stack, np.median(stack, axis=0), NOISE_LEVELS)

    assert float(np.abs(settled - rail()).max()) < 1.0


def test_light_that_changes_softly_is_no_body() -> None:
    x = np.arange(SHAPE[1])
    shade = (30 * np.exp(-(((x - 60) / 25.0) ** 2))).astype(np.float32)
    stack = np.array([np.full(SHAPE, 120.0, dtype=np.float32) for _ in range(50)])
    stack[15:] -= shade
    usual = np.median(stack, axis=0)

    settled = without_resting(stack, usual, NOISE_LEVELS)

    assert float(np.abs(settled - usual).max()) < 1.0


def test_what_is_always_hidden_goes_on_as_the_rail_does() -> None:
    unknown = np.zeros(SHAPE, dtype=bool)
    unknown[30:50, 50:60] = True

    filled = filled_in(np.where(unknown, 0, rail()).astype(np.float32), unknown)

    assert float(np.abs(filled - rail()).max()) < 1.0


def test_a_rail_that_is_known_stays_whichever_way_what_hides_it_is_filled_in() -> None:
    unknown = np.zeros(SHAPE, dtype=bool)
    unknown[20:46, 50:60] = True  # as plain across as it is down, but for the rail
    known = rail()
    known[:, 60:] += 2.0

    filled = filled_in(known, unknown, NOISE_LEVELS)

    assert float(np.abs(filled - known).max()) < NOISE_LEVELS
