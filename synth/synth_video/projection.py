"""Where a point of the apparatus is seen in the picture, through which lens, on which stand.

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
from synth_video.scene import Scene, TripodSettings
from synth_video.schedule import Schedule

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


# ---- from the apparatus to the picture -----------------------------------------------------------
# Where a point of the apparatus is seen in the picture.
#
# Everything is painted for a wall on the left; a wall on the right is the finished picture
# mirrored. Three frames of reference follow from that:
#
# - *level*: picture coordinates of an upright camera with the wall on the left;
# - *tilted*: level turned about the picture's centre by the camera's tilt;
# - *image*: tilted, seen through the lens, moved with the tripod, and mirrored where the wall
#   stands on the right. This is what the clip shows.
#
# All are in px with x right and y down; an integer is the centre of a pixel.


@dataclass(frozen=True)
class Projection:
    """Parallel projection of the plane in which the bodies move."""

    width_px: int
    height_px: int
    px_per_m: float
    """Scale along the line of motion."""
    wall_x_px: float
    """Level x of the wall's face."""
    line_y_px: float
    """Level y of the bodies' axis at rest."""
    tilt_deg: float
    """Turn from level to tilted, positive when y grows with x."""
    mirrored: bool
    """True for a wall on the right."""
    lens: Lens

    def level(self, along_m: Floats, up_m: Floats) -> tuple[Floats, Floats]:
        """Level (x, y) of points given by distance from the wall and height over the rest line."""
        return self.wall_x_px + self.px_per_m * along_m, self.line_y_px - self.px_per_m * up_m

    def tilted(self, along_m: Floats, up_m: Floats) -> tuple[Floats, Floats]:
        """Tilted (x, y) of points given in metres; arrays of any shape."""
        x_level, y_level = self.level(along_m, up_m)
        x_centre, y_centre = (self.width_px - 1) / 2, (self.height_px - 1) / 2
        cosine, sine = np.cos(np.radians(self.tilt_deg)), np.sin(np.radians(self.tilt_deg))
        dx, dy = x_level - x_centre, y_level - y_centre
        return x_centre + cosine * dx - sine * dy, y_centre + sine * dx + cosine * dy

    def image(
        self, along_m: Floats, up_m: Floats, shift_px: Floats | None = None
    ) -> tuple[Floats, Floats]:
        """Image (x, y) of points given in metres, arrays of shape (n,).

        ``shift_px`` is the tripod's shift for each of the points, shape (n, 2).
        """
        x_px, y_px = self.tilted(along_m, up_m)
        if not self.lens.ideal:
            x_centre, y_centre = (self.width_px - 1) / 2, (self.height_px - 1) / 2
            x_seen, y_seen = self.lens.seen(x_px - x_centre, y_px - y_centre)
            x_px, y_px = x_seen + x_centre, y_seen + y_centre
        if shift_px is not None:
            x_px, y_px = x_px + shift_px[:, 0], y_px + shift_px[:, 1]
        return (self.width_px - 1 - x_px if self.mirrored else x_px), y_px


def projection_of(scene: Scene) -> Projection:
    """Build the projection that a scene asks for."""
    camera, view = scene.camera, scene.view
    px_per_m = camera.width_px / view.width_m
    mirrored = scene.wall.side == "right"
    return Projection(
        width_px=camera.width_px,
        height_px=camera.height_px,
        px_per_m=px_per_m,
        wall_x_px=view.wall_m * px_per_m - 0.5,
        line_y_px=view.line * camera.height_px - 0.5,
        # Mirroring turns a rising line into a falling one: undo that beforehand.
        tilt_deg=-camera.tilt_deg if mirrored else camera.tilt_deg,
        mirrored=mirrored,
        lens=Lens(
            turn_deg=scene.lens.turn_deg,
            distance_px=scene.lens.distance_m * px_per_m,
            distortion=scene.lens.distortion,
            corner_px=float(np.hypot(camera.width_px, camera.height_px)) / 2,
        ),
    )


# ---- a camera that does not stand still ----------------------------------------------------------
# How the picture moves when the camera does not stand still.

_CHANCE = 4
"""Stream of chance of its own: a tripod that shakes does not change what is filmed."""
_WAVES = 3
_DECAY_S = 0.06
"""The swing after a knock falls to a third in this time."""
_KNOCK_HZ = (10.0, 18.0)


def tripod_shift(tripod: TripodSettings, schedule: Schedule, seed: int) -> Floats:
    """Shift of the picture in each frame, (x, y) in px of the tilted picture, shape (n, 2).

    It is the shift at the centre of the exposure: a tripod is slow next to a shutter.
    """
    shift = np.zeros((len(schedule.centre_s), 2))
    rng = np.random.default_rng([seed, _CHANCE])
    since_s = schedule.centre_s - schedule.centre_s[0]
    if tripod.shake_px:
        for axis in range(2):
            shift[:, axis] = tripod.shake_px * _shake(tripod, since_s, rng)
    if tripod.knock_px:
        shift += tripod.knock_px * _knock(since_s, rng)
    return shift


def _shake(tripod: TripodSettings, since_s: Floats, rng: np.random.Generator) -> Floats:
    """Sum of waves, never beyond -1 to 1."""
    share = rng.dirichlet(np.ones(_WAVES))
    rate_hz = rng.uniform(tripod.shake_low_hz, tripod.shake_high_hz, _WAVES)
    phase = rng.uniform(0, 2 * np.pi, _WAVES)
    return np.asarray(np.sin(2 * np.pi * rate_hz * since_s[:, None] + phase) @ share)


def _knock(since_s: Floats, rng: np.random.Generator) -> Floats:
    """Damped swing that starts in the middle third of the clip, first peak 1, shape (n, 2)."""
    after_s = np.clip(since_s - rng.uniform(1 / 3, 2 / 3) * since_s[-1], 0, None)
    angular = 2 * np.pi * rng.uniform(*_KNOCK_HZ)
    # exp(-t / d) sin(w t) has its first peak where tan(w t) = w d.
    peak_s = np.arctan(angular * _DECAY_S) / angular
    peak = np.exp(-peak_s / _DECAY_S) * np.sin(angular * peak_s)
    swing = np.exp(-after_s / _DECAY_S) * np.sin(angular * after_s) / peak
    direction = rng.uniform(-np.pi / 4, np.pi / 4) + np.pi * rng.integers(2)
    return np.asarray(swing[:, None] * np.array([np.cos(direction), np.sin(direction)]))
