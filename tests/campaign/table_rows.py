"""Rows of a campaign's table, made by hand."""

from __future__ import annotations

from dataclasses import replace

from count_video.reports.campaign_rows import TrialRow

_BLANK = TrialRow(
    name="trial",
    clip="trial.mp4",
    status="counted",
    count=31,
    chances={30: 0.01, 31: 0.98, 32: 0.01},
    reason=None,
    not_kept=None,
    seen=31,
    between_frames=0,
    capture_fps=960.0,
    mass_ratio=100.0,
    theory=None,
    pi_low=3.0,
    pi_high=3.2,
    restitution_bodies=None,
    restitution_wall=None,
    energy_kept=None,
    ending=None,
)


def row(name: str = "trial", count: int | None = 31, **changes: object) -> TrialRow:
    """Return a row with a sure count, or one that is not counted for a count of None."""
    told = {"name": name, "clip": f"clips/{name}.mp4", "count": count}
    if count is None:
        told |= {"status": "not_counted", "chances": {}, "reason": "nothing moves"}
    else:
        told |= {"chances": {count: 1.0}, "seen": count}
    return replace(_BLANK, **(told | changes))  # type: ignore[arg-type]


def rows_of(histogram: dict[int, int]) -> list[TrialRow]:
    """Return so many rows with each count."""
    return [
        row(f"trial{count}-{number}", count)
        for count, many in histogram.items()
        for number in range(many)
    ]
