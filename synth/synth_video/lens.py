"""A real lens: perspective of a camera that is turned, and distortion.

The flat picture is a parallel projection of the plane in which the bodies move. A camera at a
finite distance that does not face that plane at right angles sees its near side larger; a lens
that is not ideal moves points toward or away from the picture's centre. Both are maps of the plane
onto itself, so they are applied to the flat picture as a whole. (The depth of the bodies is not
modelled: a turned camera would see a little of a cylinder's face.)

Points are (x, y) in px from the picture's centre, x right and y down.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from count_video.records import Floats

_STEPS = 30
"""Rounds in which the distortion is undone; each gains a digit at 10 % of distortion."""


@dataclass(frozen=True)
class Lens:
    """Map from the flat picture to what the sensor sees."""

    turn_deg: float
    """Turn of the camera about the vertical; at positive angles the right side is farther away."""
    distance_px: float
    """From the camera to the point of the plane in the picture's centre, in px of the plane."""
    distortion: float
    """Relative change of a corner's distance from the centre; below 0 for a barrel."""
    corner_px: float
    """From the picture's centre to its corner."""

    @property
    def ideal(self) -> bool:
        """True if the lens changes nothing."""
        return self.turn_deg == 0 and self.distortion == 0

    def seen(self, x_px: Floats, y_px: Floats) -> tuple[Floats, Floats]:
        """Where points of the flat picture are seen; arrays of one shape."""
        cosine, sine = np.cos(np.radians(self.turn_deg)), np.sin(np.radians(self.turn_deg))
        nearness = self.distance_px / (self.distance_px + sine * x_px)
        x, y = cosine * nearness * x_px, nearness * y_px
        growth = 1 + self.distortion * (x * x + y * y) / self.corner_px**2
        return x * growth, y * growth

    def flat(self, x_px: Floats, y_px: Floats) -> tuple[Floats, Floats]:
        """Points of the flat picture that are seen at these points: the inverse of ``seen``."""
        x, y = x_px, y_px
        for _ in range(_STEPS):
            growth = 1 + self.distortion * (x * x + y * y) / self.corner_px**2
            x, y = x_px / growth, y_px / growth
        cosine, sine = np.cos(np.radians(self.turn_deg)), np.sin(np.radians(self.turn_deg))
        along = self.distance_px * x / (self.distance_px * cosine - sine * x)
        return along, y * (self.distance_px + sine * along) / self.distance_px
