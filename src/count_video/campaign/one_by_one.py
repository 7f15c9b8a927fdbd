"""Many clips, one after the other: a bad one never stops the others."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

from count_video import trial
from count_video.errors import CountVideoError
from count_video.progress import NO_PROGRESS, Progress
from count_video.records import TrialResult
from count_video.verdict import unread_result

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

    What cannot be read (a missing file, say) becomes an outcome with its error instead of being
    raised; faults of the program itself are raised.
    """
    for path in paths:
        yield _count_one(path, settings, progress, work or trial.count_clip)


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
