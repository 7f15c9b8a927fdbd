"""One clip, from file to result: the table of contents of the whole program.

file -> frames            footage
frames -> track           tracking
track -> collisions       motion
in doubt -> fitted        motion.fitted (the whole burst, also between the frames)
collisions -> result      verdict

All bodies that move are followed in one decoding. Two of them that collide are counted; where their
count is not certain, it is compared with that of one body alone.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from count_video import verdict
from count_video.errors import TrackingError
from count_video.footage.reader import Footage, open_footage
from count_video.motion.cadence import cadence_of
from count_video.motion.fitted import Between, count_between, measure_burst
from count_video.motion.frame_times import as_shown, seen_by_clock
from count_video.motion.left_out import LeftOut
from count_video.motion.meeting import only_turns, seen_impacts, without_wall
from count_video.motion.reasons import Cause, Reason
from count_video.motion.seen import with_errors
from count_video.motion.weighing import SeenImpacts, with_wall_ahead
from count_video.process import take_buffer
from count_video.progress import NO_PROGRESS, Progress
from count_video.records import Track, TrialResult
from count_video.settings import TrialSettings
from count_video.tracking.ahead import stands_ahead
from count_video.tracking.observation import Observation, observe, pair_tracks
from count_video.tracking.single import single_tracks
from count_video.tracking.view import TrackSettings
from count_video.verdict.choosing import (
    Trial,
    is_better,
    is_settled,
    likeliest,
    may_be_bodies,
    only_counted,
)


def count_clip(
    path: Path, settings: TrialSettings, progress: Progress = NO_PROGRESS
) -> TrialResult:
    """Count the collisions in one clip; raises what :func:`work_through` raises."""
    return work_through(path, settings, progress).result


def work_through(path: Path, settings: TrialSettings, progress: Progress = NO_PROGRESS) -> Trial:
    """Count the collisions in one clip and keep what the count rests on.

    Raises
    ------
    FootageError
        If the file cannot be read as footage.
    UsageError
        If a setting does not fit the clip.
    MemoryError
        If there is not enough memory.
    """
    take_buffer()
    with open_footage(path, capture_fps=settings.capture_fps) as footage:
        wanted = TrackSettings(settings.wall_side, settings.region, settings.start, settings.end)
        with observe(footage, wanted, progress) as seen:
            try:
                tracks = pair_tracks(seen, settings.wall_side)
                trial = likeliest(_with_pair(seen, track, settings) for track in tracks)
            except TrackingError:
                trial = None
            whole = trial is not None and may_be_bodies(trial)
            if trial is not None and whole and is_settled(trial):
                return trial
            one_by_one = _without_pair(seen)
            alone = only_counted(one_by_one)
            if trial is None:
                return alone
            if whole:
                return alone if is_better(alone, trial, len(one_by_one)) else trial
            if alone.result.count is not None or (alone.result.seen and trial.result.count is None):
                return alone
            why = verdict.sentence(Reason(Cause.PARTS_OF_BODIES))
            nothing = verdict.nothing_to_count(footage.info, footage.report(), why)
            return replace(trial, result=nothing)


def _with_pair(seen: Observation, track: Track, settings: TrialSettings) -> Trial:
    """Work through a clip in which two bodies can be followed, with or without a wall."""
    footage = seen.view.footage
    info, report = footage.info, footage.report()
    if track.wall_seen:
        trial = _at_wall(footage, track, settings)
        if not only_turns(track, trial.result.collisions):
            return trial
    found = _doubted(seen_impacts(without_wall(track)), seen, track)
    result = verdict.impacts_counted(info, report, track, found)
    if track.wall_seen and result.status != "counted" and trial.result.status != "counted":
        return trial
    errors = found.errors if track.wall_side == "left" else found.errors[::-1]
    return Trial(result, info, with_errors(track, errors), None)


def _at_wall(footage: Footage, track: Track, settings: TrialSettings) -> Trial:
    """Work through a clip in which a ball and a heavy body at a wall can be followed."""
    info, report = footage.info, footage.report()
    followed = track
    clock, track, found = seen_by_clock(track)
    result = verdict.counted(info, report, track, found, settings.masses, settings.ball_diameter_mm)
    between = None
    if verdict.leaves_doubt(found) and not settings.seen_only:
        known = verdict.knowledge(info, settings.masses)
        gap = clock if isinstance(clock, LeftOut) else None
        between = count_between(track, found, known, gap)
        result = verdict.inferred(result, found, between)
    elif result.count:
        between = measure_burst(track, found, verdict.knowledge(info, settings.masses))
        more = isinstance(between, Between) and between.count > result.count
        result = (
            verdict.inferred(result, found, between) if more else verdict.measured(result, between)
        )
    result = verdict.doubted_for_missing(result, report)
    left_out = between.left_out if isinstance(between, Between) else None
    shown = with_errors(followed, found.errors)
    return Trial(as_shown(result, clock, left_out), info, shown, found, between)


def _without_pair(seen: Observation) -> list[Trial]:
    """Work through the bodies that move on their own, one by one."""
    footage = seen.view.footage
    try:
        return [_alone(footage, track) for track in single_tracks(seen)]
    except TrackingError as error:
        nothing = verdict.nothing_to_count(footage.info, footage.report(), str(error))
        return [Trial(nothing, footage.info, None, None)]


def _alone(footage: Footage, track: Track) -> Trial:
    """Work through the track of one body as if nothing else moved."""
    cadence, report = cadence_of(track), footage.report()
    found = seen_impacts(cadence.evened(track) if cadence else track)
    result = verdict.impacts_counted(footage.info, report, track, found)
    return Trial(as_shown(result, cadence), footage.info, with_errors(track, found.errors), None)


def _doubted(found: SeenImpacts, seen: Observation, track: Track) -> SeenImpacts:
    """Doubt meetings of two bodies that may be the first ones of a trial whose wall is ahead."""
    if track.heavy is None or not found.collisions or found.shortcomings:
        return found
    return with_wall_ahead(found) if stands_ahead(seen, track) else found
