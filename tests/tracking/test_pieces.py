"""Pieces of pictures laid upon each other: their brightness, and whose motion explains them."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray
from registering import register

from count_video.records import Floats
from count_video.tracking.background import Background
from count_video.tracking.composite import STEPS, Source, cut_pieces, median_of
from count_video.tracking.cutting import Stage, cut_out
from count_video.tracking.light import Light
from count_video.tracking.registration import CONVERGED_PX

SIZE = 60, 80
DIM = 0.3
"""Share of the usual light: what is white is brightened beyond the steps that a piece holds."""


@pytest.mark.parametrize("luma", [30, 255])
def test_a_dim_picture_is_brightened_up_to_white_at_most(luma: int) -> None:
    behind = Background(np.full(SIZE, 100, np.uint8), np.zeros((1, 2)), [Light(DIM)])
    source = Source([np.full(SIZE, luma, np.uint8)], behind, ())

    seen = cut_pieces(source, np.array([(20.0, 20.0)]), (16, 24), (2, 2)).seen

    brightest = np.iinfo(seen.dtype).max
    assert seen == pytest.approx(min(luma / DIM * STEPS, brightest), abs=1)


# ---- two plain bodies that stand beside each other in most pictures ------------------------------

WIDE = 60, 320
BODY_PX = 20
TOP_PX = 20
PICTURES = 15
OFTEN = 10
"""In so many of the pictures they are NEAR_PX apart."""
NEAR_PX = 6
PATH = np.array([(40.0 + 12 * k, TOP_PX) for k in range(PICTURES)])
BESIDE = PATH + [(BODY_PX + NEAR_PX + 7 * max(0, k - OFTEN + 1), 0) for k in range(PICTURES)]
MARGIN = 20, 50


def before(scene: NDArray[np.uint8]) -> Background:
    """Background of pictures in which the camera stands still and so does the light."""
    return Background(scene, np.zeros((PICTURES, 2)), [Light()] * PICTURES)


def side_by_side(*neighbours: Floats) -> Source:
    """Two plain squares that move over a scene, at one distance in most pictures."""
    scene = np.random.default_rng(3).integers(80, 120, WIDE).astype(np.uint8)
    pictures = [scene.copy() for _ in range(PICTURES)]
    for k, picture in enumerate(pictures):
        for (x, y), level in ((PATH[k], 220), (BESIDE[k], 180)):
            rows, columns = (slice(int(at), int(at) + BODY_PX) for at in (y, x))
            picture[rows, columns] = level
    return Source(pictures, before(scene), (), neighbours)


def around(better: Floats, left_px: int) -> float:
    """Sum over a square and its edges, from where it begins in pieces about the body."""
    top, left = MARGIN[0], MARGIN[1] + left_px
    return float(better[top - 3 : top + BODY_PX + 3, left - 3 : left + BODY_PX + 3].sum())


def test_what_moves_with_a_neighbour_is_explained_better_by_its_motion() -> None:
    pieces = cut_pieces(side_by_side(BESIDE), PATH, (BODY_PX, BODY_PX), MARGIN)

    (better,) = (one() for one in median_of(pieces).theirs)

    assert around(better, 0) < 0 < around(better, BODY_PX + NEAR_PX)


def cut_px(source: Source) -> float:
    stage = Stage(1, (0.0, 0.0), (BODY_PX, BODY_PX), PATH)
    found = cut_out(source, stage, MARGIN, (-np.inf, np.inf))
    assert found is not None
    return found[1].box[2] - found[1].box[0]


def test_a_body_ends_where_what_moves_with_its_neighbour_begins() -> None:
    both_px = 2 * BODY_PX + NEAR_PX

    assert cut_px(side_by_side()) == pytest.approx(both_px, abs=2)
    assert cut_px(side_by_side(BESIDE)) == pytest.approx(BODY_PX, abs=2)


# ---- a plain body on two threads, which also hangs in the background -----------------------------

HANGING = np.array([(100.0 + 2 * k, 60.0) for k in range(PICTURES)])
WIDE_PX, HIGH_PX = 60, 40
THREADS_PX = 15, 45
STUB_PX = 20
"""Of threads that are 60 px long so much may stay: the reach of blurred edges and of an opening."""


def hung(scene: NDArray[np.uint8], left: int, contrast: int) -> NDArray[np.uint8]:
    """Hang a body on two threads of 2 px that go up to the border."""
    picture = scene.copy()
    for at in THREADS_PX:
        picture[:60, left + at : left + at + 2] = 100 + contrast
    picture[60 : 60 + HIGH_PX, left : left + WIDE_PX] = 100 + contrast
    return picture


@pytest.mark.parametrize("contrast", [40, -40])
def test_two_threads_are_no_part_of_a_body(contrast: int) -> None:
    scene = np.full((140, 320), 100, np.uint8)
    pictures = [hung(scene, int(x), contrast) for x, _ in HANGING]
    still = before(hung(scene, 114, contrast))
    stage = Stage(1, (0.0, 0.0), (HIGH_PX, WIDE_PX), HANGING)

    found = cut_out(Source(pictures, still, ()), stage, (60, 60), (-np.inf, np.inf))

    assert found is not None
    assert HIGH_PX <= found[0].shape[0] < HIGH_PX + STUB_PX


def test_thin_lines_within_a_body_are_its_own() -> None:
    scene = np.full((140, 320), 100, np.uint8)
    ends, struts = (0, WIDE_PX - 4), THREADS_PX
    pictures = [scene.copy() for _ in HANGING]
    for picture, (left, top) in zip(pictures, HANGING.astype(int).tolist(), strict=True):
        for at in ends:
            picture[top : top + HIGH_PX // 2, left + at : left + at + 4] = 180
        picture[top : top + HIGH_PX // 2, left + 4 : left + WIDE_PX - 4] = 150
        for at in struts:  # below, it is all struts
            picture[top + HIGH_PX // 2 : top + HIGH_PX, left + at : left + at + 6] = 200
    stage = Stage(1, (0.0, 0.0), (HIGH_PX, WIDE_PX), HANGING)

    found = cut_out(Source(pictures, before(scene), ()), stage, (40, 60), (-np.inf, np.inf))

    assert found is not None
    assert found[0].shape[0] >= HIGH_PX


# ---- a plain body, one end of which passes before something else than usual ----------------------

BRIGHT, WALL, BOARD = 180, 150, 230
BOARD_PX = 150
"""From here on a board stands behind the body: its right end is before it in the last pictures."""
ALONG = np.array([(40.0 + 6 * k, 40.0) for k in range(PICTURES)])
LONG_PX = 50
BLUR_PX = 1.0
NEARLY_PX = -0.5, 1.0
"""So far from its place a body is sought."""


def passing(left_px: float) -> NDArray[np.uint8]:
    """Picture of a body that is plain but for lines along its motion, with blurred edges."""
    fine = np.full((120, 8 * 240), WALL, np.float32)
    fine[:, 8 * BOARD_PX :] = BOARD
    left = round(8 * left_px)
    fine[40 : 40 + HIGH_PX, left : left + 8 * LONG_PX] = BRIGHT
    fine[50:60, left : left + 8 * LONG_PX] = BRIGHT - 60
    whole = cv2.resize(fine, (240, 120), interpolation=cv2.INTER_AREA)
    noise = np.random.default_rng(round(100 * left_px)).normal(0.0, 1.0, whole.shape)
    return np.asarray((cv2.GaussianBlur(whole, (0, 0), BLUR_PX) + noise).round(), np.uint8)


def test_what_shows_through_a_blurred_edge_does_not_hold_a_body_back() -> None:
    scene = passing(300.0)
    pictures = [passing(x) for x, _ in ALONG]
    stage = Stage(1, (0.0, 0.0), (HIGH_PX, LONG_PX), ALONG)
    found = cut_out(Source(pictures, before(scene), ()), stage, (12, 12), (-np.inf, np.inf))
    assert found is not None
    template, corner = found[1].template, found[0].path_px[0] - ALONG[0]

    # Most pictures show the wall beyond the right end; here it passes over the edge of the board.
    errors = []
    for left_px in np.arange(BOARD_PX - LONG_PX, BOARD_PX - LONG_PX + 4.0, 0.5):
        place = corner + np.array((left_px, ALONG[0, 1]))
        fit = register(passing(left_px), template, tuple(place + NEARLY_PX))
        errors.append(np.nan if fit is None else fit.x_px - place[0])

    assert np.abs(errors).max() < CONVERGED_PX
