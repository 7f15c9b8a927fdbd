"""Where a point of the apparatus is seen in the picture.

Everything is painted for a wall on the left; a wall on the right is the finished picture mirrored.
Three frames of reference follow from that:

- *level*: picture coordinates of an upright camera with the wall on the left;
- *tilted*: level turned about the picture's centre by the camera's tilt;
- *image*: tilted, seen through the lens, moved with the tripod, and mirrored where the wall stands
  on the right. This is what the clip shows.

All are in px with x right and y down; an integer is the centre of a pixel.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from count_video.records import Floats
from synth_video.lens import Lens
from synth_video.scene import Scene


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
