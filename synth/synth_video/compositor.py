"""Lay the moving parts over the still picture, frame by frame."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from count_video.records import Floats
from synth_video.exposure import Paths
from synth_video.pixels import Pixels
from synth_video.sprite import Placed
from synth_video.stage import Stage
from synth_video.threads import Thread, draw_thread

Spot = tuple[slice, slice]


@dataclass
class Compositor:
    """A canvas that is repaired and painted again only where something moves."""

    stage: Stage
    _canvas: Pixels = field(init=False)
    _touched: list[Spot] = field(init=False)

    def __post_init__(self) -> None:
        self._canvas = self.stage.still.copy()
        self._film_spot = _extent(self.stage.film_cover[..., 0])
        self._touched = [self._film_spot]

    def compose(self, paths: Paths) -> Pixels:
        """Return the picture, shape (h, w, 3), during one exposure; the next call reuses it.

        Coordinates are tilted ones: the wall stands on the left.
        """
        for spot in self._touched:
            self._canvas[spot] = self.stage.still[spot]
        self._touched = [self._film_spot]
        self._lay_shadows(paths)
        self._lay_mirror_image(paths)
        self._lay_threads(self.stage.cylinder_threads, paths.heavy_along_m, paths.heavy_up_m)
        self._lay_threads(self.stage.ball_threads, paths.ball_along_m, paths.ball_up_m)
        to_px = self.stage.projection.tilted
        self._lay(self.stage.cylinder.placed(*to_px(paths.heavy_along_m, paths.heavy_up_m)))
        self._lay(self.stage.ball.placed(*to_px(paths.ball_along_m, paths.ball_up_m)))
        film = self._canvas[self._film_spot]
        film *= 1 - self.stage.film_cover[self._film_spot]
        film += self.stage.film_rgb[self._film_spot]
        return self._canvas

    def _lay_shadows(self, paths: Paths) -> None:
        stage = self.stage
        middle = paths.heavy_along_m + stage.cylinder_length_m / 2
        for sprite, along_m in (
            (stage.cylinder_shadow, middle),
            (stage.ball_shadow, paths.ball_along_m),
        ):
            down = np.full_like(along_m, -stage.shadow_drop_m)
            self._lay(sprite.placed(*stage.projection.tilted(along_m, down)))

    def _lay_mirror_image(self, paths: Paths) -> None:
        if self.stage.ball_image is not None:
            at = self.stage.projection.tilted(-paths.ball_along_m, paths.ball_up_m)
            self._lay(self.stage.ball_image.placed(*at), strength=self.stage.mirror)

    def _lay_threads(self, threads: tuple[Thread, ...], along_m: Floats, up_m: Floats) -> None:
        for thread in threads:
            placed = draw_thread(
                thread, self.stage.thread_look, self.stage.projection, along_m, up_m
            )
            if placed is not None:
                self._lay(placed)

    def _lay(self, placed: Placed, strength: Pixels | None = None) -> None:
        """Lay a premultiplied picture over the canvas, as far as ``strength`` lets it."""
        spot, pixels = _inside(placed, self._canvas.shape)
        if not pixels.size:
            return
        self._touched.append(spot)
        if strength is not None:
            pixels = pixels * strength[spot]
        part = self._canvas[spot]
        part *= 1 - pixels[..., 3:4]
        part += pixels[..., :3]
        if pixels.shape[2] == 5:
            # The fifth channel mirrors the lamps, whose image stays where it is in the picture.
            part += pixels[..., 4:] * self.stage.lamps[spot]


def _inside(placed: Placed, shape: tuple[int, ...]) -> tuple[Spot, Pixels]:
    """Part of the canvas that a picture covers, and the part of the picture that covers it."""
    height, width = placed.pixels.shape[:2]
    top, left = max(placed.y_px, 0), max(placed.x_px, 0)
    bottom = max(min(placed.y_px + height, shape[0]), top)
    right = max(min(placed.x_px + width, shape[1]), left)
    pixels = placed.pixels[
        top - placed.y_px : bottom - placed.y_px, left - placed.x_px : right - placed.x_px
    ]
    return (slice(top, bottom), slice(left, right)), pixels


def _extent(cover: Pixels) -> Spot:
    """Smallest rectangle that holds all that is covered; empty if nothing is."""
    rows, columns = np.flatnonzero(cover.any(axis=1)), np.flatnonzero(cover.any(axis=0))
    if not rows.size:
        return slice(0, 0), slice(0, 0)
    return slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
