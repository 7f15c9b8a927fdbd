"""What moves, or stands, before the still picture: each thing lays its layers frame by frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from synth_video.body_picture import BodyPicture, Placed
from synth_video.exposure import Paths
from synth_video.pixels import Pixels
from synth_video.projection import Projection
from synth_video.threads import Thread, ThreadAppearance, draw_thread


@dataclass(frozen=True)
class Layer:
    """A picture to be laid over what is there already."""

    placed: Placed
    """Channels: red, green, blue (premultiplied), coverage; a fifth mirrors the lamps."""
    strength: Pixels | None = None
    """How far the picture shows at each place of the frame, shape (h, w, 1); None for fully."""


class LayerSource(Protocol):
    """A thing of the scene. Coordinates are tilted ones: the wall stands on the left."""

    def layers(self, paths: Paths, projection: Projection) -> Iterator[Layer]:
        """Yield its appearance during one exposure, the farthest first."""


class Appearance(Protocol):
    """The appearance of a body, which may change with time."""

    def at(self, time_s: float) -> BodyPicture:
        """Its picture at a real time."""


@dataclass(frozen=True)
class Moving:
    """A picture that goes with a body."""

    appearance: Appearance
    body: int
    """Index of the body in ``Paths.bodies``."""
    shift_m: float = 0.0
    """From the body's reference point to the picture's, along the line of motion."""
    level_m: float | None = None
    """Height at which the picture stays (a shadow); None to rise and fall with the body."""
    mirrored: bool = False
    """True for the image in the wall."""
    strength: Pixels | None = None

    def layers(self, paths: Paths, projection: Projection) -> Iterator[Layer]:
        """Lay the picture along the path of its body."""
        path = paths.bodies[self.body]
        along_m = path.along_m + self.shift_m
        up_m = path.up_m if self.level_m is None else np.full_like(along_m, self.level_m)
        at = projection.tilted(-along_m if self.mirrored else along_m, up_m)
        picture = self.appearance.at(float(paths.times_s.mean()))
        yield Layer(picture.placed(*at), self.strength)


@dataclass(frozen=True)
class Hanging:
    """The threads of a body."""

    threads: tuple[Thread, ...]
    appearance: ThreadAppearance
    body: int

    def layers(self, paths: Paths, projection: Projection) -> Iterator[Layer]:
        """Draw those of the threads that are in sight."""
        path = paths.bodies[self.body]
        for thread in self.threads:
            placed = draw_thread(thread, self.appearance, projection, path.along_m, path.up_m)
            if placed is not None:
                yield Layer(placed)


@dataclass(frozen=True)
class Standing:
    """A picture that stays where it is, in front of what was laid before."""

    placed: Placed

    def layers(self, paths: Paths, projection: Projection) -> Iterator[Layer]:
        """Lay it as it is."""
        yield Layer(self.placed)


def standing(rgb: Pixels, cover: Pixels) -> Standing:
    """Cut the smallest picture that holds all that is covered.

    Parameters
    ----------
    rgb
        Premultiplied colour of the whole frame, shape (h, w, 3).
    cover
        Its coverage, shape (h, w).
    """
    rows, columns = np.flatnonzero(cover.any(axis=1)), np.flatnonzero(cover.any(axis=0))
    if not rows.size:
        return Standing(Placed(0, 0, np.zeros((0, 0, 4), dtype=np.float32)))
    spot = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
    pixels = np.concatenate([rgb[spot], cover[spot][..., None]], axis=-1)
    return Standing(Placed(int(columns[0]), int(rows[0]), pixels))
