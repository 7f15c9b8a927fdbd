"""A body that others partly hide is registered by what is left of it to be seen."""

from __future__ import annotations

import numpy as np
import pytest
from drawn import texture
from numpy.typing import NDArray

from count_video.tracking.background import Background
from count_video.tracking.following import Clip, Followed, follow
from count_video.tracking.learning import Body
from count_video.tracking.occlusion import unhidden
from count_video.tracking.template import make_template, piece_at

Luma = NDArray[np.uint8]

SIZE = 90, 400
FRAMES = np.arange(80)
TOP = 20
LEFT, RIGHT = (50, 60), (50, 48)
"""Height and width of the two bodies."""
HIDDEN_PX = 20
"""So many columns of the one behind are covered where both are nearest."""
PLACED_PX = 0.1
"""A step of the registration below this ends it."""


BEHIND = texture(1, SIZE, 90, 130)
PATTERNS = texture(2, LEFT, 20, 230), texture(3, RIGHT, 20, 230)


def places() -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Where the bodies begin in each picture; they overlap in the middle of the clip."""
    left = np.rint(80 + 60 * np.sin(np.pi * FRAMES / len(FRAMES)))
    right = left + LEFT[1] - HIDDEN_PX + np.abs(FRAMES - len(FRAMES) / 2)
    return left.astype(np.intp), right.astype(np.intp)


def pictures(front: int) -> list[Luma]:
    shown = []
    for corners in zip(*(place.tolist() for place in places()), strict=True):
        picture = BEHIND.copy()
        for body in (1 - front, front):
            height, width = PATTERNS[body].shape
            picture[TOP : TOP + height, corners[body] : corners[body] + width] = PATTERNS[body]
        shown.append(picture)
    return shown


def body(which: int) -> Body:
    pattern = PATTERNS[which]
    shape = pattern.shape[0], pattern.shape[1]
    template = make_template(piece_at(pattern, 0.0, 0.0, shape), np.ones(shape, np.float32))
    sightings = {k: (float(x), float(TOP)) for k, x in enumerate(places()[which].tolist())}
    return Body(
        template,
        0.0,
        shape[1] - 1.0,
        (0.0, shape[0] - 1.0),
        False,
        sightings,
        tuple(sightings),
        1.0,
    )


@pytest.mark.parametrize("front", [0, 1])
def test_the_one_behind_is_found_by_what_is_not_hidden(front: int) -> None:
    shown = dict(enumerate(pictures(front)))
    background = Background(BEHIND, {}, {})
    clip = Clip(shown, FRAMES, background, np.zeros((len(FRAMES), 2)))
    alone = [follow(clip, body(which)) for which in (0, 1)]
    clear = unhidden(clip, alone)
    truth = places()
    for which in (0, 1):
        assert np.abs(clear[which].x_px - truth[which]).max() < PLACED_PX
    assert clear[front] is alone[front]
    behind = 1 - front
    assert mistakes(alone[behind], truth[behind]) > mistakes(clear[behind], truth[behind])


def mistakes(seen: Followed, truth: NDArray[np.intp]) -> float:
    """Root mean square mistake in units of a px; a picture without a place counts as one px."""
    return float(np.sqrt(np.mean(np.nan_to_num(seen.x_px - truth, nan=1.0) ** 2)))
