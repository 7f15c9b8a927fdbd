"""The functions for Python programs and notebooks; ``import count_video`` offers them by name.

The command line calls them too, so that a program gets the same answer as a person at a terminal.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import closing
from os import PathLike
from pathlib import Path
from typing import Unpack

from count_video import inputs, pipeline
from count_video.batch.executor import answer_of, count_job
from count_video.batch.manifest import jobs_of
from count_video.errors import UsageError
from count_video.inputs import signature
from count_video.outputs import without_own
from count_video.parallel import as_done
from count_video.physics.theory import Mass, Theory, theory_of
from count_video.planning.plan import Plan, make_plan
from count_video.planning.request import PlanDetails, PlanRequest
from count_video.process import shortage_explained
from count_video.progress import NO_PROGRESS, Progress
from count_video.records import WallSide
from count_video.result import AnyPath, Result
from count_video.settings import Settings, TrialSettings, trial_settings


def count(  # noqa: PLR0913 - what a clip may need is many things, each by its name
    path: AnyPath,
    *,
    masses: tuple[Mass, Mass] | None = None,
    capture_fps: float | None = None,
    region: tuple[int, int, int, int] | None = None,
    wall: WallSide | None = None,
    start: int = 0,
    end: int | None = None,
    ball_diameter_mm: float = 40.0,
    seen_only: bool = False,
    progress: Progress = NO_PROGRESS,
) -> Result:
    """Count the collisions in one clip.

    Parameters
    ----------
    path
        The video file.
    masses
        Heavy and light mass in any one unit, for the bounds on pi, and to narrow the count down
        where collisions lie between the frames, unless the motion contradicts them; measured from
        the motion where they are not given. A float is taken at the decimal number it is written
        as.
    capture_fps
        Rate of the camera in frames per second of real time; None: what the clip's metadata say.
    region
        Part of the picture to use, in px: left edge, top edge, width, height.
    wall
        Side of the picture on which the wall stands, ``"left"`` or ``"right"`` (top or bottom
        where the bodies move up and down); None: found from the motion.
    start
        First frame to use, counted from 0.
    end
        Frame to stop before; None: the end of the clip.
    ball_diameter_mm
        Diameter of the ball in millimetres, for the scale.
    seen_only
        Count only what the frames show and infer nothing between them.
    progress
        Informed of how far the work has come; see ``count_video.progress.Progress``.

    Returns
    -------
    Result
        The answer. ``Result.count`` is None for a clip that does not support a count, and
        ``Result.reasons`` say why.

    Raises
    ------
    CountVideoError
        FootageError if the file cannot be read as footage, UsageError if a value makes no sense or
        does not fit the clip, MachineError if the machine lacks the memory for it.
    """
    settings = trial_settings(
        masses=masses,
        capture_fps=capture_fps,
        region=region,
        wall=wall,
        start=start,
        end=end,
        ball_diameter_mm=ball_diameter_mm,
        seen_only=seen_only,
    )
    return count_with(Path(path), settings, progress)


def count_with(path: Path, settings: TrialSettings, progress: Progress = NO_PROGRESS) -> Result:
    """Count the collisions in one clip as :func:`count` does, with settings that are checked."""
    before = signature(path)
    try:
        with shortage_explained():
            return Result(pipeline.work_through(path, settings, progress), signature=before)
    finally:
        progress.finish()


def count_all(
    paths: AnyPath | Iterable[AnyPath], *, jobs: int | None = None, **settings: Unpack[Settings]
) -> Iterator[Result]:
    """Count many clips at the same time and yield each result as it comes.

    A clip that cannot be read is a result as well, with its ``error``; it stops no other. In a
    script the call must stand below ``if __name__ == "__main__":``, because the processes that do
    the work import the script. Leave the loop early and the clips not yet begun are not counted.

    Parameters
    ----------
    paths
        Video files, folders (every video file in them) and manifests (``.csv``), or one of them.
        Annotated clips that this program wrote are left out.
    jobs
        How many clips to count at the same time; None: one for every core.
    settings
        As :func:`count` takes them, for all clips.

    Raises
    ------
    UsageError
        At the first step, if a setting, the number of jobs or a manifest makes no sense, or one
        clip is listed twice with the same settings, or annotated clips alone are given.
    """
    if jobs is not None:
        inputs.checked("jobs", jobs, inputs.CLIPS_AT_A_TIME)
    given = [paths] if isinstance(paths, str | PathLike) else paths
    clips = without_own([Path(one) for one in given])
    wanted = jobs_of(clips, trial_settings(**settings))
    with closing(as_done(count_job, wanted, jobs)) as done:
        yield from (answer_of(job, future).result for job, future in done)


def theory(heavy: Mass, light: Mass = 1) -> Theory:
    """Return the exact count for two masses in any one unit (Galperin's billiard).

    A float is taken at the decimal number it is written as; UsageError if it is not greater than 0.
    """
    return theory_of(*map(inputs.MASS.exact, map(str, (heavy, light))))


def plan(heavy: Mass, light: Mass, *, chart: bool = True, **details: Unpack[PlanDetails]) -> Plan:
    """Say what a set-up will count before it is filmed, as ``count-video --plan`` does.

    Parameters
    ----------
    heavy, light
        The two masses in any one unit.
    chart
        Work out the map as well.
    details
        ``gap_m``, ``release_m``, ``heavy_thread_m``, ``light_thread_m`` and ``ball_diameter_m`` in
        metres, ``capture_fps``, ``restitution``, ``damping_per_s``, ``tolerances`` (a record
        ``count_video.planning.request.Tolerances``), ``trials`` and ``seed``: the fields of
        ``count_video.planning.request.PlanRequest``, which has their defaults.

    Raises
    ------
    UsageError
        If a value makes no sense.
    """
    if unknown := details.keys() - PlanRequest.__dataclass_fields__.keys():
        raise UsageError(f"a plan has no {', '.join(sorted(unknown))}")
    return make_plan(PlanRequest(heavy, light, **details), with_chart=chart)
