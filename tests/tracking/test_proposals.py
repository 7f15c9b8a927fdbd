"""What is proposed as a body: what makes a fair share of all that changes."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from count_video.tracking.corners import Trajectories
from count_video.tracking.paths import Rough, direction_deg
from count_video.tracking.proposals import CHANGE_SHARE, REGIONS_AT_MOST, box_of, propose
from count_video.tracking.regions import find_regions
from count_video.tracking.shape import Shape

FRAMES, SIZE, BODY = 40, (74, 320), 24
"""Pictures, their height and width, and the side of a square body, in px."""
BRIGHT = 150
"""Grey levels by which it stands out."""
STANDS = np.zeros((FRAMES, 2))
NO_CORNERS = Trajectories(np.empty((0, FRAMES, 2), np.float32), np.empty(0, np.bool_))


def pictures(levels: int) -> list[NDArray[np.uint8]]:
    """Two squares that move on one above the other: a bright one, and one of so many levels."""
    drawn = []
    for k in range(FRAMES):
        picture = np.full(SIZE, 80, np.uint8)
        picture[4 : 4 + BODY, 10 + 5 * k :][:, :BODY] += np.uint8(BRIGHT)
        picture[46 : 46 + BODY, 250 - 5 * k :][:, :BODY] += np.uint8(levels)
        drawn.append(picture)
    return drawn


@pytest.mark.parametrize("levels", [BRIGHT, BRIGHT // 10])
def test_each_of_two_bodies_is_proposed_however_faint_one_is(levels: int) -> None:
    regions = find_regions(pictures(levels))
    proposed = propose(NO_CORNERS, regions, STANDS, regions.all_change)
    assert len(proposed) == 2


def test_thick_threads_on_which_a_body_hangs_are_no_part_of_its_region() -> None:
    top, thread = 40, 5  # wider than an opening takes away
    hanging = [np.full(SIZE, 80, np.uint8) for _ in range(FRAMES)]
    for k, picture in enumerate(hanging):
        left = 10 + 5 * k
        picture[top : top + BODY, left : left + BODY] += np.uint8(BRIGHT)
        picture[:top, left : left + thread] += np.uint8(BRIGHT)
    for k, boxes in enumerate(find_regions(hanging).boxes):
        assert boxes.tolist() == [[10 + 5 * k, top, BODY, BODY]]


def test_of_many_things_that_move_those_that_change_most_are_proposed() -> None:
    height, small, since = 12 * REGIONS_AT_MOST + 2 * BODY, 6, FRAMES // 3
    drawn = [np.full((height, SIZE[1]), 80, np.uint8) for _ in range(FRAMES)]
    for k, picture in enumerate(drawn):
        for top in range(0, 12 * REGIONS_AT_MOST, 12):
            picture[top : top + small, 5 + 5 * k :][:, :small] += np.uint8(BRIGHT // 3)
        if k >= since:  # seen in fewer pictures than all the others
            picture[-BODY - 4 : -4, 10 + 5 * k :][:, :BODY] += np.uint8(BRIGHT)
    regions = find_regions(drawn)
    proposed = propose(NO_CORNERS, regions, STANDS, regions.all_change)
    assert len(proposed) == REGIONS_AT_MOST
    assert np.isfinite(proposed[0].path_px[:, 0]).sum() == FRAMES - since


def test_what_makes_next_to_nothing_of_all_that_changes_is_no_body() -> None:
    regions = find_regions(pictures(levels=BRIGHT))
    both = propose(NO_CORNERS, regions, STANDS, regions.all_change)
    more = 2 * max(regions.change(one.path_px, box_of(one)) for one in both) / CHANGE_SHARE
    assert not propose(NO_CORNERS, regions, STANDS, more)


def test_most_paths_say_how_the_bodies_move_and_not_the_longest_one() -> None:
    ways = [(30.0, 1.0), (12.0, 0.0), (20.0, 0.5), (60.0, 160.0)]
    box, fence = (0.0, 0.0, 9.0, 9.0), (-np.inf, np.inf)
    paths = [np.outer(np.arange(FRAMES) / FRAMES, way) for way in ways]

    assert abs(direction_deg([Rough(path, box, fence, Shape(path, box)) for path in paths])) < 20.0


def test_regions_say_nothing_of_the_direction_where_corners_show_bodies() -> None:
    box, fence = (0.0, 0.0, 9.0, 9.0), (-np.inf, np.inf)
    body, thread = (np.outer(np.arange(FRAMES) / FRAMES, way) for way in ((12, 0), (0, 80)))
    regions = [Rough(thread, box, fence, Shape(thread, box), blurred=True, sure=False)] * 3

    assert abs(direction_deg([Rough(body, box, fence, Shape(body, box)), *regions])) < 20.0
    assert abs(direction_deg(regions)) > 70.0
