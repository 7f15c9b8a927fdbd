"""A ball that spins is followed by its silhouette: its markings do not move it."""

import numpy as np
from drawn import SAMPLES, as_frames, background, to_luma

from count_video.records import Frame
from count_video.tracking.follow import Follower
from count_video.tracking.silhouettes.silhouette import Beside
from count_video.tracking.silhouettes.unsteady import Line, find_unsteady

SHAPE, RADIUS, ROW = (112, 320), 18.0, 56.0
FRAMES, TURN_FRAMES = 96, 40
SEAM_PX = 1.0
"""Where a seam meets the rim the silhouette may lose the blur of the lens, a px or so, on one side:
that moves the middle by half as much."""
UNBIASED_PX = SEAM_PX / 2


def place(frame: int) -> float:
    """Image x of the ball, to and fro."""
    return 200.0 + 70.0 * float(np.cos(2 * np.pi * frame / FRAMES))


def drawn(spins: bool) -> list[Frame]:
    """Draw a ball, one half lighter than the backdrop and one darker, that turns if asked."""
    rng = np.random.default_rng(5)
    fine = (np.arange(-30 * SAMPLES, 30 * SAMPLES) + 0.5) / SAMPLES
    pictures = []
    for frame in range(FRAMES):
        left = int(place(frame)) - 30
        x, y = np.meshgrid(left - 0.5 + 30 + fine - place(frame), fine - 0.5)
        depth = np.sqrt(np.clip(RADIUS**2 - x**2 - y**2, 0, None))
        turn = 2 * np.pi * frame / TURN_FRAMES if spins else 0.7
        light = x * np.cos(turn) - depth * np.sin(turn) > 0
        canvas = background(SHAPE, 3)
        part = canvas[int(ROW) - 30 : int(ROW) + 30, left : left + 60]
        behind = np.kron(part, np.ones((SAMPLES, SAMPLES)))
        shown = np.where(np.hypot(x, y) < RADIUS, np.where(light, 225.0, 60.0), behind)
        part[:] = shown.reshape(60, SAMPLES, 60, SAMPLES).mean(axis=(1, 3))
        pictures.append(to_luma(canvas, 0.8, rng))
    return as_frames(pictures)


def beside() -> Beside:
    """Return the part of the pictures to the right of a body at the left border."""
    return Beside(dict.fromkeys(range(FRAMES), 10.0), 1)


def in_runs(frames: list[Frame]) -> list[list[Frame]]:
    """Cut frames into runs as a pilot does."""
    return [frames[first : first + 12] for first in range(0, FRAMES, 12)]


def test_markings_that_turn_do_not_move_a_ball() -> None:
    frames = drawn(spins=True)
    found = find_unsteady(in_runs(frames), beside(), Line(160.0, ROW, 0.0))
    assert found is not None
    body, backdrop = found
    follower = Follower(body, 0.0)
    for seen in frames:
        follower.see(seen.index, backdrop.silhouette(seen.index, seen.luma))
    error = np.array(follower.x_px) - [place(frame) for frame in range(FRAMES)]
    assert np.sqrt(np.mean((error - error.mean()) ** 2)) < UNBIASED_PX


def test_a_ball_that_keeps_its_look_is_left_to_its_look() -> None:
    found = find_unsteady(in_runs(drawn(spins=False)), beside(), Line(160.0, ROW, 0.0))
    assert found is None
