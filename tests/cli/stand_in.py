"""A stand-in for the work on one clip, so that the command is tested alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

from count_video import pipeline
from count_video.answers import Followed
from count_video.progress import NO_PROGRESS, Progress
from count_video.records import Collision, TrialResult, Velocities

Work = Callable[[Path], TrialResult]


def counted(path: Path) -> TrialResult:
    """Answer with one collision at the wall."""
    still, away = Velocities(-2.0, 0.0), Velocities(2.0, 0.0)
    collision = Collision(
        number=1,
        kind="wall",
        frame=12.5,
        frame_sigma=0.1,
        seen=True,
        position_px=80.0,
        velocity_before=still,
        velocity_after=away,
    )
    return replace(
        TrialResult(str(path), "not_counted", ""),
        status="counted",
        reason=None,
        count=1,
        seen=1,
        between_frames=0,
        collisions=(collision,),
    )


def not_counted(path: Path) -> TrialResult:
    """Answer that nothing moves."""
    return TrialResult(str(path), "not_counted", "nothing moves")


@dataclass
class StandIn:
    """What the command asked for, and what each clip answers by its name."""

    answers: dict[str, Work] = field(default_factory=dict)
    """Answer by file name; ``counted`` where a name is missing."""
    asked: list[tuple[Path, pipeline.TrialSettings]] = field(default_factory=list)

    def work_through(
        self, path: Path, settings: pipeline.TrialSettings, progress: Progress = NO_PROGRESS
    ) -> Followed:
        """Take the place of ``pipeline.work_through``: no bodies are followed."""
        self.asked.append((path, settings))
        progress.start(1, path.name)
        return Followed(self.answers.get(path.name, counted)(path))
