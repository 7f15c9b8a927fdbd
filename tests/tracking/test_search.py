"""A template is found where nothing is known of its place."""

from __future__ import annotations

import numpy as np
import pytest
from drawn import Luma, paint_ball, paint_cylinder

from count_video.tracking.registration import Fit, register_all
from count_video.tracking.search import likely_places
from count_video.tracking.template import Template, make_template, piece_at

WITHIN_PX = 0.1
"""The pictures are free of noise but for rounding to whole grey levels."""
START_WITHIN_PX = 2.0
"""The registration settles from a guess that is right to a pixel or two."""

ANYWHERE = 480.0, 20.0
"""Along the whole line of motion: as far as the pictures reach by x, a quarter of a ball by y."""


def best_of(
    picture: Luma, template: Template, near: tuple[float, float], reach_px: tuple[float, float]
) -> Fit | None:
    places = likely_places(picture, template, near, reach_px)
    fits = register_all([picture] * len(places), template, np.reshape(places, (-1, 2)))
    found = filter(None, map(fits.fit, range(len(places))))
    return max(found, key=lambda fit: fit.agreement, default=None)


def scene(x: float, y: float, radius: float, size: tuple[int, int] = (200, 480)) -> Luma:
    canvas = np.full(size, 120.0) + np.linspace(-20.0, 20.0, size[1])
    paint_ball(canvas, x, y, radius)
    return np.rint(canvas).astype(np.uint8)


def template_of(radius: float) -> tuple[Template, float]:
    """A ball's template, and how far its corner lies from the ball's centre."""
    reach = round(1.3 * radius)
    picture = scene(240.0, 100.0, radius, (2 * reach + 200, 480 + 2 * reach))
    piece = piece_at(picture, 240.0 - reach, 100.0 - reach, (2 * reach + 1, 2 * reach + 1))
    return make_template(piece, np.ones_like(piece)), float(reach)


@pytest.mark.parametrize("radius", [14.0, 30.0, 60.0])
@pytest.mark.parametrize("x", [90.3, 251.7, 377.4])
def test_a_ball_of_any_size_is_found(radius: float, x: float) -> None:
    template, reach = template_of(radius)

    fit = best_of(scene(x, 100.0, radius), template, (200.0 - reach, 100.0 - reach), ANYWHERE)

    assert fit is not None
    assert fit.x_px + reach == pytest.approx(x, abs=WITHIN_PX)


@pytest.mark.parametrize("x", [-6.0, 3.0, 476.0, 484.0])
def test_a_ball_that_comes_in_is_found_while_it_sticks_out(x: float) -> None:
    template, reach = template_of(30.0)

    fit = best_of(scene(x, 100.0, 30.0), template, (200.0 - reach, 100.0 - reach), ANYWHERE)

    assert isinstance(fit, Fit)
    assert fit.inside < 1.0
    assert fit.x_px + reach == pytest.approx(x, abs=3 * WITHIN_PX)


def test_a_ball_cut_by_the_upper_border_is_found() -> None:
    template, reach = template_of(30.0)

    fit = best_of(scene(300.0, 12.0, 30.0), template, (200.0 - reach, 12.0 - reach), ANYWHERE)

    assert fit is not None
    assert fit.x_px + reach == pytest.approx(300.0, abs=3 * WITHIN_PX)


def test_large_bodies_are_placed_finely_enough_to_register() -> None:
    template, reach = template_of(80.0)
    picture = scene(263.0, 100.0, 80.0)

    places = likely_places(picture, template, (200.0 - reach, 100.0 - reach), ANYWHERE)

    assert abs(places[0][0] + reach - 263.0) < START_WITHIN_PX


def test_the_best_of_several_likely_places_counts() -> None:
    template, reach = template_of(30.0)
    canvas = scene(350.4, 100.0, 30.0).astype(float)
    paint_cylinder(canvas, 60.0, 100.0, (60.0, 60.0))
    picture = np.rint(canvas).astype(np.uint8)

    fit = best_of(picture, template, (60.0 - reach, 100.0 - reach), ANYWHERE)

    assert fit is not None
    assert fit.x_px + reach == pytest.approx(350.4, abs=WITHIN_PX)


def test_what_lies_behind_a_body_does_not_hide_it() -> None:
    radius = 30.0
    square, reach = template_of(radius)
    y, x = np.indices(square.shape)
    within = np.hypot(x - reach, y - reach) < radius + 1.0
    template = make_template(square.appearance, within.astype(np.float32))
    # Bars of a bookshelf, nothing like the wall before which the template was cut out.
    canvas = np.where(np.arange(480) // 11 % 2, 20.0, 235.0) * np.ones((200, 1))
    paint_ball(canvas, 303.6, 100.0, radius)
    picture = np.rint(canvas).astype(np.uint8)

    places = likely_places(picture, template, (100.0 - reach, 100.0 - reach), ANYWHERE)

    assert abs(places[0][0] + reach - 303.6) < START_WITHIN_PX


def test_nothing_is_found_in_a_flat_picture() -> None:
    template, reach = template_of(30.0)

    assert (
        best_of(np.full((200, 480), 90, np.uint8), template, (100.0, 100.0 - reach), ANYWHERE)
        is None
    )
