"""Light that varies over the picture, distinguished from bodies, and levelled away."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from count_video.records import Floats
from count_video.tracking.light import Light, lights_of

Luma = NDArray[np.uint8]
SIZE = 144, 256
PICTURES = 24
NOISE = 3.0
DEPTH = 0.25
"""Share of the light that the shadow takes in its middle."""


def scene() -> Floats:
    """A wall that is brighter on one side, with blotches."""
    rng = np.random.default_rng(3)
    blotches = np.kron(rng.normal(0, 8, (SIZE[0] // 8, SIZE[1] // 8)), np.ones((8, 8)))
    return 110 + 0.2 * np.arange(SIZE[1]) + blotches


def shadows() -> list[Floats]:
    """Light of a soft shadow that crosses the scene."""
    y, x = np.indices(SIZE)
    middles = np.linspace(-0.1, 1.1, PICTURES) * SIZE[1]
    return [
        1 - DEPTH * np.exp(-(((x - middle) / 80) ** 2) - ((y - 72) / 80) ** 2) for middle in middles
    ]


def pictures(lights: list[Floats], body_px: tuple[int, int] = (24, 20)) -> list[Luma]:
    """Pictures of a bright plain body that crosses the scene, in these lights."""
    rng, seen = np.random.default_rng(4), []
    for number, light in enumerate(lights):
        left = 5 + 8 * number
        shown = scene()
        shown[70 : 70 + body_px[1], left : left + body_px[0]] = 200
        noisy = shown * light + rng.normal(0, NOISE, SIZE)
        seen.append(np.rint(noisy).clip(0, 255).astype(np.uint8))
    return seen


def lights_in(seen: list[Luma]) -> list[Light]:
    return lights_of(seen, np.ones(len(seen)), np.median(seen, axis=0).astype(np.uint8))


def test_a_soft_shadow_is_levelled_away_and_the_body_stays() -> None:
    seen = pictures(shadows())
    lights = lights_in(seen)
    before, after = ([one.astype(float) for one in some] for some in (seen, _levelled(seen)))
    middle = np.median(after, axis=0)
    free = slice(0, 60)  # rows above the body
    spread = [np.std([one[free] for one in some], axis=0).mean() for some in (before, after)]
    assert all(one.waves is not None for one in lights)
    assert spread[0] > 3 * NOISE
    assert spread[1] < 1.1 * NOISE
    for number, one in enumerate(after):
        body = slice(73, 87), slice(8 + 8 * number, 26 + 8 * number)
        assert float((one[body] - middle[body]).mean()) > 30


def _levelled(seen: list[Luma]) -> list[Luma]:
    return [light.levelled(one) for light, one in zip(lights_in(seen), seen, strict=True)]


@pytest.mark.parametrize("body_px", [(40, 30), (120, 70)])
def test_a_body_in_even_light_is_no_light(body_px: tuple[int, int]) -> None:
    even = [np.ones(SIZE) for _ in range(PICTURES)]
    assert all(one.waves is None for one in lights_in(pictures(even, body_px)))


def test_light_over_a_piece_is_that_of_the_picture_there() -> None:
    light = Light(1.2, np.random.default_rng(5).normal(0, 0.1, (4, 6)))
    whole = light.over((0.0, 0.0), SIZE, SIZE)
    assert light.over((30.0, 20.0), (10, 12), SIZE) == pytest.approx(whole[20:30, 30:42])
    turned = light.turned().over((0.0, 0.0), SIZE[::-1], SIZE[::-1])
    assert turned == pytest.approx(whole.T)


def test_even_light_is_one_factor() -> None:
    assert Light(0.5).over((3.0, 4.0), (10, 12), SIZE) == pytest.approx(0.5)
    assert (Light(0.5).levelled(np.full(SIZE, 60, np.uint8)) == 120).all()
    assert Light(1.005).unless_faint() == Light()
    assert Light(1.1).unless_faint() == Light(1.1)
