"""One clip, from file to result: the table of contents of the whole program.

file -> frames            video
frames -> tracks          tracking
tracks -> explanations    explanations: what each pair of bodies, or body, shows by motion
explanations -> result    choosing: which of them stands; answers

All bodies that move are followed in one decoding. Two of them that collide are counted; where their
count is not certain, it is compared with that of one body alone.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

from count_video.answers import Followed, answer, knowledge, nothing_to_count
from count_video.choosing import (
    is_settled,
    likeliest_pair,
    may_be_bodies,
    of_bodies_alone,
    stands_before,
)
from count_video.errors import TrackingError
from count_video.process import take_buffer
from count_video.progress import NO_PROGRESS, Progress
from count_video.reasons import Cause, Reason
from count_video.reports.words import sentence
from count_video.scenes import of_one, of_pair
from count_video.settings import TrialSettings
from count_video.tracking.beside import moves_beside, stands_beyond
from count_video.tracking.observation import Observation, observe
from count_video.tracking.pairing import pair_tracks
from count_video.tracking.single import single_tracks
from count_video.tracking.view import view_of
from count_video.video.reader import open_footage


def work_through(path: Path, settings: TrialSettings, progress: Progress = NO_PROGRESS) -> Followed:
    """Count the collisions in one clip and keep what the count rests on.

    FootageError if the file cannot be read as footage, UsageError if a setting does not fit the
    clip, MemoryError if there is not enough memory.
    """
    take_buffer()
    with open_footage(path, capture_fps=settings.capture_fps) as footage:
        view = view_of(footage, settings.region, settings.start, settings.end)
        with observe(view, progress) as seen:
            return _explained(seen, settings)


def _explained(seen: Observation, settings: TrialSettings) -> Followed:
    """Explain what moves by two bodies, or by one alone, and read the answer off."""
    footage = seen.view.footage
    info, report = footage.info, footage.report()
    if not seen.whole:
        shot = Reason(Cause.OTHER_SHOTS, (float(seen.frames[0]), float(seen.frames[-1])))
        report = replace(report, warnings=(*report.warnings, sentence(shot)))
    known = knowledge(info, settings)
    why = ""
    pair = best = likeliest_pair(
        of_pair(track, known, partial(stands_beyond, seen))
        for track in pair_tracks(seen.movers, seen.frames, seen.view, settings.wall)
    )
    if pair is None or not is_settled(pair):
        try:
            one_by_one = [
                of_one(track, known, partial(moves_beside, seen, track))
                for track in single_tracks(seen)
            ]
            alone = of_bodies_alone(one_by_one)
            if pair is None or not stands_before(pair, alone, len(one_by_one)):
                best = alone
        except TrackingError as error:
            why = str(error)
    if best is None:
        return Followed(nothing_to_count(info, report, why))
    if may_be_bodies(best):
        result = answer(best, info, report, settings)
    else:
        result = nothing_to_count(info, report, sentence(Reason(Cause.PARTS_OF_BODIES)))
    return Followed(result, best.track)
