"""The heavy body's path with a collision that the frames do not show."""

from __future__ import annotations

import numpy as np
import pytest

from count_video.motion.gaps import Gaps
from count_video.motion.swing import fit_swing
from count_video.records import Collision, Floats, Velocities

FRAME = np.arange(90.0)
RATE = 0.025
"""Of the swing, radians per frame."""
CENTRE_PX = 500.0
MASS_RATIO = 2.5
TIMES = (23.5, 31.3, 49.0)
STEPS = (-19.0, -32.0, -7.0)
"""Velocity steps of the ball, px per frame: of like bodies none is like the next."""
NOISE_PX = 0.05
RATIO_SIGMAS = 4.0


def swinging() -> Floats:
    """Places of a heavy body that swings and is struck, shape (n,), exact but for noise."""
    place, speed = 900.0, -12.0
    path = np.empty_like(FRAME)
    for begin, end, step in zip((0.0, *TIMES), (*TIMES, 90.0), (*STEPS, 0.0), strict=True):
        inside = (begin <= FRAME) & (end > FRAME)
        turn = RATE * (FRAME[inside] - begin)
        away = place - CENTRE_PX
        path[inside] = CENTRE_PX + away * np.cos(turn) + speed / RATE * np.sin(turn)
        turn = RATE * (end - begin)
        place = CENTRE_PX + away * np.cos(turn) + speed / RATE * np.sin(turn)
        speed = speed * np.cos(turn) - away * RATE * np.sin(turn) - step / MASS_RATIO
    return path + np.random.default_rng(1).normal(0.0, NOISE_PX, len(path))


def collisions(hidden: int | None, steps: tuple[float, ...] = STEPS) -> list[Collision]:
    """Collisions of both bodies; the ball's velocity before the hidden one is not known."""
    return [
        Collision(
            kind="bodies",
            frame=time,
            frame_sigma=0.05,
            seen=True,
            position_px=0.0,
            velocity_before=Velocities(np.nan if place == hidden else 0.0, np.nan),
            velocity_after=Velocities(step, np.nan),
        )
        for place, (time, step) in enumerate(zip(TIMES, steps, strict=True))
    ]


def gaps_with(heavy: Floats) -> Gaps:
    return Gaps(FRAME, np.zeros_like(FRAME), heavy, 0.0, sign=1)


@pytest.mark.parametrize("hidden", [None, 0, 1, 2])
def test_a_collision_that_is_not_shown_leaves_the_path_confirmed(hidden: int | None) -> None:
    swing = fit_swing(gaps_with(swinging()), collisions(hidden))

    assert swing is not None
    assert swing.fits
    assert swing.mass_ratio == pytest.approx(
        MASS_RATIO, rel=RATIO_SIGMAS * swing.mass_ratio_relative_sigma
    )


@pytest.mark.parametrize("hidden", [0, 1, 2])
def test_a_collision_that_is_not_shown_excuses_no_other(hidden: int) -> None:
    heavy = swinging()
    heavy[60:] += 3.0 * (FRAME[60:] - 60.0)  # another collision, of which nothing is known

    swing = fit_swing(gaps_with(heavy), collisions(hidden))

    assert swing is not None
    assert not swing.fits
