"""One clip from frames to tracks: decoded once, every moving body found and followed.

Which of the bodies are ball and heavy body is decided from their motion alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from count_video.errors import UsageError
from count_video.process import give_memory_back
from count_video.progress import NO_PROGRESS, Progress
from count_video.records import Indices, Luma
from count_video.tracking.bodies import find_movers
from count_video.tracking.colour import Colours
from count_video.tracking.pairing import Movers
from count_video.tracking.samples import Thumbnails, stored
from count_video.tracking.shots import Shots
from count_video.tracking.turning import turned_back
from count_video.tracking.view import View
from count_video.video.store import PictureStore

PROGRESS_STEP = 16


@dataclass(frozen=True)
class Observation:
    """A decoded clip with all bodies that move in it; a context manager that frees its pictures."""

    view: View
    frames: Indices
    """Index of each picture, shape (n,); copies are left out."""
    pictures: PictureStore
    movers: Movers
    whole: bool = True
    """Whether the clip is one shot; of others the longest alone is here."""

    def picture(self, row: int) -> Luma:
        """Picture as the bodies were followed in it: turned back where the camera turned."""
        turns = self.movers.turns
        shown = self.pictures[row]
        return shown if turns is None else turned_back(shown, complex(turns[row]))

    def __enter__(self) -> Observation:
        return self

    def __exit__(self, *_: object) -> None:
        self.pictures.close()


def observe(view: View, progress: Progress = NO_PROGRESS) -> Observation:
    """Decode a clip once and follow everything that moves in it.

    Raises
    ------
    UsageError
        If the start does not fit into the clip.
    FootageError
        If the size of the picture changes on the way, or there is no room for its pictures.
    """
    pictures, thumbnails, colours = PictureStore(), Thumbnails(), Colours()
    shots = Shots()
    frames: list[int] = []
    last = 0
    try:
        progress.start(view.footage.info.frames_promised, "tracking")
        for frame in view.frames():
            if not frame.repeats_previous:
                small = pictures.append(frame.luma)
                thumbnails.add(len(frames), small)
                shots.add(small)
                colours.add(frame.chroma)
                frames.append(frame.index)
            if frame.index % PROGRESS_STEP == PROGRESS_STEP - 1:
                progress.advance(PROGRESS_STEP)
            last = frame.index + 1
            del frame  # one picture of the decoder holds the memory of all
        progress.advance(last % PROGRESS_STEP)
        if not frames and view.start:
            raise UsageError(
                f"start {view.start} leaves nothing of the clip, which has "
                f"{view.footage.report().frames_decoded} frames; give an earlier one"
            )
        shot = shots.longest()
        whole = len(shot) == len(frames)
        if not whole:
            thumbnails.taken()
            whole_clip = pictures
            pictures, thumbnails = stored(whole_clip[row] for row in shot)
            whole_clip.close()
            colours = colours.of_shot(shot)
        mixture = colours.mixture(thumbnails)
        if mixture is not None:
            thumbnails.taken()  # those of brightness make room for the new ones
            pictures, thumbnails = colours.mixed(pictures, mixture)
        colours.close()
        give_memory_back()
        indices = np.array(frames, dtype=np.intp)[shot.start : shot.stop]
        movers = find_movers(pictures, indices, thumbnails)
        return Observation(view, indices, pictures, movers, whole)
    except BaseException:
        pictures.close()
        colours.close()
        raise
