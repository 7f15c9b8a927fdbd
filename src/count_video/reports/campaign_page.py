"""The page and the picture of a campaign: tables, histograms, every trial with its picture.

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

from count_video.reports.campaign import (
    CampaignSummary,
    Summary,
    TrialRow,
    advice,
    physics_lines,
    summary_lines,
    theory_words,
)
from count_video.reports.drawing import SKY_BLUE, VERMILION, picture_bytes, styled
from count_video.reports.page import MEDIA_TYPES, render
from count_video.reports.words import plural, printable, ratio_words


def campaign_files(
    rows: Sequence[TrialRow], summary: CampaignSummary, picture_format: str = "png"
) -> dict[str, bytes]:
    """Draw and write ``campaign.png`` (or ``.svg``) and ``campaign.html``: contents by names."""
    picture = picture_bytes(campaign_figure(summary), picture_format)
    page = campaign_page(rows, summary, (picture, MEDIA_TYPES[picture_format]))
    return {f"campaign.{picture_format}": picture, "campaign.html": page.encode("utf-8")}


def campaign_figure(summary: CampaignSummary) -> Figure:
    """Draw the histogram of the counts of each mass ratio against the theory."""
    with styled():
        groups = summary.groups
        figure = Figure(figsize=(9.0, 5.0 * len(groups)))
        figure.set_layout_engine("constrained", w_pad=0.15, h_pad=0.15)
        for axes, group in zip(
            figure.subplots(len(groups), squeeze=False).flat, groups, strict=True
        ):
            ratio = f", mass ratio {ratio_words(group.mass_ratio)}" if len(groups) > 1 else ""
            axes.set_title(f"Counts of {plural(group.counted, 'trial')}{ratio}")
            _draw_histogram(axes, group)
        return figure


def _draw_histogram(axes: Axes, group: Summary) -> None:
    theories = group.theories
    shown = [*group.histogram, *({theories[0], theories[-1]} if theories else ())]
    axes.set_xlabel("collisions counted")
    axes.set_ylabel("trials")
    if not shown:
        return
    span = range(min(shown), max(shown) + 1)
    trials = [group.histogram.get(count, 0) for count in span]
    bars = axes.bar(list(span), trials, color=SKY_BLUE, label="trials", gid="bar")
    labels = [str(number) if number else "" for number in trials]
    axes.bar_label(bars, labels=labels, backgroundcolor="white", padding=3)
    for count in {theories[0], theories[-1]} if theories else ():
        label = f"theory: {theory_words(group)}" if count == theories[0] else None
        axes.axvline(count, color=VERMILION, linestyle="--", linewidth=2, label=label)
    if group.mean is not None:
        label = f"mean: {group.mean:.2f}"
        axes.axvline(group.mean, color="black", linestyle=":", linewidth=2, label=label)
    axes.set_xlim(span[0] - 1.5, span[-1] + 1.5)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MaxNLocator(integer=True))
    axes.set_ylim(0, 1.15 * max(*trials, 1))
    axes.legend(loc="upper left")


def campaign_page(
    rows: Sequence[TrialRow], summary: CampaignSummary, picture: tuple[bytes, str]
) -> str:
    """Write the page; those that need a person come first."""
    ordered = sorted(rows, key=lambda row: not row.needs_a_person)
    return render(
        "campaign",
        summary=summary.whole,
        groups=[
            (ratio_words(group.mass_ratio), [*summary_lines(group), *physics_lines(group)])
            for group in summary.groups
        ],
        trials=[_trial(row) for row in ordered],
        doubtful=sum(row.needs_a_person for row in rows),
        picture=base64.b64encode(picture[0]).decode("ascii"),
        picture_type=picture[1],
    )


def _trial(row: TrialRow) -> dict[str, object]:
    what_to_do = advice(row)
    sentences = (row.not_kept or row.result["reason"], what_to_do[:1].upper() + what_to_do[1:])
    doubt = ". ".join(filter(None, sentences))
    ratio = row.mass_ratio
    return {
        "clip": printable(Path(row.result["clip"]).name),
        "answer": "not counted" if row.count is None else str(row.count),
        "count": -1 if row.count is None else row.count,
        "probability": row.probability,
        "ratio": None if ratio is None else ratio.value,
        "ratio_words": "" if ratio is None else ratio_words(ratio),
        "doubt": printable(doubt),
        "needs_a_person": row.needs_a_person,
        "page": _link(row, "html"),
        "strip": _link(row, "strip.jpg"),
    }


def _link(row: TrialRow, suffix: str) -> str | None:
    """Address of a file beside the page; None if it is not there."""
    name = f"{row.name}.{suffix}"
    return quote(name) if name in row.files else None
