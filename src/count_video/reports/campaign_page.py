"""The page and the picture of a campaign: plain records in, files out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class CampaignRow:
    """One trial of a campaign."""

    clip: str
    """Name to show."""
    count: int | None
    """None where the clip was not counted."""
    probability: float | None
    """Probability of the count; None where there is none."""
    doubt: str | None
    """Why a person should look, and what to do; None if all is well."""
    page: str | None
    """Address of the clip's page, relative to the folder; None if there is none."""
    strip: str | None
    """Address of its small space-time picture, relative to the folder; None if there is none."""


@dataclass(frozen=True)
class CampaignSummary:
    """What the trials say together: the paper's table; None where nothing was counted."""

    title: str
    trials: int
    counted: int
    maximum: int | None
    minimum: int | None
    mean: float | None
    sd_population: float | None
    """Divided by n, as the paper has it."""
    sd_sample: float | None
    """Divided by n - 1."""
    theory: int | None
    """Exact count of the masses; None where they are not known."""
    notes: tuple[str, ...] = ()
    """Further sentences to show, e.g. on restitution; empty for none."""


def write_campaign_page(
    rows: Sequence[CampaignRow],
    summary: CampaignSummary,
    folder: Path,
    picture_format: str = "png",
) -> None:
    """Write ``campaign.html`` and ``campaign.png`` (or ``.svg``) into a folder.

    Raises
    ------
    OSError
        If a file cannot be written.
    """
    raise NotImplementedError
