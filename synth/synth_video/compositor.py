"""Lay the moving parts over the still picture, frame by frame."""

from __future__ import annotations

from dataclasses import dataclass, field

from synth_video.body_picture import Placed
from synth_video.exposure import Paths
from synth_video.moving_layers import Layer
from synth_video.pixels import Pixels
from synth_video.stage import Stage

Spot = tuple[slice, slice]


@dataclass
class Compositor:
    """A canvas that is repaired and painted again only where something is laid over it."""

    stage: Stage
    _canvas: Pixels = field(init=False)
    _touched: list[Spot] = field(init=False)

    def __post_init__(self) -> None:
        self._canvas = self.stage.still.copy()
        self._touched = []

    def compose(self, paths: Paths) -> Pixels:
        """Return the picture, shape (h, w, 3), during one exposure; the next call reuses it.

        Coordinates are tilted ones: the wall stands on the left.
        """
        for spot in self._touched:
            self._canvas[spot] = self.stage.still[spot]
        self._touched = []
        for source in self.stage.layer_sources:
            for layer in source.layers(paths, self.stage.projection):
                self._lay(layer)
        return self._canvas

    def _lay(self, layer: Layer) -> None:
        """Lay a premultiplied picture over the canvas, as far as its strength lets it."""
        spot, pixels = _inside(layer.placed, self._canvas.shape)
        if not pixels.size:
            return
        self._touched.append(spot)
        if layer.strength is not None:
            pixels = pixels * layer.strength[spot]
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
