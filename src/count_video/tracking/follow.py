"""Follow a learnt body through the footage, frame by frame, as the pictures stream by.

The next place is guessed by the velocity of the last two sightings, and by how far the camera has
moved; the registration makes it exact. Where it fails (the body turned at a collision faster than
the guess allows, or is hidden) the surroundings are searched, and further out the longer the body
has been lost.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from count_video.tracking.looks.learning import Body
from count_video.tracking.looks.register import Fit, register
from count_video.tracking.looks.search import search
from count_video.tracking.looks.sprite import Picture
from count_video.tracking.steadying.camera import Motion

AGREEMENT_SHARE = 0.75
"""A fit is believed from this share of the body's typical correlation on."""
INSIDE_AT_LEAST = 0.35
"""Share of the sprite that must lie within the picture."""
REACH_AT_LEAST_PX = 8.0
REACH_OVER_HEIGHT = 0.25
"""Large bodies are seen from close by, and move by more px."""
REACH_OVER_SPEED = 3.0
"""A search reaches this many times as far as the body ever moved in a frame: where it is needed the
body has just turned, and how fast it comes back the frames before do not tell."""
LOST_GROWTH = 1.5
"""Growth of the reach for each frame without a sighting."""


@dataclass
class Follower:
    """Follows one body; feed it every frame in order, then read the lists."""

    body: Body
    slope: float
    """Rise of the line of motion, change of y by x."""
    x_px: list[float] = field(default_factory=list)
    """Places in the pictures as they were seen, until ``take_away`` is called."""
    y_px: list[float] = field(default_factory=list)
    sigma_px: list[float] = field(default_factory=list)
    _place: tuple[float, float] | None = None
    """Last place, as a camera at rest had seen it; so are the guesses."""
    _speed: tuple[float, float] = (0.0, 0.0)
    _fastest: float = 0.0
    """Highest speed along x so far, px per frame."""
    _last_index: int = 0
    _lost: int = 0

    def see(self, index: int, picture: Picture, shift: tuple[float, float] = (0.0, 0.0)) -> None:
        """Find the body in the next picture, which a camera's motion has shifted by so many px.

        Where it is not seen, NaN is noted.
        """
        fit = self._fit(index, picture, shift)
        if fit is None:
            self._lost += 1
            for values in (self.x_px, self.y_px, self.sigma_px):
                values.append(float("nan"))
            return
        place = (fit.x_px - shift[0], fit.y_px - shift[1])
        self._learn_speed(index, place)
        self._place, self._last_index, self._lost = place, index, 0
        self.x_px.append(fit.x_px)
        self.y_px.append(fit.y_px)
        self.sigma_px.append(fit.sigma_x_px)

    def _learn_speed(self, index: int, place: tuple[float, float]) -> None:
        """Note how the body has come from its last place; a body lost on the way has turned."""
        if self._place is None or index <= self._last_index:
            return
        frames = index - self._last_index
        x, y = ((now - then) / frames for now, then in zip(place, self._place, strict=True))
        self._fastest = max(self._fastest, abs(x))
        self._speed = (0.0, 0.0) if self._lost else (x, y)

    def take_away(self, motion: Motion, upright: bool) -> None:
        """Correct all places by the camera's motion; ``upright`` if the pictures are transposed."""
        shift, sigma = motion.shift_px, motion.sigma_px
        along, across = (1, 0) if upright else (0, 1)
        self.x_px = (np.array(self.x_px) - shift[:, along]).tolist()
        self.y_px = (np.array(self.y_px) - shift[:, across]).tolist()
        self.sigma_px = np.hypot(self.sigma_px, sigma[:, along]).tolist()

    def _fit(self, index: int, picture: Picture, shift: tuple[float, float]) -> Fit | None:
        guess = self._guess(index)
        fit = None if guess is None else register(picture, self.body.sprite, _plus(guess, shift))
        if self._believed(fit):
            return fit
        place = self._place or self._nearest_sighting(index)
        large = REACH_OVER_HEIGHT * self.body.sprite.shape[0]
        reach = max(REACH_AT_LEAST_PX, large, REACH_OVER_SPEED * self._fastest)
        reach *= LOST_GROWTH ** min(self._lost, 12)
        known = self._place is not None and reach < picture.shape[1]
        near, reach_px = _plus(place, shift), reach if known else None
        fit = search(picture, self.body.sprite, near, self.slope, reach_px=reach_px)
        return fit if self._believed(fit) else None

    def _guess(self, index: int) -> tuple[float, float] | None:
        if index in self.body.sightings and self._place is None:
            return self.body.sightings[index]
        if self._place is None:
            return None
        frames = index - self._last_index
        return (
            self._place[0] + self._speed[0] * frames,
            self._place[1] + self._speed[1] * frames,
        )

    def _nearest_sighting(self, index: int) -> tuple[float, float]:
        nearest = min(self.body.sightings, key=lambda seen: abs(seen - index))
        return self.body.sightings[nearest]

    def _believed(self, fit: Fit | None) -> bool:
        return (
            fit is not None
            and fit.inside >= INSIDE_AT_LEAST
            and fit.agreement >= AGREEMENT_SHARE * self.body.typical_agreement
        )


def _plus(place: tuple[float, float], shift: tuple[float, float]) -> tuple[float, float]:
    return place[0] + shift[0], place[1] + shift[1]
