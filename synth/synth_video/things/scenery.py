"""The things of a scene as actors: those behind the bodies, and those in front of them."""

from __future__ import annotations

import numpy as np

from count_video.physics.flights import Pendulum
from synth_video.actors import Actor, Standing, standing
from synth_video.bodies import Lens, light_look
from synth_video.easel import Easel
from synth_video.projection import Projection
from synth_video.scene import Scene
from synth_video.things.hand import Hand, paint_hand
from synth_video.things.person import Person, paint_person

CORD_COLORS = ((52.0, 48.0, 46.0), (206.0, 200.0, 188.0), (120.0, 52.0, 44.0))
PERSON_DEPTH = 1.3
"""Width of the painted coat, in reaches: it must not end within the picture."""


def behind(
    scene: Scene, projection: Projection, lens: Lens, rng: np.random.Generator
) -> tuple[Actor, ...]:
    """Person and lying ball."""
    actors: list[Actor] = []
    if scene.things.person:
        actors.append(_person(scene, projection, rng))
    if scene.things.lying_ball:
        actors.append(_lying_ball(scene, projection, lens))
    return tuple(actors)


def before(scene: Scene, easel: Easel, lens: Lens) -> tuple[Actor, ...]:
    """Hand and cords."""
    actors: list[Actor] = []
    if scene.things.hand_s and scene.setup.mounting == "suspended":
        actors.append(_hand(scene, lens))
    if scene.things.cords:
        actors.append(_cords(scene, easel, lens.blur_px / lens.px_per_m))
    return tuple(actors)


def _person(scene: Scene, projection: Projection, rng: np.random.Generator) -> Person:
    things, width_m = scene.things, scene.view.width_m
    inward = -1 if things.person_side == "far" else 1
    reach_m = things.person * width_m
    scale = projection.px_per_m
    size = round(PERSON_DEPTH * reach_m * scale) + projection.width_px // 4
    sprite = paint_person(size, 2 * projection.height_px, scale, inward, rng)
    edge_m = width_m - scene.view.wall_m if inward < 0 else -scene.view.wall_m
    return Person(sprite, edge_m, inward, reach_m, things.person_m_s, float(rng.uniform(0, 6.28)))


def _lying_ball(scene: Scene, projection: Projection, lens: Lens) -> Standing:
    sprite = light_look(scene.ball, scene.setup.ball_diameter_m, lens).at(0.0)
    along_m, up_m = np.array([scene.things.lying_along_m]), np.array([scene.things.lying_up_m])
    return Standing(sprite.placed(*projection.tilted(along_m, up_m)))


def _hand(scene: Scene, lens: Lens) -> Hand:
    setup = scene.setup
    law = Pendulum.from_thread(
        setup.heavy_thread_m, setup.gravity_m_s2, setup.heavy_damping_per_s, setup.heavy_rest_m
    )
    length_m = scene.cylinder.length_m
    return Hand(paint_hand(lens), law, setup.heavy_start_m, length_m, scene.things.hand_s)


def _cords(scene: Scene, easel: Easel, lens_m: float) -> Standing:
    """Straight cords at all angles across the ball's way or the cylinder."""
    rng, half_m = easel.rng, scene.things.cord_m / 2
    cover = np.zeros(easel.shape, dtype=np.float32)
    rgb = np.zeros((*easel.shape, 3), dtype=np.float32)
    for number in range(scene.things.cords):
        along_m = rng.uniform(0.0, scene.setup.heavy_rest_m + 0.5 * scene.cylinder.length_m)
        lean = rng.uniform(-1.2, 1.2)
        wide_m = half_m * np.hypot(1.0, lean)
        cord = easel.polygon(
            [
                (along_m + lean * up_m + side * wide_m, up_m)
                for up_m, side in ((-0.5, -1), (-0.5, 1), (0.5, 1), (0.5, -1))
            ]
        )
        color = np.array(CORD_COLORS[number % len(CORD_COLORS)], dtype=np.float32)
        rgb += cord[..., None] * (color - rgb)
        cover += cord * (1 - cover)
    return standing(easel.picture(rgb, lens_m), easel.picture(cover, lens_m))
