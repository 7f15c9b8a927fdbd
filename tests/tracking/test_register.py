from __future__ import annotations

import numpy as np
import pytest
from drawn import background, paint_ball, paint_box, paint_disc, to_luma
from registering import register

from count_video.records import Luma
from count_video.tracking.registration import GAIN_AT_LEAST, Fit
from count_video.tracking.template import SMOOTHING_PX, Template, make_template, piece_at

SHAPE = (80, 160)
HOME = (80.0, 40.0)
"""Centre of the ball in the picture that the template is cut from."""
SHIFTED_PX = 1e-3
REGISTERED_PX = 0.02
HIDDEN_PX = 0.05
SMEARED_OF = 32
"""A smeared picture is the mean of so many: steps of half a px at most."""
DRAWS = 300
TRUTHFUL = (0.8, 1.3)
"""RMS of errors over their stated uncertainty; of 300 draws it scatters by 4 % by itself."""

WAVES = ((0.31, 0.12, 0.4), (-0.22, 0.35, 1.9), (0.45, -0.38, 2.7), (0.05, 0.6, 5.1))
"""Angular frequencies in x and y, and phase: far below the sampling frequency."""


def waves(x: np.ndarray, y: np.ndarray, smoothed: bool) -> np.ndarray:
    total = np.full(np.broadcast(x, y).shape, 128.0)
    for along, down, phase in WAVES:
        passed = np.exp(-0.5 * SMOOTHING_PX**2 * (along**2 + down**2)) if smoothed else 1.0
        total += 30.0 * passed * np.cos(along * x + down * y + phase)
    return total


@pytest.mark.parametrize(
    "fraction", [(0.0, 0.0), (0.25, 0.0), (0.0, -0.3), (0.5, 0.5), (0.49, -0.49), (0.999, 0.001)]
)
def test_a_sample_between_pixels_is_shifted_exactly(fraction: tuple[float, float]) -> None:
    y, x = np.indices((120, 200), dtype=np.float64)
    picture = np.round(waves(x, y, smoothed=False)).astype(np.uint8)
    rows, columns = np.indices((80, 150), dtype=np.float64)
    x_px, y_px = 20 + fraction[0], 15 + fraction[1]

    seen = piece_at(picture, x_px, y_px, (80, 150))

    expected = waves(columns + x_px, rows + y_px, smoothed=True)
    slope_y, slope_x = np.gradient(expected)
    design = np.stack([slope_x.ravel(), slope_y.ravel(), np.ones(expected.size)], axis=1)
    shift = np.linalg.lstsq(design, (seen - expected).ravel(), rcond=None)[0]
    assert np.abs(shift[:2]).max() <= SHIFTED_PX
    # Nothing is left but the rounding to grey levels, which has a variance of 1/12.
    assert float(np.std(seen - expected)) < np.sqrt(1 / 12)


def test_beyond_the_border_the_last_row_and_column_go_on() -> None:
    picture = np.arange(20 * 30, dtype=np.uint16).reshape(20, 30) // 3
    picture = picture.astype(np.uint8)

    seen = piece_at(picture, -30.0, -40.0, (10, 10))

    assert seen == pytest.approx(float(picture[0, 0]), abs=1e-3)


def ball_picture(
    x: float, y: float, radius: float, light: tuple[float, float] = (1.0, 0.0)
) -> np.ndarray:
    canvas = np.full(SHAPE, 100.0)
    paint_ball(canvas, x, y, radius)
    gain, offset = light
    return gain * canvas + offset


def smeared_picture(x: float, y: float, radius: float, way_px: float) -> np.ndarray:
    """Mean over an exposure during which the ball moves so far along x, about its middle."""
    places = x + way_px * (np.arange(SMEARED_OF) + 0.5 - SMEARED_OF / 2) / SMEARED_OF
    return np.mean([ball_picture(place, y, radius) for place in places.tolist()], axis=0)


def ball_template(radius: float, way_px: float = 0.0) -> Template:
    picture = to_luma(smeared_picture(*HOME, radius, way_px))
    half = int(radius) + 6
    left, top = HOME[0] - half, HOME[1] - half
    appearance = piece_at(picture, left, top, (2 * half + 1, 2 * half + 1))
    y, x = np.indices(appearance.shape)
    weight = np.hypot(x - half, y - half) < radius + 3
    return make_template(appearance, weight.astype(np.float32))


def corner(radius: float) -> tuple[float, float]:
    """Top left pixel of the template when the ball is at home."""
    half = int(radius) + 6
    return HOME[0] - half, HOME[1] - half


def fitted(picture: Luma, radius: float, guess: tuple[float, float] = (0.0, 0.0)) -> Fit:
    home = corner(radius)
    fit = register(picture, ball_template(radius), (home[0] + guess[0], home[1] + guess[1]))
    assert fit is not None
    return fit


@pytest.mark.parametrize("radius", [8.0, 20.0])
@pytest.mark.parametrize("shift", [(0.0, 0.0), (0.13, 0.4), (0.5, -0.5), (-0.77, 0.21), (1.6, 0.9)])
def test_a_known_shift_is_recovered(radius: float, shift: tuple[float, float]) -> None:
    picture = to_luma(ball_picture(HOME[0] + shift[0], HOME[1] + shift[1], radius))

    fit = fitted(picture, radius)

    home = corner(radius)
    assert fit.x_px - home[0] == pytest.approx(shift[0], abs=REGISTERED_PX)
    assert fit.y_px - home[1] == pytest.approx(shift[1], abs=REGISTERED_PX)
    assert fit.inside == 1.0
    assert fit.agreement > 0.99


@pytest.mark.parametrize(
    ("learnt_px", "seen_px"), [(12.0, 0.0), (8.0, 1.0), (0.0, 6.0), (0.0, 9.0)]
)
@pytest.mark.parametrize("guess_px", [-1.5, 0.6, 1.8])
def test_a_body_is_placed_though_motion_smears_it_otherwise_than_its_template(
    learnt_px: float, seen_px: float, guess_px: float
) -> None:
    radius = 20.0
    picture = to_luma(smeared_picture(HOME[0] + 0.3, HOME[1], radius, seen_px))
    home = corner(radius)

    fit = register(picture, ball_template(radius, learnt_px), (home[0] + guess_px, home[1]))

    # Steps by the template's slopes are too long by their ratio, or too short: what is left of one
    # is that ratio less one, and so would be the error if the last step were taken as it is.
    assert fit is not None
    assert fit.x_px - home[0] == pytest.approx(0.3, abs=REGISTERED_PX)
    assert fit.y_px - home[1] == pytest.approx(0.0, abs=REGISTERED_PX)


@pytest.mark.parametrize("light", [(1.0, 12.0), (0.6, 0.0), (1.15, -20.0), (0.4, 60.0)])
def test_gain_and_offset_of_the_light_do_not_move_the_body(light: tuple[float, float]) -> None:
    picture = to_luma(ball_picture(HOME[0] + 0.37, HOME[1] - 0.2, 14.0, light))

    fit = fitted(picture, 14.0)

    assert fit.x_px - corner(14.0)[0] == pytest.approx(0.37, abs=REGISTERED_PX)
    assert fit.y_px - corner(14.0)[1] == pytest.approx(-0.2, abs=REGISTERED_PX)


@pytest.mark.parametrize("radius", [8.0, 20.0])
@pytest.mark.parametrize("noise", [2.0, 6.0])
def test_the_stated_uncertainty_is_true_for_white_noise(radius: float, noise: float) -> None:
    rng = np.random.default_rng(17)
    template, home = ball_template(radius), corner(radius)
    normalised = []
    # A few places serve for all draws: what is tested is the noise, and drawing takes long.
    shifts = rng.uniform(-0.5, 0.5, (10, 2))
    canvases = [ball_picture(HOME[0] + x, HOME[1] + y, radius) for x, y in shifts]
    for draw in range(DRAWS):
        (x, _), canvas = shifts[draw % 10], canvases[draw % 10]
        fit = register(to_luma(canvas, noise, rng), template, home)
        assert fit is not None
        normalised.append((fit.x_px - home[0] - x) / fit.sigma_x_px)

    assert TRUTHFUL[0] < float(np.sqrt(np.mean(np.square(normalised)))) < TRUTHFUL[1]


def test_something_in_front_of_the_body_does_not_move_it() -> None:
    canvas = ball_picture(HOME[0] + 0.4, HOME[1], 20.0)
    paint_box(canvas, (HOME[0] + 4, 0, HOME[0] + 7, SHAPE[0]), 20.0)

    fit = fitted(to_luma(canvas), 20.0)

    assert fit.x_px - corner(20.0)[0] == pytest.approx(0.4, abs=HIDDEN_PX)


@pytest.mark.parametrize("cut_px", [8, 20])
def test_a_body_partly_outside_the_picture_is_placed_by_what_is_inside(cut_px: int) -> None:
    picture = to_luma(ball_picture(HOME[0] + 0.3, HOME[1], 20.0))
    cut = int(HOME[0] - 20) + cut_px
    home = corner(20.0)

    fit = register(picture[:, cut:].copy(), ball_template(20.0), (home[0] - cut, home[1]))

    assert fit is not None
    assert fit.x_px + cut - home[0] == pytest.approx(0.3, abs=HIDDEN_PX)
    assert 0.3 < fit.inside < 1.0


def test_a_body_wholly_outside_the_picture_is_not_placed() -> None:
    picture = to_luma(ball_picture(*HOME, 14.0))

    assert register(picture, ball_template(14.0), (-200.0, 10.0)) is None


@pytest.mark.parametrize("grey", [0.0, 100.0, 255.0])
def test_a_plain_picture_holds_no_body(grey: float) -> None:
    picture = to_luma(np.full(SHAPE, grey))

    assert register(picture, ball_template(14.0), corner(14.0)) is None


def test_a_body_that_fades_away_is_not_there() -> None:
    faded = (GAIN_AT_LEAST / 2, 60.0)
    picture = to_luma(ball_picture(*HOME, 14.0, faded))

    assert register(picture, ball_template(14.0), corner(14.0)) is None


def test_where_the_body_is_absent_nothing_agrees() -> None:
    picture = to_luma(background(SHAPE, seed=3), 3.0, np.random.default_rng(0))

    fit = register(picture, ball_template(14.0), corner(14.0))

    assert fit is None or fit.agreement < 0.5


def test_a_negative_of_the_body_is_not_the_body() -> None:
    picture = 255 - to_luma(ball_picture(*HOME, 14.0))

    assert register(picture, ball_template(14.0), corner(14.0)) is None


def test_the_uncertainty_grows_with_the_noise() -> None:
    rng = np.random.default_rng(4)
    canvas = ball_picture(*HOME, 20.0)
    paint_disc(canvas, 5, 5, 3, 50.0)

    quiet = fitted(to_luma(canvas, 2.0, rng), 20.0).sigma_x_px
    loud = fitted(to_luma(canvas, 6.0, rng), 20.0).sigma_x_px

    assert loud / quiet == pytest.approx(3.0, rel=0.2)
