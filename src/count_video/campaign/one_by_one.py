"""Many clips, one after the other: a bad one never stops the others."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from count_video import trial
from count_video.campaign.folder import clips_in
from count_video.errors import CountVideoError
from count_video.progress import NO_PROGRESS, Progress
from count_video.records import TrialResult

Work = Callable[[Path, trial.TrialSettings, Progress], TrialResult]
"""What is done with a clip; ``trial.count_clip`` is the plainest."""


@dataclass(frozen=True)
class Outcome:
    """What became of one clip."""

    result: TrialResult
    """The answer; where ``error`` is set it holds the reason and nothing else."""
    error: CountVideoError | OSError | None
    """Why there was nothing to work on; None for every clip that could be read."""


def count_clips(
    paths: Iterable[Path],
    settings: trial.TrialSettings,
    progress: Progress = NO_PROGRESS,
    work: Work | None = None,
) -> Iterator[Outcome]:
    """Count clips in the order given, each answered as soon as it is ready.

    A folder stands for the video files in it, in natural order. What cannot be read (a missing
    file, a folder without clips) becomes an outcome with its error instead of being raised;
    faults of the program itself are raised.
    """
    for path in paths:
        try:
            clips = clips_in(path) if path.is_dir() else [path]
        except (CountVideoError, OSError) as error:
            yield refused(path, error)
            continue
        for clip in clips:
            yield _count_one(clip, settings, progress, work or trial.count_clip)


def _count_one(
    clip: Path, settings: trial.TrialSettings, progress: Progress, work: Work
) -> Outcome:
    try:
        return Outcome(work(clip, settings, progress), None)
    except (CountVideoError, OSError) as error:
        return refused(clip, error)
    finally:
        progress.finish()


def refused(path: Path, error: CountVideoError | OSError) -> Outcome:
    """Make the outcome of a clip that could not be worked on."""
    # An OSError's own text repeats number and path; its plain words are enough.
    plain_words = error.strerror if isinstance(error, OSError) else None
    reason = plain_words or str(error).removeprefix(f"{path}: ") or type(error).__name__
    return Outcome(unread_result(str(path), reason), error)


def unread_result(clip: str, reason: str) -> TrialResult:
    """Make the answer for a clip of which nothing is known but why it could not be read."""
    return TrialResult(
        clip=clip,
        status="not_counted",
        reason=reason,
        count=None,
        seen=None,
        between_frames=None,
        probability={},
        count_after_burst=None,
        collisions=(),
        capture_fps=None,
        capture_fps_source="unknown",
        frames_decoded=None,
        frames_promised=None,
        wall_side=None,
        ball_diameter_px=None,
        millimetres_per_px=None,
        pi_low=None,
        pi_high=None,
        mass_ratio=None,
        warnings=(),
    )
