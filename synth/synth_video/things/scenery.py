"""The things of a scene as layer_sources: those behind the bodies, and those in front of them."""

from __future__ import annotations

import numpy as np

from count_video.physics.flights import Pendulum
from synth_video.body_shapes import Lens, light_appearance
from synth_video.moving_layers import LayerSource, Standing, standing
from synth_video.projection import Projection
from synth_video.raster import Raster
from synth_video.scene import Scene
from synth_video.things.hand import Hand, paint_hand
from synth_video.things.person import Person, paint_person

CORD_COLORS = ((52.0, 48.0, 46.0), (206.0, 200.0, 188.0), (120.0, 52.0, 44.0))
PERSON_DEPTH = 1.3
"""Width of the painted coat, in reaches: it must not end within the picture."""


def behind(
    scene: Scene, projection: Projection, lens: Lens, rng: np.random.Generator
) -> tuple[LayerSource, ...]:
    """Person and lying ball."""
    layer_sources: list[LayerSource] = []
    if scene.things.person:
        layer_sources.append(_person(scene, projection, rng))
    if scene.things.lying_ball:
        layer_sources.append(_lying_ball(scene, projection, lens))
    return tuple(layer_sources)


def before(scene: Scene, raster: Raster, lens: Lens) -> tuple[LayerSource, ...]:
    """Hand and cords."""
    layer_sources: list[LayerSource] = []
    if scene.things.hand_s and scene.setup.mounting == "suspended":
        layer_sources.append(_hand(scene, lens))
    if scene.things.cords:
        layer_sources.append(_cords(scene, raster, lens.blur_px / lens.px_per_m))
    return tuple(layer_sources)


def _person(scene: Scene, projection: Projection, rng: np.random.Generator) -> Person:
    things, width_m = scene.things, scene.view.width_m
    inward = -1 if things.person_side == "far" else 1
    reach_m = things.person * width_m
    scale = projection.px_per_m
    size = round(PERSON_DEPTH * reach_m * scale) + projection.width_px // 4
    picture = paint_person(size, 2 * projection.height_px, scale, inward, rng)
    edge_m = width_m - scene.view.wall_m if inward < 0 else -scene.view.wall_m
    return Person(picture, edge_m, inward, reach_m, things.person_m_s, float(rng.uniform(0, 6.28)))


def _lying_ball(scene: Scene, projection: Projection, lens: Lens) -> Standing:
    picture = light_appearance(scene.ball, scene.setup.ball_diameter_m, lens).at(0.0)
    along_m, up_m = np.array([scene.things.lying_along_m]), np.array([scene.things.lying_up_m])
    return Standing(picture.placed(*projection.tilted(along_m, up_m)))


def _hand(scene: Scene, lens: Lens) -> Hand:
    setup = scene.setup
    law = Pendulum.from_thread(
        setup.heavy_thread_m, setup.gravity_m_s2, setup.heavy_damping_per_s, setup.heavy_rest_m
    )
    length_m = scene.cylinder.length_m
    return Hand(paint_hand(lens), law, setup.heavy_start_m, length_m, scene.things.hand_s)


def _cords(scene: Scene, raster: Raster, lens_m: float) -> Standing:
    """Straight cords at all angles across the ball's way or the cylinder."""
    rng, half_m = raster.rng, scene.things.cord_m / 2
    cover = np.zeros(raster.shape, dtype=np.float32)
    rgb = np.zeros((*raster.shape, 3), dtype=np.float32)
    for number in range(scene.things.cords):
        along_m = rng.uniform(0.0, scene.setup.heavy_rest_m + 0.5 * scene.cylinder.length_m)
        lean = rng.uniform(-1.2, 1.2)
        wide_m = half_m * np.hypot(1.0, lean)
        cord = raster.polygon(
            [
                (along_m + lean * up_m + side * wide_m, up_m)
                for up_m, side in ((-0.5, -1), (-0.5, 1), (0.5, 1), (0.5, -1))
            ]
        )
        color = np.array(CORD_COLORS[number % len(CORD_COLORS)], dtype=np.float32)
        rgb += cord[..., None] * (color - rgb)
        cover += cord * (1 - cover)
    return standing(raster.picture(rgb, lens_m), raster.picture(cover, lens_m))
