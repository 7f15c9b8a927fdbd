"""Everything that moves before a scenery that stands still, as paths through the clip.

The scenery is learnt twice: from all pictures first, then from where the first look saw no body.
The second look finds patches that stand out by a good part of what the body itself does, which
leaves shadows and changes of the light behind.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from count_video.errors import TrackingError
from count_video.footage.reader import Footage
from count_video.progress import Progress
from count_video.records import Frame
from count_video.tracking.patches.blobs import Blob, Sight, see
from count_video.tracking.patches.paths import LOST_PICTURES, Path, join
from count_video.tracking.patches.scenery import (
    PICTURES,
    Luma,
    Mask,
    Scenery,
    learn_again,
    learn_scenery,
    shrink_factor,
    shrunk,
    without_ghost,
)
from count_video.tracking.patches.surroundings import ALTERED_SHARE
from count_video.tracking.view import TrackSettings, cropped

BODY_LEVELS_SHARE = 0.4
"""A patch of the second look differs by at least this share of what the body differs by."""
HIDDEN_SHARE = 0.6
"""Half the box that a body may cover, as a share of its patch's width and height."""
HIDDEN_WORTH = 0.1
"""Whatever is worth this share of the first path is taken for a body here."""
BORDER_PX = 3.0
BORDER_STEPS = 2.0
PICTURES_AT_REST = 5
REST_SIZES = 0.15
"""A patch seen in so many pictures that moves by less than this share of its size rests."""
LOOKS = 2
"""How often the scenery is learnt again."""
COVERED_AT_MOST = 0.3
"""Where more of the picture differs from the scenery in most frames, the camera moves."""
ALTERED_AT_MOST = 0.3
PICTURES_AT_LEAST = 12


@dataclass(frozen=True)
class Movers:
    """What moves in a clip."""

    sights: tuple[Sight, ...]
    """Of every picture that is no copy, in order."""
    paths: tuple[Path, ...]
    """The path that is most worth following first."""
    scenery: Scenery

    @property
    def scale(self) -> int:
        """Pixels of the footage for one px of sights and paths."""
        return self.scenery.scale


def find_movers(footage: Footage, settings: TrackSettings, progress: Progress) -> Movers:
    """Find what moves, and follow it.

    Raises
    ------
    TrackingError
        If nothing moves, the camera does, or the clip shows several scenes.
    """
    width = footage.info.width_px if settings.region is None else settings.region[2]
    scale = shrink_factor(width)
    kept = _spread_over(footage, settings, scale)
    if len(kept) < PICTURES_AT_LEAST:
        raise TrackingError(f"only {len(kept)} different pictures: too few to show collisions")
    pictures = list(kept.values())
    scenery = learn_scenery(pictures, scale)
    progress.start(footage.info.frames_promised, "tracking")
    sights = _look(footage, settings, scenery, 0.0)
    for _ in range(LOOKS):
        sights = _without_titles(sights)
        paths = ranked(join(sights))
        if not paths:
            raise TrackingError("nothing moves in this clip")
        worthy = [path for path in paths if path.worth > HIDDEN_WORTH * paths[0].worth]
        hidden = _hidden(worthy, sights, list(kept), pictures[0].shape)
        scenery = learn_again(pictures, hidden, scenery)
        scenery = _without_ghosts(scenery, sights, kept)
        levels = BODY_LEVELS_SHARE * paths[0].contrast
        sights = _look(footage, settings, scenery, levels)
    sights = _without_titles(sights)
    return Movers(tuple(sights), tuple(ranked(join(sights))), scenery)


def ranked(paths: Sequence[Path]) -> list[Path]:
    """Sort paths by what speaks for a body: seen often, going far, standing out."""
    moving = [path for path in paths if path.worth > 0]
    return sorted(moving, key=lambda path: -path.worth)


def _spread_over(footage: Footage, settings: TrackSettings, scale: int) -> dict[int, Luma]:
    """Keep shrunk pictures evenly spread over the clip, whatever its length: frame to picture."""
    kept: dict[int, Luma] = {}
    stride = 1
    for place, frame in enumerate(fresh(footage, settings)):
        if place % stride == 0:
            kept[frame.index] = shrunk(cropped(frame, settings.region).luma, scale).copy()
        if len(kept) >= 2 * PICTURES:
            stride *= 2
            kept = dict(list(kept.items())[::2])
    return kept


def fresh(footage: Footage, settings: TrackSettings) -> Iterator[Frame]:
    """Stream the frames that are no copies, in the order of the sights."""
    frames = footage.frames(settings.start, settings.end)
    return (frame for frame in frames if not frame.repeats_previous)


def _look(
    footage: Footage, settings: TrackSettings, scenery: Scenery, levels: float
) -> list[Sight]:
    return [
        see(
            frame.index,
            shrunk(cropped(frame, settings.region).luma, scenery.scale),
            scenery,
            levels,
        )
        for frame in fresh(footage, settings)
    ]


def _without_titles(sights: Sequence[Sight]) -> list[Sight]:
    """Empty the sights that show another scene; refuse clips without one that stands still."""
    covered = np.array([sight.covered for sight in sights])
    usual = float(np.median(covered))
    if usual > COVERED_AT_MOST:
        raise TrackingError(
            "most of the picture moves: the camera must stand still and look at bodies that are "
            "small in the picture"
        )
    altered = covered > usual + ALTERED_SHARE
    if float(np.mean(altered)) > ALTERED_AT_MOST:
        raise TrackingError(
            "the clip shows more than one scene; give the one that counts with --start and --end"
        )
    return [
        replace(sight, blobs=()) if other else sight
        for sight, other in zip(sights, altered, strict=True)
    ]


def _without_ghosts(scenery: Scenery, sights: Sequence[Sight], kept: dict[int, Luma]) -> Scenery:
    """Take out of the scenery what rested for most of the clip, by the patches that never move."""
    for path in join(sights):
        rests = len(path.rows) >= PICTURES_AT_REST and path.sweep_px < REST_SIZES * path.size_px
        shown = [
            (sights[row].frame, blob)
            for row, blob in zip(path.rows, path.blobs, strict=True)
            if sights[row].frame in kept
        ]
        if rests and shown:
            frame, blob = shown[len(shown) // 2]
            left, top = (int(blob.x_px - blob.width_px / 2), int(blob.y_px - blob.height_px / 2))
            patch = np.zeros(scenery.luma.shape, dtype=np.uint8)
            patch[
                max(0, top) : top + int(blob.height_px) + 1,
                max(0, left) : left + int(blob.width_px) + 1,
            ] = 1
            scenery = without_ghost(scenery, patch, kept[frame])
    return scenery


def _hidden(
    paths: Sequence[Path], sights: Sequence[Sight], frames: Sequence[int], shape: tuple[int, ...]
) -> list[Mask]:
    """Masks of where bodies may be, one for each of the frames."""
    number = {sight.frame: row for row, sight in enumerate(sights)}
    masks = [np.zeros(shape, dtype=np.uint8) for _ in frames]
    for path in paths:
        first, last = _there(path, paths, shape)
        widths = np.array([blob.width_px for blob in path.blobs])
        heights = np.array([blob.height_px for blob in path.blobs])
        for mask, row in zip(masks, (number[frame] for frame in frames), strict=True):
            if not first <= row <= last:
                continue
            x, y = (float(np.interp(row, path.rows, place)) for place in (path.x_px, path.y_px))
            across, down = (
                HIDDEN_SHARE * max(float(np.median(size)), float(np.interp(row, path.rows, size)))
                for size in (widths, heights)
            )
            rows = slice(max(0, int(y - down)), int(y + down) + 1)
            mask[rows, max(0, int(x - across)) : int(x + across) + 1] = 1
    return masks


def _there(path: Path, paths: Sequence[Path], shape: tuple[int, ...]) -> tuple[float, float]:
    """First and last picture in which a path's body may be where the path begins or ends.

    No body appears or vanishes in the midst of the picture: it rested there, for scenery, unless it
    is the one whose path ended before, or begins after.
    """
    first, last = path.rows[0] - LOST_PICTURES, path.rows[-1] + LOST_PICTURES
    if _amid(path.blobs[0], path.blobs[1:2], shape):
        ended = [other.rows[-1] for other in paths if other.rows[-1] < path.rows[0]]
        first = min(first, max(ended, default=-1) + 1)
    if _amid(path.blobs[-1], path.blobs[-2:-1], shape):
        begun = [float(other.rows[0]) for other in paths if other.rows[0] > path.rows[-1]]
        return first, max(last, min(begun, default=np.inf) - 1)
    return first, last


def _amid(blob: Blob, neighbour: Sequence[Blob], shape: tuple[int, ...]) -> bool:
    """Whether a patch is farther from the picture's border than it moves in two pictures."""
    step = max((np.hypot(b.x_px - blob.x_px, b.y_px - blob.y_px) for b in neighbour), default=0.0)
    right, bottom = blob.left_px + blob.width_px, blob.top_px + blob.height_px
    space = min(blob.left_px, blob.top_px, shape[1] - right, shape[0] - bottom)
    return bool(space > BORDER_PX + BORDER_STEPS * step)
