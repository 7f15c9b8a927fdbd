"""One clip from frames to tracks: decoded once, every moving body found and followed.

Which of the bodies are ball and heavy body is decided from their motion alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from types import TracebackType

import numpy as np
from numpy.typing import NDArray

from count_video.errors import TrackingError, UsageError
from count_video.footage.reader import Footage
from count_video.footage.store import PictureStore
from count_video.process import give_memory_back
from count_video.progress import NO_PROGRESS, Progress
from count_video.records import Floats, Track, WallSide
from count_video.signals import NOISE_AT_LEAST_PX, low_points, sigma_of
from count_video.tracking.bodies import Movers, find_movers
from count_video.tracking.following import Followed, was_followed
from count_video.tracking.pairing import SPAN_FRAMES, far_side_jump, pair_track
from count_video.tracking.samples import Thumbnails
from count_video.tracking.view import TrackSettings, View, view_of

PAIRS_AT_MOST = 3
"""So many pairs of bodies are offered, should the likeliest not collide."""
OPPOSITE_AT_LEAST = 0.05
"""Where contacts follow each other faster than the frames, opposite jumps do not show: pairs are
then ranked by what else they do, behind most that show some."""
PROGRESS_STEP = 16
ORDERED_SHARE = 0.75
"""Share of the common sightings in which the order of two neighbours holds."""
MIRROR_SHARE = 0.05
"""Places whose sum varies by less than this share of their difference are mirror images; where it
is the difference that hardly varies, they are parts of one body."""
NEAR_SHARE = 0.5
"""Outlines of bodies that touch overlap or leave a gap, but none of this share of their size."""
CONTACT_SPREAD_PX = 2.0
"""Two bodies touch at one distance: by so much it scatters between contacts."""


@dataclass(frozen=True)
class Observation:
    """A decoded clip with all bodies that move in it; a context manager that frees its pictures."""

    view: View
    frames: NDArray[np.intp]
    """Index of each picture, shape (n,); copies are left out."""
    pictures: PictureStore
    movers: Movers

    def __enter__(self) -> Observation:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.pictures.close()


def observe(
    footage: Footage, settings: TrackSettings, progress: Progress = NO_PROGRESS
) -> Observation:
    """Decode a clip once and follow everything that moves in it.

    Raises
    ------
    UsageError
        If the region does not fit into the picture, or the start into the clip.
    FootageError
        If the size of the picture changes on the way, or there is no room for its pictures.
    """
    view = view_of(footage, settings)
    pictures, thumbnails = PictureStore(), Thumbnails()
    frames: list[int] = []
    try:
        progress.start(footage.info.frames_promised, "tracking")
        for frame in view.frames():
            if not frame.repeats_previous:
                thumbnails.add(len(frames), pictures.append(frame.luma))
                frames.append(frame.index)
            if frame.index % PROGRESS_STEP == PROGRESS_STEP - 1:
                progress.advance(PROGRESS_STEP)
            del frame  # one picture of the decoder holds the memory of all
        if not frames and settings.start:
            raise UsageError(
                f"start {settings.start} leaves nothing of the clip, which has "
                f"{footage.report().frames_decoded} frames; give an earlier one"
            )
        give_memory_back()
        indices = np.array(frames, dtype=np.intp)
        return Observation(
            view, indices, pictures, find_movers(pictures, indices, thumbnails, _has_pair)
        )
    except BaseException:
        pictures.close()
        raise


def pair_tracks(seen: Observation, wall_side: WallSide | None) -> list[Track]:
    """Tracks of the pairs that may be ball and heavy body, the likeliest first.

    Raises
    ------
    TrackingError
        If no two bodies that could collide are found; the message says what was missing.
    """
    found = seen.movers.bodies
    if not found:
        raise TrackingError("nothing moves along a line as a rigid body does")
    pairs = [_ordered(*pair) for pair in combinations(found, 2)]
    ranked = sorted(
        ((_score(*pair), pair) for pair in pairs if _side_by_side(*pair)),
        key=lambda scored: -scored[0],
    )
    if not ranked:
        raise TrackingError("no two bodies move side by side")
    frames = seen.frames.astype(np.float64)
    tracks: list[Track] = []
    faults: list[TrackingError] = []
    for _, pair in ranked[:PAIRS_AT_MOST]:
        try:
            tracks.append(pair_track(pair, seen.movers, frames, (seen.view, wall_side)))
        except TrackingError as error:
            faults.append(error)
    if not tracks:
        raise faults[0]
    return tracks


def _has_pair(found: Sequence[Followed]) -> bool:
    """Whether two of the bodies move as ball and heavy body do."""
    pairs = [_ordered(*pair) for pair in combinations(found, 2)]
    return any(
        (pair[0].body.round_ or pair[1].body.round_) and _meet(*pair) and _score(*pair) > 0
        for pair in pairs
        if _side_by_side(*pair)
    )


def _meet(left: Followed, right: Followed) -> bool:
    """Whether two bodies come so near to each other that they may touch."""
    gap = right.edges_px[0] - left.edges_px[1]
    return float(np.nanmin(gap)) < NEAR_SHARE * _least_size_px(left, right)


def _least_size_px(left: Followed, right: Followed) -> float:
    """Width or height of two bodies, whichever is the least."""
    widths = (one.body.right_edge_px - one.body.left_edge_px for one in (left, right))
    return float(min(*widths, *(one.body.template.shape[0] for one in (left, right))))


def _ordered(one: Followed, other: Followed) -> tuple[Followed, Followed]:
    """Put the body on the left first."""
    apart = other.middle_px - one.middle_px
    known = np.isfinite(apart)
    if known.any() and float(np.median(apart[known])) < 0:
        return other, one
    return one, other


def _side_by_side(left: Followed, right: Followed) -> bool:
    """Whether two bodies are neighbours on one line that move each on its own."""
    if not (was_followed(left.x_px) and was_followed(right.x_px)):
        return False
    a, b = left.edges_px[1], right.edges_px[0]
    both = np.isfinite(a) & np.isfinite(b)
    apart = right.middle_px - left.middle_px
    if np.count_nonzero(both) < 4 or np.mean(apart[both] > 0) < ORDERED_SHARE:
        return False
    tops = [float(np.median(one.y_px[both])) for one in (left, right)]
    heights = [one.body.template.shape[0] for one in (left, right)]
    if tops[0] > tops[1] + heights[1] or tops[1] > tops[0] + heights[0]:
        return False
    return on_their_own(a[both], b[both])


def on_their_own(one_px: Floats, other_px: Floats) -> bool:
    """Whether two bodies move each on its own, by their places in the same pictures, shape (n,)."""
    together, apart = float(np.std(one_px + other_px)), float(np.std(one_px - other_px))
    return min(together, apart) > MIRROR_SHARE * max(together, apart)


def _score(left: Followed, right: Followed) -> float:
    """How much two bodies move as ball and heavy body do: in px per frame of velocity jumps.

    They repel each other, always at the same distance, and one of them bounces off something on
    its far side.
    """
    gap = right.edges_px[0] - left.edges_px[1]
    lows = low_points(gap, 6.0 * sigma_of(gap))
    spread = float(np.median(np.abs(gap[lows] - np.median(gap[lows])))) if len(lows) else 0.0
    walls = max(far_side_jump(left.edges_px[0]), far_side_jump(-right.edges_px[1]))
    size = _least_size_px(left, right)
    noise = max(float(np.nanmedian(np.hypot(left.sigma_px, right.sigma_px))), NOISE_AT_LEAST_PX)
    jumps = max(_opposite(left.x_px, right.x_px, lows), OPPOSITE_AT_LEAST)
    whole = (far_side_jump(gap) + walls) * size / noise
    return jumps * whole / (1 + (spread / CONTACT_SPREAD_PX) ** 2)


def _opposite(left_px: Floats, right_px: Floats, contacts: NDArray[np.intp]) -> float:
    """How much velocities jump in opposite directions, in one ratio: from 0 to 1.

    It is minus the correlation (about 0) of the two bodies' jumps at their contacts, by which
    momentum goes from one to the other.
    """
    jumps = np.array([_jumps(path, contacts) for path in (left_px, right_px)])
    known = np.isfinite(jumps).all(axis=0)
    left, right = jumps[:, known]
    size = float(np.sqrt((left @ left) * (right @ right)))
    return max(-float(left @ right) / size, 0.0) if size > 0 else 0.0


def _jumps(path_px: Floats, rows: NDArray[np.intp]) -> Floats:
    """Change of velocity at these rows, between means over some frames; NaN near the ends."""
    jumps = np.full(len(rows), np.nan)
    inner = (rows >= SPAN_FRAMES) & (rows < len(path_px) - SPAN_FRAMES)
    at = rows[inner]
    jumps[inner] = (
        path_px[at + SPAN_FRAMES] - 2 * path_px[at] + path_px[at - SPAN_FRAMES]
    ) / SPAN_FRAMES
    return jumps
