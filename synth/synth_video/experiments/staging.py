"""Everything of an experiment that can be painted before the first frame."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from synth_video.body_shapes import light_appearance
from synth_video.experiments.course import Course
from synth_video.moving_layers import Hanging, LayerSource, Moving
from synth_video.paint_background import WOOD, paint_background
from synth_video.paint_track import POST_M, paint_post, paint_rail
from synth_video.paint_wall import paint_wall, plate_film
from synth_video.pixels import Pixels, as_pixels
from synth_video.projection import Projection
from synth_video.raster import Raster, over, raster_for
from synth_video.scene import Scene
from synth_video.stage import (
    SHADOW_DROP_M,
    Stage,
    lamps_of,
    lens_of,
    paint_shadow,
    thread_appearance,
)
from synth_video.threads import Thread

TABLE_FRONT_M = 0.012
"""A table seen a little from above: from where the ball strikes down to its front edge."""


def set_experiment(
    scene: Scene, course: Course, projection: Projection, rng: np.random.Generator
) -> Stage:
    """Paint an experiment; ``rng`` decides the grain and what stands about.

    Raises
    ------
    UsageError
        If a body is too large to be painted.
    """
    bodies = _bodies(scene, course, projection)  # first: it refuses what would fill the memory
    raster = raster_for(projection, rng)
    sheet = paint_background(scene.background, raster)
    lens_m = scene.camera.blur_px / projection.px_per_m
    front: tuple[LayerSource, ...] = ()
    if scene.experiment.kind == "bounce":
        _paint_table(raster, sheet)
    elif scene.experiment.kind == "stops" or scene.ball.shape in ("block", "cart"):
        _paint_track(scene, raster, sheet)
    elif scene.experiment.kind == "pendulum":
        paint_wall(scene.wall, raster, sheet)
        front = (plate_film(scene.wall, raster, lens_m),)
    return Stage(
        projection=projection,
        still=raster.picture(sheet, lens_m),
        lamps=lamps_of(projection),
        layer_sources=(
            *_shadows(scene, course, projection),
            *_threads(scene, course, projection),
            *bodies,
            *front,
        ),
    )


def _paint_table(raster: Raster, sheet: Pixels) -> None:
    """Table whose top the ball strikes at height 0."""
    coarse, fine = raster.grain(40.0, 0.7), raster.grain(12.0, 0.3)
    grain = as_pixels(1 + 0.07 * (coarse + 0.6 * fine))
    wood = grain[..., None] * as_pixels(WOOD)
    over(sheet, raster.box(-5.0, 5.0, -TABLE_FRONT_M, TABLE_FRONT_M), as_pixels(1.18 * wood))
    over(sheet, raster.box(-5.0, 5.0, -5.0, -TABLE_FRONT_M), as_pixels(0.72 * wood))


def _paint_track(scene: Scene, raster: Raster, sheet: Pixels) -> None:
    """Rail under a block or a cart, with a stop at its end, at both or at none.

    A puck is seen from above: there is no rail, and the stops are bars.
    """
    ball, size_m, span_m = scene.ball, scene.setup.ball_diameter_m, scene.experiment.span_m
    if ball.shape == "puck":
        top_m, foot_m = size_m, -size_m
    else:
        top_m = 0.6 * (ball.height_m or size_m)
        foot_m = paint_rail(ball, size_m, raster, sheet)
    if scene.experiment.kind == "stops":
        for left_m in (-POST_M, span_m) if span_m else (-POST_M,):
            paint_post(left_m, foot_m, top_m, raster, sheet)


def _bodies(scene: Scene, course: Course, projection: Projection) -> tuple[LayerSource, ...]:
    """All bodies, each like the first but for what is printed on it."""
    lens, size_m = lens_of(scene, projection), scene.setup.ball_diameter_m
    marks = [scene.ball.mark, *"BCDE"] if scene.ball.mark else [""] * len(course.places)
    appearances = [
        replace(scene.ball, mark=mark) for mark, _ in zip(marks, course.places, strict=False)
    ]
    return tuple(
        Moving(light_appearance(appearance, size_m, lens), k)
        for k, appearance in enumerate(appearances)
    )


def _shadows(scene: Scene, course: Course, projection: Projection) -> tuple[LayerSource, ...]:
    """Soft shadows: on the table, behind a track, or beside what is seen from above."""
    size_px = scene.setup.ball_diameter_m * projection.px_per_m
    depth = scene.light.shadow
    if scene.ball.shape == "puck":
        image = paint_shadow(0.1 * size_px, 2.3 * size_px, projection.tilt_deg, depth)
        return tuple(
            Moving(image, k, shift_m=0.06 * scene.setup.ball_diameter_m)
            for k in range(len(course.places))
        )
    if scene.ball.shape in ("block", "cart") or scene.experiment.kind == "throw":
        return ()
    level_m = -SHADOW_DROP_M if course.hangers_m else 0.0
    image = paint_shadow(size_px, size_px, projection.tilt_deg, depth)
    return tuple(Moving(image, k, level_m=level_m) for k in range(len(course.places)))


def _threads(scene: Scene, course: Course, projection: Projection) -> tuple[LayerSource, ...]:
    """Two threads from each body that hangs, one toward the camera and one away from it."""
    appearance = thread_appearance(scene, projection.px_per_m)
    knot_up_m, length_m = scene.setup.ball_diameter_m / 2, scene.setup.light_thread_m
    return tuple(
        Hanging(
            tuple(Thread(rest_m + d, length_m, 0.4 * d, knot_up_m) for d in (0.001, 0.008)),
            appearance,
            body,
        )
        for body, rest_m in enumerate(course.hangers_m)
    )
