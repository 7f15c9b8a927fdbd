"""Everything of a scene that can be painted before the first frame."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from synth_video.canvas import body_canvas
from synth_video.easel import easel_for
from synth_video.paint_background import TABLE_DEPTH_M, paint_background
from synth_video.paint_ball import paint_ball
from synth_video.paint_cylinder import paint_cylinder
from synth_video.paint_wall import mirror_mask, paint_wall, plate_film
from synth_video.pixels import Pixels, as_pixels
from synth_video.projection import Projection
from synth_video.scene import Scene
from synth_video.sprite import Sprite
from synth_video.threads import Thread, ThreadLook, thread_profile

LAMPS = ((0.24, 0.05, 0.9), (0.42, 0.07, 1.1), (0.62, 0.06, 0.8), (0.84, 0.08, 1.0))
"""Middle and half width of what the brass mirrors, in picture widths, and its strength."""


@dataclass(frozen=True)
class Stage:
    """The still picture and the moving parts, in tilted coordinates (wall on the left)."""

    projection: Projection
    still: Pixels
    """Background and wall, shape (h, w, 3)."""
    mirror: Pixels
    """Strength of the mirror image in the wall, shape (h, w, 1)."""
    film_rgb: Pixels
    film_cover: Pixels
    """Near part of the plate in front of the bodies, (h, w, 3) premultiplied and (h, w, 1)."""
    lamps: Pixels
    """What polished brass mirrors at each place, shape (h, w, 3)."""
    ball: Sprite
    ball_image: Sprite | None
    """The ball as the wall mirrors it; None for a wall that mirrors nothing."""
    cylinder: Sprite
    cylinder_length_m: float
    ball_shadow: Sprite
    cylinder_shadow: Sprite
    shadow_drop_m: float
    """From the axis at rest down to where the shadows lie."""
    ball_threads: tuple[Thread, ...]
    cylinder_threads: tuple[Thread, ...]
    thread_look: ThreadLook


def set_stage(scene: Scene, projection: Projection, rng: np.random.Generator) -> Stage:
    """Paint a scene; ``rng`` decides the grain of the table and what stands on the shelf."""
    easel = easel_for(projection, rng)
    sheet = paint_background(scene.background, easel)
    defocus_px = max(scene.background.blur_m * easel.px_per_m, 0.3)
    sheet = as_pixels(cv2.GaussianBlur(sheet, (0, 0), defocus_px))
    paint_wall(scene.wall, easel, sheet)
    film = plate_film(scene.wall, easel)
    lens_m = scene.camera.blur_px / projection.px_per_m
    scale, tilt, blur = projection.px_per_m, projection.tilt_deg, scene.camera.blur_px
    diameter = scene.setup.ball_diameter_m * scale
    image = paint_ball(scene.ball, diameter, tilt, blur, reflected=True)
    cylinder = scene.cylinder
    size = (cylinder.length_m * scale, cylinder.diameter_m * scale)
    suspended = scene.setup.mounting == "suspended"
    return Stage(
        projection=projection,
        still=easel.picture(sheet, lens_m),
        mirror=easel.picture(mirror_mask(scene.wall, easel), lens_m)[..., None],
        film_rgb=easel.picture(film.rgb, lens_m),
        film_cover=easel.picture(film.cover, lens_m)[..., None],
        lamps=_lamps(projection),
        ball=paint_ball(scene.ball, diameter, tilt, blur, reflected=False),
        ball_image=image if scene.wall.reflection else None,
        cylinder=paint_cylinder(cylinder, scale, tilt, blur),
        cylinder_length_m=cylinder.length_m,
        ball_shadow=_shadow(diameter, diameter, tilt, scene.light.shadow),
        cylinder_shadow=_shadow(*size, tilt, scene.light.shadow),
        shadow_drop_m=TABLE_DEPTH_M + 0.014,
        ball_threads=_ball_threads(scene) if suspended else (),
        cylinder_threads=_cylinder_threads(scene) if suspended else (),
        thread_look=_thread_look(scene, scale),
    )


def _lamps(projection: Projection) -> Pixels:
    """Bright patches along the picture: windows and lamps as the brass mirrors them."""
    place = np.arange(projection.width_px) / projection.width_px
    bright = np.full_like(place, 0.1)
    for middle, width, strength in LAMPS:
        bright += strength * np.exp(-(((place - middle) / width) ** 4))
    row = np.multiply.outer(bright, np.array([150.0, 150.0, 132.0])).astype(np.float32)
    return np.repeat(row[None], projection.height_px, axis=0)


def _shadow(length_px: float, depth_px: float, tilt_deg: float, depth: float) -> Sprite:
    """Soft shadow on the table of a body with this length, about the middle of its length.

    Channels: red, green, blue (0) and coverage.
    """
    reach, across = 0.62 * length_px + 0.25 * depth_px, 0.24 * depth_px
    # So soft an outline needs no cells finer than pixels.
    canvas = body_canvas((-reach, reach), (-across, across), tilt_deg, cells_per_px=1)
    level = (np.abs(canvas.along_px) / reach) ** 3 + (canvas.down_px / across) ** 2
    cover = depth * np.clip(1 - level, 0, None) ** 1.5
    dark = np.zeros_like(cover)
    return canvas.finish([dark, dark, dark, cover], 0.0)


def _ball_threads(scene: Scene) -> tuple[Thread, ...]:
    """Two threads from the top of the ring, one toward the camera and one away from it."""
    setup = scene.setup
    rest, length = setup.wall_gap_m + setup.ball_diameter_m / 2, setup.light_thread_m
    knot_up = 0.5 * setup.ball_diameter_m
    return tuple(Thread(rest + spread, length, 0.4 * spread, knot_up) for spread in (0.001, 0.008))


def _cylinder_threads(scene: Scene) -> tuple[Thread, ...]:
    """Two threads from each of the two slings."""
    setup, cylinder = scene.setup, scene.cylinder
    knot_up = 0.5 * cylinder.diameter_m
    threads = []
    for place in (0.17, 0.80):
        knot = place * cylinder.length_m
        for spread in (-0.001, 0.006):
            hanger = setup.heavy_rest_m + knot + spread
            threads.append(Thread(hanger, setup.heavy_thread_m, knot + 0.3 * spread, knot_up))
    return tuple(threads)


def _thread_look(scene: Scene, px_per_m: float) -> ThreadLook:
    threads = scene.threads
    return ThreadLook(
        np.array(threads.color, float),
        threads.opacity,
        thread_profile(threads.width_m * px_per_m, scene.camera.blur_px),
    )
