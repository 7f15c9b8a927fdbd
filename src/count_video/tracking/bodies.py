"""Every rigid body that moves in a clip: found by its corners, learnt, and followed.

The order of work: samples in which things move by a few px, corners followed through them, rigid
groups of corners, a template for each group. What the bodies known so far leave unexplained shows
more of them. Each is then learnt again without what the others hide, and registered in every
picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from count_video.records import Floats, Indices, Luma
from count_video.tracking.background import Background, agree_better, background_of
from count_video.tracking.camera import Motion, camera_motion, scenery
from count_video.tracking.corners import Trajectories, follow_corners
from count_video.tracking.following import Clip, Followed, follow
from count_video.tracking.layers import BODIES_AT_MOST, add_bodies, apart, learn_again
from count_video.tracking.learning import Body
from count_video.tracking.pairing import Movers, has_pair
from count_video.tracking.paths import Rough, direction_deg, unsteadiness
from count_video.tracking.proposals import propose, roughly
from count_video.tracking.regions import find_regions, reduced_for_regions
from count_video.tracking.rigid import RigidGroup, scene_path
from count_video.tracking.samples import Samples, Thumbnails, choose_samples
from count_video.tracking.sequences import Lumas, Made, chosen, prepared
from count_video.tracking.shape import Box, Part, Shape, known_of, size_of
from count_video.tracking.turning import Turns, camera_turns, turned_back
from count_video.video.store import PictureStore

PICTURES_AT_LEAST, PICTURE_AT_LEAST_PX = 12, 32
"""Shorter clips and smaller pictures show no motion to speak of."""
UPRIGHT_DEG = 45.0
TREMBLE_OF = 32
"""That the camera stands still shows in so many samples."""
CORNERS_SIGMA_PX = 0.1
"""Standard uncertainty of the camera's path by corners, of which each errs by 0.1 to 0.3 px, in px
of the samples."""
WIDTHS = 1, 5, 15, 45
"""The camera's path is tried as it was measured, and as its mean over so many pictures."""
SETTLED_PX = 2.0
"""Outlines whose sizes change by more than this are learnt once more."""
ROUNDS = 4
"""So often bodies are sought in what those that are known leave unexplained."""


NOTHING_MOVES = Movers([], 0.0, upright=False, shift_px=None)


def find_movers(pictures: Sequence[Luma], frames: Indices, thumbnails: Thumbnails) -> Movers:
    """Find and follow all bodies that move in a clip.

    ``pictures`` are in order of time, n of them, ``frames`` their indices, shape (n,), and
    ``thumbnails`` some of them, reduced; they are taken out of it.
    """
    if len(pictures) < PICTURES_AT_LEAST or min(pictures[0].shape) < PICTURE_AT_LEAST_PX:
        return NOTHING_MOVES
    samples = choose_samples(thumbnails.taken())
    if len(samples.chosen) < 2:
        return NOTHING_MOVES
    scene = _Scene(pictures, samples)
    turns = scene.camera_turns()
    if turns is None:
        return _movers_in(scene, frames)
    everywhere = np.interp(np.arange(len(frames)), samples.chosen, turns)
    with PictureStore() as level:
        for picture, turn in zip(pictures, everywhere, strict=True):
            level.append(turned_back(picture, turn))
        turned = _Scene(level, samples, scene.corners_turned_back(turns))
        return replace(_movers_in(turned, frames), turns=everywhere)


def _movers_in(scene: _Scene, frames: Indices) -> Movers:
    """Find and follow the bodies of a scene, which the camera may shift, and no more."""
    proposed = scene.proposals()
    if not proposed:
        return NOTHING_MOVES
    tilt = direction_deg(scene.placed(proposed))
    upright = scene.upright = abs(tilt) > UPRIGHT_DEG
    roughs, lumas, rows = scene.placed(proposed), scene.pictures, scene.samples.chosen
    if upright:
        tilt = (180.0 - tilt) % 180.0 - 90.0  # from y
        lumas = Made(lambda place: scene.pictures[place].T)
    few = chosen(lumas, rows)
    clip = Clip(lumas, frames, rows, scene.background(few), np.zeros((len(frames), 2)))
    motion = _camera_motion(clip, scene, roughs)
    if motion is not None:
        path = motion.everywhere_px
        scene.shift_px = path[rows][:, scene.axes] / scene.scale
        clip = replace(clip, background=scene.background(few), shift_px=path)
    followed = _followed(clip, scene, roughs)
    if motion is None:
        return Movers(followed, tilt, upright, None)
    shift = _steadiest(followed, motion, clip)
    followed = [seen.moved(clip.shift_px - shift) for seen in followed]
    if not shift.any():
        return Movers(followed, tilt, upright, None)
    followed = [_less_sure(seen, motion) for seen in followed]
    return Movers(followed, tilt, upright, shift[:, scene.axes])


def _steadiest(followed: Sequence[Followed], motion: Motion, clip: Clip) -> Floats:
    """Find the path of the camera, shape (n, 2), without which bodies move most steadily.

    Encoders let the background stand while the camera drifts on, and move it in steps, which a mean
    over some pictures levels.
    """
    paths = [seen.xy_px + clip.shift_px for seen in followed]
    tried = [np.zeros_like(clip.shift_px), *(motion.smoothed_px(width) for width in WIDTHS)]
    return min(tried, key=lambda shift: unsteadiness([one - shift for one in paths], clip.frames))


def _camera_motion(clip: Clip, scene: _Scene, roughs: Sequence[Rough]) -> Motion | None:
    """Measure the camera's motion; None unless the samples agree better without it.

    Where corners show none it is measured only if a few samples do. Where they do, and no scenery
    shows it sharply, their path stands, which was compared when the scene was made.
    """
    # What only a region or few corners show may be scenery.
    swept = [_swept(rough) for rough in roughs if rough.sure]
    few, roughly = clip.sampled(), clip.background.shift_px
    parts = scenery(few.pictures, clip.background, swept)
    if not scene.shift_px.any():
        some = np.arange(len(roughly))[:: 1 + len(roughly) // TREMBLE_OF]
        if camera_motion(parts, chosen(few.pictures, some), roughly[some]) is None:
            return None
    between = np.stack([np.interp(clip.frames, few.frames, along) for along in roughly.T], axis=1)
    motion = camera_motion(parts, clip.pictures, between)
    if motion is None and scene.shift_px.any():
        return Motion(between, np.full_like(between, CORNERS_SIGMA_PX * scene.scale))
    agree = motion is not None and scene.agrees_better_moved(motion.everywhere_px[clip.samples])
    return motion if agree else None


def _followed(clip: Clip, scene: _Scene, roughs: Sequence[Rough]) -> list[Followed]:
    """Find bodies in the samples, round after round, and follow them through all pictures."""
    few = clip.sampled()
    found: list[Followed] = []
    in_vain: list[Rough] = []
    settled: list[bool] = []
    for number in range(ROUNDS):
        known = len(found)
        if number > 0:
            roughs = scene.placed(scene.proposals([few.shape(seen) for seen in found]))
        more, in_vain = add_bodies(few, roughs, found, in_vain)
        as_they_are = [any(one is seen for seen in found) for one in more]
        if all(as_they_are):
            break  # of what is left, nothing can be followed
        few, found, settled = _learnt_again(few, scene, more, as_they_are)
        if number > 0:  # what is known by now hides those that were learnt before
            settled = [False] * len(found)
        if len(found) <= known or len(found) >= BODIES_AT_MOST or has_pair(found):
            break
    if not all(settled):
        again, kept, _ = _learnt_again(few, scene, found, settled)
        # Unless one shows an outline no more, and nothing comes in its place.
        if len(kept) == len(found):
            few, found = again, kept
    clip = replace(clip, background=few.background)
    return apart([follow(clip, seen.body) for seen in found])


def _learnt_again(
    few: Clip, scene: _Scene, found: Sequence[Followed], as_they_are: Sequence[bool]
) -> tuple[Clip, list[Followed], list[bool]]:
    """Learn the background without the bodies, and those anew that do not stay as they are.

    What an outline does not cover yet is in the background, and what it covers too much is not: the
    outlines are learnt until they stay as they are, and which do is returned as well. What shows no
    outline now was none: a place where the background held a body, or part of two.
    """
    before = [few.shape(seen) for seen in found]
    few = replace(few, background=scene.background(few.pictures, before))
    bodies: list[Followed] = []
    settled: list[bool] = []
    for seen, shape, stays in zip(found, before, as_they_are, strict=True):
        if stays:
            body: Body | None = seen.body
        else:
            body = learn_again(few, seen, found)
        if body is not None:
            bodies.append(few.as_learnt(body))
            change = np.subtract(size_of(shape.box), size_of(body.box))
            settled.append(bool(np.abs(change).max() < SETTLED_PX))
    return few, bodies, settled


class _Scene:
    """The samples, made alike and small, and what moves in them."""

    def __init__(
        self, pictures: Sequence[Luma], samples: Samples, corners: Trajectories | None = None
    ) -> None:
        small = prepared(pictures, samples)
        self.pictures: Lumas = pictures
        self.samples = samples
        self.scale, self._corner_px = small.scale, small.corner_px
        self.upright = False
        """Whether x and y of the pictures are swapped; those of the samples never are."""
        self._corners = corners or follow_corners(small.pictures, samples.moved)
        self.shift_px: Floats = scene_path(self._corners, small.pictures[0].shape)
        """How far the camera has moved each sample, in its px, shape (samples, 2)."""
        self._shape, still = small.pictures[0].shape, np.zeros_like(self.shift_px)
        self._small, self._scale = reduced_for_regions(small.pictures)
        moved = self._small, self.shift_px / self._scale
        if self.shift_px.any() and not agree_better(self._small, still, *moved):
            self.shift_px = still
        self._all_change = 0.0
        """Sum of what changes in a sample: known once all that moves was sought."""

    @property
    def axes(self) -> list[int]:
        """Which axis of a sample is x of the pictures, and which is y."""
        return [1, 0] if self.upright else [0, 1]

    def camera_turns(self) -> Turns | None:
        """How the camera turned and scaled each sample; None where it did not.

        Two bodies that near each other look as a zoom does: turned back, the samples have to agree
        better with their median.
        """
        turns = camera_turns(self._corners, self._shape)
        if turns is None:
            return None
        rows, columns = self._shape
        corners = self._corners.turned_back(turns, complex(columns - 1, rows - 1) / 2)
        back = [turned_back(one, turn) for one, turn in zip(self._small, turns, strict=True)]
        as_it_is, turned = self.shift_px, scene_path(corners, self._shape)
        before, after = (self._small, as_it_is / self._scale), (back, turned / self._scale)
        return turns if agree_better(*before, *after) else None

    def agrees_better_moved(self, shift_px: Floats) -> bool:
        """Whether the samples agree better with their median, moved back by a path of the camera.

        It is given in px of the pictures, shape (samples, 2).
        """
        small = shift_px[:, self.axes] / (self.scale * self._scale)
        return agree_better(self._small, np.zeros_like(small), self._small, small)

    def corners_turned_back(self, turns: Turns) -> Trajectories:
        """Corners of the samples, once whole pictures are turned and scaled back."""
        size = self.pictures[0].shape[::-1]
        x, y = (
            (side / 2 - edge) / self.scale for side, edge in zip(size, self._corner_px, strict=True)
        )
        return self._corners.turned_back(turns, complex(x, y))

    def proposals(self, known: Sequence[Shape] = ()) -> list[RigidGroup]:
        """Find what may be a body where no known one is."""
        covered = self._covered(known)
        corners = self._corners.beside(covered, self._scale)
        regions = find_regions(self._small, self._scale, covered if known else ())
        if not known:
            self._all_change = regions.all_change
        return propose(corners, regions, self.shift_px, self._all_change)

    def placed(self, proposed: Sequence[RigidGroup]) -> list[Rough]:
        """Turn proposals into px of the clip's pictures."""
        return roughly(proposed, self.scale, self._corner_px, turned=self.upright)

    def background(self, pictures: Lumas, known: Sequence[Shape] = ()) -> Background:
        """Learn what stands still from the samples, but for what shapes hide."""
        lights = [one.turned() if self.upright else one for one in self.samples.lights]
        return background_of(pictures, self.scale * self.shift_px[:, self.axes], lights, known)

    def _covered(self, shapes: Sequence[Shape]) -> list[list[Part]]:
        """Parts of each sample that known bodies cover, as it is reduced for regions."""
        x, y = (self._corner_px[axis] for axis in self.axes)
        scale = self.scale * self._scale
        each = ([one.part(k, (x, y), scale) for one in shapes] for k in range(len(self._small)))
        return [[part[::-1] if self.upright else part for part in parts] for parts in each]


def _less_sure(seen: Followed, motion: Motion) -> Followed:
    """Add the camera's uncertainty; where its shift along x is not known, no body has a place."""
    sigma = np.hypot(seen.sigma_px, motion.sigma_px[:, 0])
    return replace(seen, sigma_px=sigma).only(np.isfinite(sigma))


def _swept(rough: Rough) -> Box:
    """Box that a body passes over."""
    path = known_of(rough.path_px)
    low, high = path.min(axis=0) + rough.box[:2], path.max(axis=0) + rough.box[2:]
    return (*low.tolist(), *high.tolist())
