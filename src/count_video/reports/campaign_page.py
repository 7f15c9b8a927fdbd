"""The page and the picture of a campaign: the table, the histogram, every trial with its picture.

The page links to what lies beside it in the folder: ``NAME.html`` and ``NAME.strip.jpg`` of each
trial, as far as they are there.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
from pathlib import Path
from urllib.parse import quote

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from count_video.reports.campaign_rows import CampaignSummary, TrialRow
from count_video.reports.campaign_text import advice
from count_video.reports.drawing import picture_bytes, styled
from count_video.reports.page import environment, own_file
from count_video.reports.palette import SKY_BLUE, VERMILION
from count_video.reports.printable import printable

MEDIA_TYPES = {"png": "image/png", "svg": "image/svg+xml"}


def campaign_files(
    rows: Sequence[TrialRow], summary: CampaignSummary, picture_format: str = "png"
) -> dict[str, bytes]:
    """Draw and write ``campaign.png`` (or ``.svg``) and ``campaign.html``: contents by names."""
    picture = picture_bytes(campaign_figure(summary), picture_format)
    page = campaign_page(rows, summary, (picture, MEDIA_TYPES[picture_format]))
    return {f"campaign.{picture_format}": picture, "campaign.html": page.encode("utf-8")}


def campaign_figure(summary: CampaignSummary) -> Figure:
    """Draw the histogram of the counts against the theory."""
    with styled():
        figure = Figure(figsize=(9.0, 5.0))
        figure.set_layout_engine("constrained", w_pad=0.15, h_pad=0.15)
        axes = figure.add_subplot()
        _draw_histogram(axes, summary)
        if axes.get_legend_handles_labels()[0]:
            figure.legend(loc="outside lower center", ncols=3)
        return figure


def campaign_page(
    rows: Sequence[TrialRow], summary: CampaignSummary, picture: tuple[bytes, str]
) -> str:
    """Write the page; those that need a person come first."""
    ordered = sorted(rows, key=lambda row: not row.needs_a_person)
    return (
        environment()
        .get_template("campaign.html")
        .render(
            summary=summary,
            table=_table(summary),
            trials=[_trial(row) for row in ordered],
            doubtful=sum(row.needs_a_person for row in rows),
            picture=base64.b64encode(picture[0]).decode("ascii"),
            picture_type=picture[1],
            style=own_file("clip.css") + own_file("campaign.css"),
        )
    )


def _draw_histogram(axes: Axes, summary: CampaignSummary) -> None:
    counts = list(summary.histogram)
    theory = summary.theory
    shown = [*counts, *([] if theory is None else [theory])]
    axes.set_title(f"Counts of {summary.counted} trials")
    axes.set_xlabel("collisions counted")
    axes.set_ylabel("trials")
    if not shown:
        return
    span = range(min(shown), max(shown) + 1)
    trials = [summary.histogram.get(count, 0) for count in span]
    bars = axes.bar(list(span), trials, color=SKY_BLUE, label="trials", gid="bar")
    labels = [str(number) if number else "" for number in trials]
    axes.bar_label(bars, labels=labels, backgroundcolor="white", padding=3)
    if theory is not None:
        label = f"theory: {theory}"
        axes.axvline(theory, color=VERMILION, linestyle="--", linewidth=2, label=label)
    if summary.mean is not None:
        label = f"mean: {summary.mean:.2f}"
        axes.axvline(summary.mean, color="black", linestyle=":", linewidth=2, label=label)
    axes.set_xlim(span[0] - 1.5, span[-1] + 1.5)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(integer=True))
    axes.set_ylim(0, 1.15 * max(*trials, 1))


def _table(summary: CampaignSummary) -> list[tuple[str, str]]:
    """Rows of the paper's table and what goes with it; what is not known is left out."""
    decimals = [
        ("Mean", summary.mean),
        ("Standard deviation", summary.sd_population),
        ("Sample standard deviation", summary.sd_sample),
        ("Uncertainty of the mean", summary.mean_uncertainty),
    ]
    rows: list[tuple[str, str]] = [
        (label, str(value))
        for label, value in (("Maximum", summary.maximum), ("Minimum", summary.minimum))
        if value is not None
    ]
    rows += [(label, f"{value:.2f}") for label, value in decimals if value is not None]
    rows.append(("Number of trials", f"{summary.trials}, {summary.counted} counted"))
    if summary.theory is not None:
        rows.append(("Theory", str(summary.theory)))
    spreads = [
        ("Restitution, bodies", summary.restitution_bodies),
        ("Restitution, wall", summary.restitution_wall),
        ("Energy kept", summary.energy_kept),
    ]
    rows += [(label, f"{s.mean:.3f} ± {s.sd:.3f}") for label, s in spreads if s is not None]
    if summary.geometric_share is not None:
        rows.append(("Geometric endings", f"{summary.geometric_share:.0%}"))
    return rows


def _trial(row: TrialRow) -> dict[str, object]:
    doubt = ". ".join(filter(None, (row.not_kept or row.reason, advice(row))))
    return {
        "clip": printable(Path(row.clip).name),
        "answer": "not counted" if row.count is None else str(row.count),
        "probability": None if row.probability is None else f"{row.probability:.0%}",
        "doubt": printable(doubt or ""),
        "needs_a_person": row.needs_a_person,
        "page": _link(row, "html"),
        "strip": _link(row, "strip.jpg"),
    }


def _link(row: TrialRow, suffix: str) -> str | None:
    """Address of a file beside the page; None if it is not there."""
    name = f"{row.name}.{suffix}"
    return quote(name) if name in row.files else None
