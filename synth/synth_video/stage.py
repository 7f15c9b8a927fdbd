"""Everything of a scene that can be painted before the first frame."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from synth_video.body_picture import BodyPicture, Pixels, as_pixels, body_canvas
from synth_video.experiments.course import Course
from synth_video.moving_layers import (
    Hanging,
    LayerSource,
    Lens,
    Moving,
    Thread,
    ThreadAppearance,
    heavy_appearance,
    light_appearance,
    thread_profile,
)
from synth_video.paint_apparatus import (
    POST_M,
    mirror_mask,
    paint_post,
    paint_rail,
    paint_wall,
    plate_clamp,
    plate_film,
)
from synth_video.paint_background import TABLE_DEPTH_M, WOOD, paint_background
from synth_video.projection import Projection
from synth_video.raster import Raster, over, raster_for
from synth_video.scene import Scene
from synth_video.things import before, behind

LAMPS = ((0.24, 0.05, 0.9), (0.42, 0.07, 1.1), (0.62, 0.06, 0.8), (0.84, 0.08, 1.0))
"""Middle and half width of what the brass mirrors, in picture widths, and its strength."""


BALL, HEAVY = 0, 1
"""Order of the bodies in a trial's paths."""
SHADOW_DROP_M = TABLE_DEPTH_M + 0.014
"""From the axis at rest down to where the shadows lie."""


@dataclass(frozen=True)
class Stage:
    """The still picture and what moves before it, in tilted coordinates (wall on the left)."""

    projection: Projection
    still: Pixels
    """Background and wall, shape (h, w, 3)."""
    lamps: Pixels
    """What polished brass mirrors at each place, shape (h, w, 3)."""
    layer_sources: tuple[LayerSource, ...]
    """The farthest first."""


def set_stage(
    scene: Scene, projection: Projection, rng: np.random.Generator, course: Course | None = None
) -> Stage:
    """Paint what a scene shows; ``rng`` decides the grain and what stands about.

    Parameters
    ----------
    course
        Needed for the bodies of other experiments than ball, cylinder and wall.

    Raises
    ------
    UsageError
        If a body is too large to be painted.
    """
    if course is None or scene.experiment.kind == "pi":
        return _set_trial(scene, projection, rng)
    return _set_experiment(scene, course, projection, rng)


def _set_trial(scene: Scene, projection: Projection, rng: np.random.Generator) -> Stage:
    bodies = _bodies(scene, projection)  # first: it refuses what would fill the memory
    raster = raster_for(projection, rng)
    sheet = paint_background(scene.background, raster)
    paint_wall(scene.wall, raster, sheet)
    if scene.setup.mounting != "suspended" and scene.ball.shape in ("block", "cart"):
        paint_rail(scene.ball, scene.setup.ball_diameter_m, raster, sheet)
    lens = lens_of(scene, projection)
    lens_m = lens.blur_px / lens.px_per_m
    return Stage(
        projection=projection,
        still=raster.picture(sheet, lens_m),
        lamps=lamps_of(projection),
        layer_sources=(
            *behind(scene, projection, lens, rng),
            *_shadows(scene, projection),
            *_mirror_image(scene, projection, raster),
            *_threads(scene, projection.px_per_m),
            *bodies,
            plate_film(scene.wall, raster, lens_m),
            plate_clamp(scene.wall, raster, lens_m),
            *before(scene, raster, lens),
        ),
    )


def _shadows(scene: Scene, projection: Projection) -> tuple[LayerSource, ...]:
    """Soft shadows of cylinder and ball on the table; none where they run on a rail."""
    scale, tilt, depth = projection.px_per_m, projection.tilt_deg, scene.light.shadow
    length_m, diameter_m = scene.cylinder.length_m, scene.setup.ball_diameter_m
    if scene.setup.mounting != "suspended":
        return ()
    heavy = paint_shadow(length_m * scale, scene.cylinder.diameter_m * scale, tilt, depth)
    ball = paint_shadow(diameter_m * scale, diameter_m * scale, tilt, depth)
    return (
        Moving(heavy, HEAVY, shift_m=length_m / 2, level_m=-SHADOW_DROP_M),
        Moving(ball, BALL, level_m=-SHADOW_DROP_M),
    )


def _mirror_image(scene: Scene, projection: Projection, raster: Raster) -> tuple[LayerSource, ...]:
    """Paint the ball as the wall mirrors it; nothing for a wall that mirrors nothing."""
    if not scene.wall.reflection:
        return ()
    lens = lens_of(scene, projection)
    mask = raster.picture(mirror_mask(scene.wall, raster), lens.blur_px / lens.px_per_m)
    image = light_appearance(scene.ball, scene.setup.ball_diameter_m, lens, reflected=True)
    return (Moving(image, BALL, mirrored=True, strength=mask[..., None]),)


def _threads(scene: Scene, px_per_m: float) -> tuple[LayerSource, ...]:
    """Those of the cylinder and of the ball, where the bodies hang."""
    if scene.setup.mounting != "suspended":
        return ()
    appearance = thread_appearance(scene, px_per_m)
    return Hanging(_cylinder_threads(scene), appearance, HEAVY), Hanging(
        _ball_threads(scene), appearance, BALL
    )


def _bodies(scene: Scene, projection: Projection) -> tuple[LayerSource, ...]:
    """Paint the heavy body and, in front of it unless it shows its rim, the light one."""
    lens = lens_of(scene, projection)
    ball = light_appearance(scene.ball, scene.setup.ball_diameter_m, lens)
    bodies = Moving(heavy_appearance(scene.cylinder, lens), HEAVY), Moving(ball, BALL)
    return bodies[::-1] if scene.cylinder.rim_m else bodies


def lens_of(scene: Scene, projection: Projection) -> Lens:
    """How the camera sees the bodies of a scene."""
    return Lens(projection.px_per_m, projection.tilt_deg, scene.camera.blur_px)


def lamps_of(projection: Projection) -> Pixels:
    """Bright patches along the picture: windows and lamps as the brass mirrors them."""
    place = np.arange(projection.width_px) / projection.width_px
    bright = np.full_like(place, 0.1)
    for middle, width, strength in LAMPS:
        bright += strength * np.exp(-(((place - middle) / width) ** 4))
    row = np.multiply.outer(bright, np.array([150.0, 150.0, 132.0])).astype(np.float32)
    return np.repeat(row[None], projection.height_px, axis=0)


def paint_shadow(length_px: float, depth_px: float, tilt_deg: float, depth: float) -> BodyPicture:
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


def thread_appearance(scene: Scene, px_per_m: float) -> ThreadAppearance:
    """Colour and profile of the threads at a picture's scale."""
    threads = scene.threads
    return ThreadAppearance(
        np.array(threads.color, float),
        threads.opacity,
        thread_profile(threads.width_m * px_per_m, scene.camera.blur_px),
    )


# ---- other experiments than ball, cylinder and wall ----------------------------------------------

TABLE_FRONT_M = 0.012
"""A table seen a little from above: from where the ball strikes down to its front edge."""


def _set_experiment(
    scene: Scene, course: Course, projection: Projection, rng: np.random.Generator
) -> Stage:
    bodies = _like_bodies(scene, course, projection)  # first: it refuses what would fill the memory
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
            *_own_shadows(scene, course, projection),
            *_own_threads(scene, course, projection),
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


def _like_bodies(scene: Scene, course: Course, projection: Projection) -> tuple[LayerSource, ...]:
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


def _own_shadows(scene: Scene, course: Course, projection: Projection) -> tuple[LayerSource, ...]:
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


def _own_threads(scene: Scene, course: Course, projection: Projection) -> tuple[LayerSource, ...]:
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
