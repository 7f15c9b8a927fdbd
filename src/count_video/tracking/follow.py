"""Follow a learnt body through the footage, frame by frame, as the pictures stream by.

The next place is guessed by the velocity of the last two sightings; the registration makes it
exact. Where it fails (the body turned at a collision faster than the guess allows, or is hidden)
the surroundings are searched, and further out the longer the body has been lost.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from count_video.tracking.learning import Body
from count_video.tracking.register import Fit, register
from count_video.tracking.search import search
from count_video.tracking.sprite import Picture

AGREEMENT_SHARE = 0.75
"""A fit is believed from this share of the body's typical correlation on."""
INSIDE_AT_LEAST = 0.35
"""Share of the sprite that must lie within the picture."""
REACH_AT_LEAST_PX = 8.0
REACH_OVER_SPEED = 3.0
"""A search reaches this many times as far as the body moves in a frame."""
LOST_GROWTH = 1.5
"""Growth of the reach for each frame without a sighting."""


@dataclass
class Follower:
    """Follows one body; feed it every frame in order, then read the lists."""

    body: Body
    slope: float
    """Rise of the line of motion, change of y by x."""
    x_px: list[float] = field(default_factory=list)
    y_px: list[float] = field(default_factory=list)
    sigma_px: list[float] = field(default_factory=list)
    _place: tuple[float, float] | None = None
    _speed: tuple[float, float] = (0.0, 0.0)
    _last_index: int = 0
    _lost: int = 0

    def see(self, index: int, picture: Picture) -> None:
        """Find the body in the next picture; where it is not seen, NaN is noted."""
        fit = self._fit(index, picture)
        if fit is None:
            self._lost += 1
            for values in (self.x_px, self.y_px, self.sigma_px):
                values.append(float("nan"))
            return
        if self._place is not None and self._lost == 0 and index > self._last_index:
            frames = index - self._last_index
            self._speed = (
                (fit.x_px - self._place[0]) / frames,
                (fit.y_px - self._place[1]) / frames,
            )
        elif self._lost:
            self._speed = (0.0, 0.0)
        self._place, self._last_index, self._lost = (fit.x_px, fit.y_px), index, 0
        self.x_px.append(fit.x_px)
        self.y_px.append(fit.y_px)
        self.sigma_px.append(fit.sigma_x_px)

    def _fit(self, index: int, picture: Picture) -> Fit | None:
        guess = self._guess(index)
        fit = None if guess is None else register(picture, self.body.sprite, guess)
        if self._believed(fit):
            return fit
        place = self._place or self._nearest_sighting(index)
        reach = max(REACH_AT_LEAST_PX, REACH_OVER_SPEED * abs(self._speed[0]))
        reach *= LOST_GROWTH ** min(self._lost, 12)
        known = self._place is not None and reach < picture.shape[1]
        found = search(
            picture, self.body.sprite, place, self.slope, reach_px=reach if known else None
        )
        fit = None if found is None else register(picture, self.body.sprite, found)
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
