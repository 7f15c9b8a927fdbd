"""A template is followed where its body is, and not to scenery that is like it."""

from __future__ import annotations

import numpy as np
import pytest
from drawn import texture
from numpy.typing import NDArray

from count_video.records import Floats
from count_video.tracking import following
from count_video.tracking.background import Background
from count_video.tracking.following import Clip, Followed, follow
from count_video.tracking.learning import Body
from count_video.tracking.light import Light
from count_video.tracking.template import make_template, piece_at

Luma = NDArray[np.uint8]

SIZE = 90, 400
SIDE, TOP = 40, 25
STEP_PX = 4.0
FRAMES = np.arange(60)
LEAVES = 40
"""The body is in the picture for so many frames."""
LIKE_X = 300
"""Where something like it stands."""
PLACED_PX = 0.1
"""A step of the registration below this ends it."""


BODY = texture(2, (SIDE, SIDE), 20, 230)


def scenery(likeness: float) -> Luma:
    """What stands still: something that shares a part of the body's pattern."""
    behind = texture(1, SIZE, 90, 130)
    other = texture(3, (SIDE, SIDE), 20, 230)
    like = likeness * BODY + (1 - likeness) * other
    behind[TOP : TOP + SIDE, LIKE_X : LIKE_X + SIDE] = np.rint(like)
    return behind


def body_x(frame: int) -> float:
    return 100.0 + STEP_PX * np.sin(frame / 3.0) * 5


def pictures(behind: Luma) -> list[Luma]:
    seen = []
    for frame in FRAMES.tolist():
        picture = behind.copy()
        if frame < LEAVES:
            x = round(body_x(frame))
            picture[TOP : TOP + SIDE, x : x + SIDE] = BODY
        seen.append(picture)
    return seen


def clip(behind: Luma, shown: list[Luma]) -> Clip:
    every, still = np.arange(len(shown)), np.zeros((len(shown), 2))
    return Clip(shown, every, every, Background(behind, still, [Light()] * len(shown)), still)


def body_along(path: Floats) -> Body:
    """The body, learnt from the pictures in which its path is known."""
    whole = piece_at(BODY, 0.0, 0.0, (SIDE, SIDE))
    template = make_template(whole, np.ones((SIDE, SIDE), np.float32))
    learnt = np.flatnonzero(np.isfinite(path[:, 0]))
    return Body(template, (0.0, 0.0, SIDE - 1.0, SIDE - 1.0), False, path, learnt, 1.0)


def followed(behind: Luma, shown: list[Luma]) -> Followed:
    sighted, path = np.arange(0, LEAVES, 4), np.full((len(shown), 2), np.nan)
    path[sighted] = [(round(body_x(frame)), TOP) for frame in sighted]
    return follow(clip(behind, shown), body_along(path))


@pytest.mark.parametrize("likeness", [0.5, 0.6])
def test_a_body_that_is_gone_is_not_found_in_scenery_like_it(likeness: float) -> None:
    behind = scenery(likeness)
    seen = followed(behind, pictures(behind))
    rounded = [round(body_x(frame)) for frame in range(LEAVES)]
    assert np.abs(seen.x_px[:LEAVES] - rounded).max() < PLACED_PX
    assert np.isnan(seen.x_px[LEAVES:]).all()


def test_without_the_background_it_would_be() -> None:
    behind = scenery(0.6)
    seen = followed(texture(1, SIZE, 90, 130), pictures(behind))
    assert np.abs(seen.x_px[LEAVES:] - LIKE_X)[np.isfinite(seen.x_px[LEAVES:])].max() < PLACED_PX
    assert np.isfinite(seen.x_px[LEAVES:]).any()


def test_a_body_at_rest_that_was_taken_for_background_is_found() -> None:
    behind = texture(1, SIZE, 90, 130)
    shown = pictures(behind)
    resting = behind.copy()
    resting[TOP : TOP + SIDE, LIKE_X : LIKE_X + SIDE] = BODY
    seen = followed(resting, [*shown[:LEAVES], *[resting] * (len(FRAMES) - LEAVES)])
    at_rest = seen.x_px[LEAVES:]
    assert np.abs(at_rest[np.isfinite(at_rest)] - LIKE_X).max() < PLACED_PX
    assert np.isfinite(at_rest).any()


STEEP = 400, 400


def followed_falling(
    tops: list[int],
    sighted: int,
    hidden: range = range(0),
    decoy: tuple[Luma, list[int]] | None = None,
) -> Followed:
    """Follow a body down the picture, known in its first frames, of which some do not show it.

    ``decoy`` is something like it, and where it is in the frames in which the body is not known.
    """
    behind = texture(3, STEEP, 60, 90)
    shown = []
    for frame, top in enumerate(tops):
        picture = behind.copy()
        if frame not in hidden:
            picture[top : top + SIDE, SIDE : 2 * SIDE] = BODY
        if decoy is not None and frame >= sighted:
            other = decoy[1][frame - sighted]
            picture[other : other + SIDE, SIDE : 2 * SIDE] = decoy[0]
        shown.append(picture)
    path = np.full((len(tops), 2), np.nan)
    path[:sighted] = [(SIDE, top) for top in tops[:sighted]]
    return follow(clip(behind, shown), body_along(path))


def test_a_lost_body_is_found_where_its_own_motion_took_it() -> None:
    hidden = range(12, 16)
    tops = [round(10 + frame**2 / 4) for frame in range(20)]

    seen = followed_falling(tops, 8, hidden)

    assert np.flatnonzero(np.isnan(seen.y_px)).tolist() == list(hidden)
    assert seen.y_px[hidden.stop :] == pytest.approx(np.array(tops[hidden.stop :]), abs=PLACED_PX)


def test_a_body_in_free_fall_needs_no_search(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(following, "likely_places", lambda *_: [])
    # By the last, constant velocity is wrong by more than a fit can mend.
    tops = [10 + 4 * frame**2 for frame in range(9)]

    seen = followed_falling(tops, 3)

    assert seen.y_px == pytest.approx(np.array(tops), abs=PLACED_PX)


def test_the_body_comes_before_what_is_nearer_and_less_like_it() -> None:
    # It bounces; where it would have been without, something shares most of its pattern.
    down = [10, 55, 100, 145]
    tops = [*down, *reversed(down[:-1])]
    like = np.rint(0.6 * BODY + 0.4 * texture(3, (SIDE, SIDE), 20, 230)).astype(np.uint8)

    seen = followed_falling(tops, len(down), decoy=(like, [190, 235, 280]))

    assert seen.y_px == pytest.approx(np.array(tops), abs=PLACED_PX)
