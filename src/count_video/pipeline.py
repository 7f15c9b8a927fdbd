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

from collections.abc import Iterable
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

from count_video import verdict
from count_video.errors import TrackingError
from count_video.footage.reader import Footage, open_footage
from count_video.motion.alone import seen_impacts
from count_video.motion.cadence import cadence_of
from count_video.motion.clock import as_shown, seen_by_clock
from count_video.motion.fitted import Between, Misfit, count_between, measure_burst
from count_video.motion.meeting import only_turns, without_wall
from count_video.motion.reasons import Cause, Reason
from count_video.motion.seen import SeenCollisions
from count_video.motion.weighing import SeenImpacts, with_wall_ahead
from count_video.progress import NO_PROGRESS, Progress
from count_video.records import FootageInfo, Track, TrialResult, WallSide
from count_video.tracking.ahead import stands_ahead
from count_video.tracking.lone import lone_track
from count_video.tracking.observation import Observation, observe, pair_tracks
from count_video.tracking.view import Region, TrackSettings

STROKE_SIGMAS = 4.0
"""The heavy body's path shows the strokes if they exceed their uncertainty by this factor."""


@dataclass(frozen=True)
class TrialSettings:
    """What the user may say about a clip."""

    capture_fps: float | None = None
    """Camera's rate in frames per second of real time."""
    ball_diameter_mm: float = 40.0
    wall_side: WallSide | None = None
    region: Region | None = None
    """Part of the picture that holds the experiment: x, y, width, height in px."""
    start: int = 0
    """First frame to use."""
    end: int | None = None
    """Frame to stop before; None for the clip's end."""
    masses: tuple[Fraction, Fraction] | None = None
    """Heavy and light mass, in any one unit."""
    seen_only: bool = False
    """Count what the frames show and infer nothing between them."""


@dataclass(frozen=True)
class Trial:
    """One clip worked through: the answer and what it rests on."""

    result: TrialResult
    info: FootageInfo
    track: Track | None
    """None where no bodies could be followed."""
    found: SeenCollisions | None
    """What the frames show; None without a track."""
    between: Between | Misfit | None = None
    """What a fitted model says where the frames leave doubts; None where it was not asked."""


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
    """
    with open_footage(path, capture_fps=settings.capture_fps) as footage:
        wanted = TrackSettings(settings.wall_side, settings.region, settings.start, settings.end)
        with observe(footage, wanted, progress) as seen:
            try:
                trial = _likeliest(pair_tracks(seen, settings.wall_side), seen, settings)
            except TrackingError:
                trial = None
            if trial is None:
                return _without_pair(seen)
            whole = _may_be_bodies(trial)
            if whole and verdict.is_settled(trial.result, at_wall=trial.found is not None):
                return trial
            alone = _without_pair(seen)
            if not whole and alone.result.count is not None:
                return alone
            if not whole and trial.result.count is not None:
                why = verdict.sentence(Reason(Cause.PARTS_OF_BODIES))
                nothing = verdict.nothing_to_count(footage.info, footage.report(), why)
                return replace(trial, result=nothing)
        better = verdict.is_better(
            alone.result, alone.track, trial.result, trial.track, borne_out=_strokes_show(trial)
        )
        return alone if better else trial


def _may_be_bodies(trial: Trial) -> bool:
    """Whether what was followed to a wall touches, shows momentum to be kept, or obeys the law.

    Parts of bodies that were followed do none of these.
    """
    if trial.found is None or trial.track is None:
        return True
    touching = trial.result.millimetres_per_px is not None
    return touching or isinstance(trial.between, Between) or _strokes_show(trial)


def _likeliest(
    offered: Iterable[Track], seen: Observation, settings: TrialSettings
) -> Trial | None:
    """Work through tracks of two bodies, the likeliest first, until one bears out its collisions.

    The first two at a wall stand for the others if none of them do; None if there are no tracks.
    """
    best: Trial | None = None
    for track in offered:
        if best is not None and _borne_out(best):
            break
        trial = _with_pair(seen, track, settings)
        counted = trial.result.status == "counted"
        if counted and _borne_out(trial):
            return trial
        better = counted and best is not None and best.result.status != "counted"
        if better or best is None or _borne_out(trial) or (track.wall_seen and not _stands(best)):
            best = trial
            if track.wall_seen and counted:
                break
    return best


def _borne_out(trial: Trial) -> bool:
    return trial.found is not None and trial.found.borne_out


def _strokes_show(trial: Trial) -> bool:
    """Whether the heavy body's path bears out the collisions, and would not do so without them.

    Scenery that is taken for a body drifts along without any.
    """
    swing = trial.found.swing if trial.found is not None else None
    shows = swing is not None and STROKE_SIGMAS * swing.mass_ratio_relative_sigma < 1
    return shows and _borne_out(trial)


def _stands(trial: Trial) -> bool:
    """Whether a trial keeps its place before the next two bodies at a wall."""
    at_wall = trial.track is not None and trial.track.wall_seen
    return at_wall or trial.result.status == "counted"


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
    return Trial(result, info, track, None)


def _at_wall(footage: Footage, track: Track, settings: TrialSettings) -> Trial:
    """Work through a clip in which a ball and a heavy body at a wall can be followed."""
    info, report = footage.info, footage.report()
    shown = track
    clock, track, found = seen_by_clock(track)
    result = verdict.counted(info, report, track, found, settings.masses, settings.ball_diameter_mm)
    between = None
    if verdict.leaves_room(found) and not settings.seen_only:
        between = count_between(track, found, verdict.knowledge(info, settings.masses))
        result = verdict.inferred(result, found, between)
    elif result.count:
        between = measure_burst(track, found, verdict.knowledge(info, settings.masses))
        more = isinstance(between, Between) and between.count > result.count
        result = (
            verdict.inferred(result, found, between) if more else verdict.measured(result, between)
        )
    result = verdict.doubted_for_missing(result, report)
    return Trial(as_shown(result, clock), info, shown, found, between)


def _without_pair(seen: Observation) -> Trial:
    """Work through a clip that shows no ball and heavy body at a wall."""
    footage = seen.view.footage
    try:
        track = lone_track(seen)
    except TrackingError as error:
        nothing = verdict.nothing_to_count(footage.info, footage.report(), str(error))
        return Trial(nothing, footage.info, None, None)
    cadence, report = cadence_of(track), footage.report()
    found = seen_impacts(cadence.evened(track) if cadence else track)
    result = verdict.impacts_counted(footage.info, report, track, found)
    return Trial(as_shown(result, cadence), footage.info, track, None)


def _doubted(found: SeenImpacts, seen: Observation, track: Track) -> SeenImpacts:
    """Doubt meetings of two bodies that may be the first ones of a trial whose wall is ahead."""
    if track.heavy is None or not found.collisions or found.shortcomings:
        return found
    return with_wall_ahead(found) if stands_ahead(seen, track) else found
