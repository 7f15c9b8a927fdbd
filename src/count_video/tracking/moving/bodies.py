"""Every rigid body that moves in a clip: found by its corners, learnt, and followed.

The order of work: samples in which things move by a few px, corners followed through them, rigid
groups of corners, a template for each group, the template registered in every picture.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import overload

import cv2
import numpy as np
from numpy.typing import NDArray

from count_video.records import Floats
from count_video.tracking.moving.corners import follow_corners
from count_video.tracking.moving.following import Followed, follow
from count_video.tracking.moving.proposals import at_full_size, propose, roughly, turned
from count_video.tracking.moving.rigid import scene_path
from count_video.tracking.moving.samples import Samples, choose_samples, median_picture
from count_video.tracking.moving.template import Background, Body, Box, Rough, learn, line_tilt_deg
from count_video.tracking.steadying.camera import Camera, Motion
from count_video.tracking.steadying.landmarks import clear_of
from count_video.tracking.steadying.standing import landmarks_of

Luma = NDArray[np.uint8]

CORNERS_WIDTH_PX = 960
"""Corners are followed in pictures no wider than this."""
PICTURES_AT_LEAST, PICTURE_AT_LEAST_PX = 12, 32
"""Shorter clips and smaller pictures show no motion to speak of."""
SMOOTHING_PX = 0.8
FLICKER_AT_LEAST = 0.01
"""Smaller changes of brightness are left as they are."""
UPRIGHT_DEG = 45.0
LANDMARKS_OF = 16
"""What stands still is learnt from so many samples."""
BACKGROUND_OF = 9
"""The background is the median of so many samples."""
STEADY_AT_LEAST = 6
SAME_BODY_PX = 1.0
"""Two templates whose distance varies by less than this are parts of one body."""
BODIES_AT_MOST, BODIES_ENOUGH = 4, 2
"""So many bodies are followed that have many corners; others only if these are fewer than two."""


@dataclass(frozen=True)
class Movers:
    """The bodies that move in a clip, those with most corners first."""

    bodies: list[Followed]
    """In pictures that are transposed where ``upright``."""
    tilt_deg: float
    """Direction of motion in those pictures, from their x axis."""
    upright: bool
    """True if the pictures were transposed because the bodies move up and down."""
    motion: Motion | None
    """How the camera moved, by image x and y; None where it stood."""


def find_movers(
    pictures: Sequence[Luma], frames: NDArray[np.intp], thumbnails: Sequence[Luma]
) -> Movers:
    """Find and follow all bodies that move in a clip.

    Parameters
    ----------
    pictures
        Lumas in order of time, n of them, each of shape (height, width).
    frames
        Frame index of each, shape (n,).
    thumbnails
        The same pictures, reduced by ``samples.thumbnail``.
    """
    if len(pictures) < PICTURES_AT_LEAST or min(pictures[0].shape) < PICTURE_AT_LEAST_PX:
        return Movers([], 0.0, upright=False, motion=None)
    samples = choose_samples(thumbnails)
    if len(samples.chosen) < 2:
        return Movers([], 0.0, upright=False, motion=None)
    small, scale = _levelled(pictures, samples)
    corners = follow_corners(small, samples.moved)
    scene = scene_path(corners)
    proposals = [at_full_size(one, scale) for one in propose(small, corners, scene)]
    if not proposals:
        return Movers([], 0.0, upright=False, motion=None)
    tilt = line_tilt_deg([one.path_px for one in proposals[:2]])
    upright = abs(tilt) > UPRIGHT_DEG
    if upright:
        proposals = [turned(one) for one in proposals]
        tilt = line_tilt_deg([one.path_px for one in proposals[:2]])
    roughs = roughly(proposals, frames[samples.chosen])
    motion = _camera_motion(pictures, samples, roughs, upright) if scene.any() else None
    shift = np.zeros((len(frames), 2)) if motion is None else np.nan_to_num(motion.shift_px)
    views = _Turned(pictures) if upright else pictures
    across = scene[:, ::-1] * scale if upright else scene * scale
    clip = _Clip(
        views,
        frames,
        _Sampled(views, dict(zip(frames[samples.chosen].tolist(), samples.chosen, strict=True))),
        _background(views, samples, frames, across),
        float(np.tan(np.radians(tilt))),
        shift[:, ::-1] if upright else shift,
    )
    followed = _followed(clip, roughs)
    if motion is not None:
        followed = [_less_sure(seen, motion, upright) for seen in followed]
    return Movers(followed, tilt, upright, motion)


class _Turned(Sequence[Luma]):
    """Pictures with x and y swapped."""

    def __init__(self, pictures: Sequence[Luma]) -> None:
        self._pictures = pictures

    def __len__(self) -> int:
        return len(self._pictures)

    @overload
    def __getitem__(self, place: int) -> Luma: ...
    @overload
    def __getitem__(self, place: slice) -> list[Luma]: ...
    def __getitem__(self, place: int | slice) -> Luma | list[Luma]:
        if isinstance(place, slice):
            return [picture.T for picture in self._pictures[place]]
        return self._pictures[place].T


class _Sampled(Mapping[int, Luma]):
    """Samples by their frame index, read when they are asked for: together they may be large."""

    def __init__(self, pictures: Sequence[Luma], rows: Mapping[int, int]) -> None:
        self._pictures, self._rows = pictures, rows

    def __getitem__(self, frame: int) -> Luma:
        return self._pictures[self._rows[frame]]

    def __iter__(self) -> Iterator[int]:
        return iter(self._rows)

    def __len__(self) -> int:
        return len(self._rows)


def _background(
    pictures: Sequence[Luma], samples: Samples, frames: NDArray[np.intp], scene_px: Floats
) -> Background:
    """Take the median of some samples, moved back by how far the camera has moved them."""
    some = np.linspace(0, len(samples.chosen) - 1, BACKGROUND_OF).astype(int)
    read = [pictures[samples.chosen[k]] for k in some]
    if scene_px.any():
        read = [_moved(one, -scene_px[k]) for one, k in zip(read, some, strict=True)]
    shifts = zip(frames[samples.chosen].tolist(), scene_px.tolist(), strict=True)
    return Background(median_picture(read), {frame: (x, y) for frame, (x, y) in shifts})


def _moved(picture: Luma, shift_px: Floats) -> Luma:
    """Move a picture to the right and down; its border goes on beyond it."""
    matrix = np.array([[1.0, 0.0, shift_px[0]], [0.0, 1.0, shift_px[1]]])
    size = picture.shape[1], picture.shape[0]
    moved = cv2.warpAffine(picture, matrix, size, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(moved, np.uint8)


@dataclass(frozen=True)
class _Clip:
    """What bodies are followed in; pictures lie so that the motion is nearer to their x axis."""

    pictures: Sequence[Luma]
    frames: NDArray[np.intp]
    samples: Mapping[int, Luma]
    """Frame index -> picture."""
    background: Background
    slope: float
    shift_px: Floats
    """The camera's motion, shape (n, 2)."""


def _followed(clip: _Clip, roughs: Sequence[Rough]) -> list[Followed]:
    """Learn and follow bodies, each only once."""
    found: list[Followed] = []
    for rough in roughs:
        enough = BODIES_AT_MOST if rough.patterned else BODIES_ENOUGH
        if len(found) >= enough:
            break
        if any(_holds(rough, other, clip.frames) for other in found):
            continue
        others = [other.path_px for other in roughs if other is not rough][:2]
        body = learn(clip.samples, clip.background, rough, others)
        if body is None or any(_part_of(body, other, clip) for other in found):
            continue
        seen = follow(clip.pictures, clip.frames, body, clip.slope, clip.shift_px)
        if not any(_same(seen, other) for other in found):
            found.append(seen)
    return found


def _holds(rough: Rough, other: Followed, frames: NDArray[np.intp]) -> bool:
    """Whether the box of a proposal holds the middle of a known body in most of its samples."""
    rows = np.searchsorted(frames, np.array(list(rough.path_px)))
    path = np.array(list(rough.path_px.values()))
    x = other.middle_px[rows] - path[:, 0]
    y = other.y_px[rows] + other.body.sprite.shape[0] / 2 - path[:, 1]
    left, top, right, bottom = rough.box
    inside = (x > left) & (x < right) & (y > top) & (y < bottom)
    return bool(inside.mean() > 0.5)


def _less_sure(seen: Followed, motion: Motion, upright: bool) -> Followed:
    """Add the camera's uncertainty; where its shift is not known, no body has a place."""
    sigma = np.hypot(seen.sigma_px, motion.sigma_px[:, 1 if upright else 0])
    known = np.isfinite(sigma)
    x, y = (np.where(known, place, np.nan) for place in (seen.x_px, seen.y_px))
    return replace(seen, x_px=x, y_px=y, sigma_px=sigma)


def _levelled(pictures: Sequence[Luma], samples: Samples) -> tuple[list[Luma], int]:
    """Bring samples to one brightness and width; return how many px one of theirs holds, too."""
    scale = max(1, -(-pictures[0].shape[1] // CORNERS_WIDTH_PX))
    level = []
    for k, gain in zip(samples.chosen, samples.gains, strict=True):
        smooth = cv2.GaussianBlur(_reduced(pictures[k], scale), (0, 0), SMOOTHING_PX)
        lamp = gain if abs(gain - 1) > FLICKER_AT_LEAST else 1.0
        level.append(np.asarray(cv2.convertScaleAbs(smooth, alpha=lamp), np.uint8))
    return level, scale


def _reduced(picture: Luma, scale: int) -> Luma:
    if scale == 1:
        return picture
    size = picture.shape[1] // scale, picture.shape[0] // scale
    return np.asarray(cv2.resize(picture, size, interpolation=cv2.INTER_AREA), np.uint8)


def _camera_motion(
    pictures: Sequence[Luma], samples: Samples, roughs: Sequence[Rough], upright: bool
) -> Motion | None:
    some = np.linspace(0, len(samples.chosen) - 1, LANDMARKS_OF).astype(int)
    landmarks = landmarks_of([pictures[samples.chosen[k]] for k in some])
    if landmarks is None:
        return None
    camera = Camera(clear_of(landmarks, [_swept(rough, upright) for rough in roughs[:2]]))
    for picture in pictures:
        camera.see(picture)
    return camera.motion()


def _swept(rough: Rough, upright: bool) -> Box:
    """Box that a body passes over, in the pictures as they are."""
    x, y = np.array(list(rough.path_px.values())).T
    left, top, right, bottom = rough.box
    box = (
        float(x.min()) + left,
        float(y.min()) + top,
        float(x.max()) + right,
        float(y.max()) + bottom,
    )
    return (box[1], box[0], box[3], box[2]) if upright else box


def _part_of(body: Body, other: Followed, clip: _Clip) -> bool:
    """Whether a template, where it was learnt, keeps its distance from a body that was followed."""
    rows = np.searchsorted(clip.frames, np.array(body.learnt))
    places = np.array([body.sightings[frame][0] for frame in body.learnt])
    return _steady(other.x_px[rows] - (places - clip.shift_px[rows, 0]))


def _same(one: Followed, other: Followed) -> bool:
    """Whether two templates are parts of one body."""
    return _steady(one.x_px - other.x_px)


def _steady(apart_px: Floats) -> bool:
    """Whether a distance hardly varies."""
    known = apart_px[np.isfinite(apart_px)]
    if len(known) < STEADY_AT_LEAST:
        return False
    return float(np.quantile(np.abs(known - np.median(known)), 0.9)) < SAME_BODY_PX
