"""The pages of a clip, a campaign and a plan: each one file, without a network.

A clip's page has all that a person needs to check the count. A campaign's links to what lies beside
it in the folder: ``NAME.html`` and ``NAME.strip.jpg`` of each trial, as far as they are there. A
plan's has sliders over a table of simulated trials.
"""

from __future__ import annotations

import base64
import hashlib
import math
import re
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

from count_video.inputs import TOLERANCES
from count_video.planning import variations
from count_video.planning.comparison import expected_counts
from count_video.planning.plan import MEASURED, Plan
from count_video.planning.request import PlanRequest, Tolerances, request_object
from count_video.records import SAME_COLLISION_FRAMES, Floats, TrialResult
from count_video.reports.campaign import CampaignSummary, TrialRow, summary_lines
from count_video.reports.exports import json_object, plain
from count_video.reports.plan_text import plan_headline, plan_notes, table_lines
from count_video.reports.text import (
    answer_words,
    collision_lines,
    comparison_lines,
    pi_words,
    result_notes,
)
from count_video.reports.words import (
    counts_words,
    percent,
    printable,
    ratio_words,
    share_words,
    storable,
)


def render(name: str, *, script: bool = False, **values: object) -> str:
    """Fill in a template; its style and script are called like it; all pages share ``page.css``.

    Every value that is filled in is escaped, so that no name can end a script or begin an element.
    """
    made = Environment(
        loader=PackageLoader("count_video.reports"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    made.filters |= {"digest": _digest, "printable": printable, "percent": percent}
    made.filters |= {"ratio_words": ratio_words, "share": share_words, "whole": _with_whole_options}
    own = {"style": f"{name}.css", "script": f"{name}.js" if script else None}
    return made.get_template(f"{name}.html").render({"data": None, **values, **own})


def _with_whole_options(text: str) -> Markup:
    """Mark each option of the command in a text, so that no line breaks at its hyphens."""
    option = r"(?<![\w-])--[a-z][a-z-]+"
    return Markup(re.sub(option, r'<span class="option">\g<0></span>', str(escape(text))))


def _digest(own_text: str) -> str:
    """Name a style or script as a page's policy does, so that the browser applies no other."""
    digest = hashlib.sha256(own_text.encode("utf-8")).digest()
    return f"sha256-{base64.b64encode(digest).decode('ascii')}"


def data_address(data: bytes, media_type: str) -> str:
    """Write a file as an address that holds all of it."""
    return f"data:{media_type};base64,{base64.b64encode(data).decode('ascii')}"


# ---- a clip --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class PageMedia:
    """The annotated clip, and the picture of the trial, on the page."""

    mp4: bytes
    frame: Floats
    """Frames of the footage that the clip shows, shape (n,)."""
    shown_s: Floats
    """When it shows each, in seconds from its start, shape (n,)."""
    cuts: Mapping[int, Sequence[tuple[int, bytes]]]
    """Enlarged frames of each contact, by the collision's number: their indices and JPEGs."""
    clip_sha256: str = ""
    """Digest of the clip's bytes, which no other clip has; empty if not known."""
    picture: str | None = None
    """The picture as an address that holds it."""
    panels: Sequence[Mapping[str, object]] = ()
    """Those of its panels in which time runs to the right, as ``figure.time_panels`` gives them."""


def clip_page(result: TrialResult, media: PageMedia | None = None) -> str:
    """Write the page; without media (no bodies were followed) it holds the answer alone."""
    name = storable(Path(result.clip).name)
    saved = f"{Path(name).stem}.corrections.json"
    file, back = (f"./{one}" if one.startswith("-") else one for one in (name, saved))
    shown: dict[str, object] = {"video": None, "picture": None}
    if media is not None:
        shown = {"video": data_address(media.mp4, "video/mp4"), "picture": media.picture}
        shown["data"] = {"clip": name, "save_as": saved, **_script_data(result, media)}
    return render(
        "clip",
        script=media is not None,
        clip=name,
        command=f"count-video {shlex.quote(file)} --corrections {shlex.quote(back)}",
        answer=answer_words(result),
        doubt=result.reason or "",
        facts=_facts(result),
        notes=result_notes(result),
        tables=[comparison_lines(result.comparison), collision_lines(result)],
        **shown,
    )


def _script_data(result: TrialResult, media: PageMedia) -> dict[str, object]:
    return {
        "clip_sha256": media.clip_sha256,
        "result": json_object(result),
        "burst_size": result.burst_size,
        "same_frames": SAME_COLLISION_FRAMES,
        "burst_ends": min((c.frame for c in result.beyond_burst), default=1e300),
        "panels": list(media.panels),
        "frames": media.frame.astype(int).tolist(),
        "times": media.shown_s.round(5).tolist(),
        "cuts": {
            number: [(frame, data_address(jpeg, "image/jpeg")) for frame, jpeg in frames]
            for number, frames in media.cuts.items()
        },
    }


def _facts(result: TrialResult) -> dict[str, str]:
    """List what stands beside the count at the top; what is not known is left out."""
    facts = {}
    if result.chance is not None:
        facts["Probability"] = percent(result.chance)
    expected = expected_counts(result)
    if expected is not None:
        facts["Theory"] = counts_words(*expected.free)
    if result.ratio is not None:
        facts["Mass ratio"] = f"{ratio_words(result.ratio)} : 1"
    bounds, held = pi_words(result)
    if bounds:
        facts["Bounds on π"] = bounds + ", π outside" * held.endswith("outside")
    return facts


# ---- a campaign --------------------------------------------------------------------------------


def campaign_page(
    rows: Sequence[TrialRow], summary: CampaignSummary, picture: tuple[bytes, str]
) -> str:
    """Write the page; those that need a person come first."""
    return render(
        "campaign",
        script=True,
        summary=summary.whole,
        groups=[(ratio_words(group.mass_ratio), summary_lines(group)) for group in summary.groups],
        rows=sorted(rows, key=lambda row: not row.needs_a_person),
        doubt=_doubt,
        picture=data_address(*picture),
    )


def _doubt(row: TrialRow) -> str:
    """Say what is doubtful about a trial and what to do, in sentences."""
    to_do = row.advice
    why = "; ".join(filter(None, (row.not_kept or row.result.reason, row.other_masses)))
    return printable(". ".join(filter(None, (why, to_do[:1].upper() + to_do[1:]))))


# ---- a plan ------------------------------------------------------------------------------------


DRAWN_SHARE = 0.02
"""Counts that fewer of the simulated trials have get no bar."""


def plan_page(plan: Plan, picture: str) -> str:
    """Write the page: counts for other gaps, releases, cylinders and cameras, from one table.

    ``picture`` is that of the plan, as an address that holds it.
    """
    request, spread = plan.request, plan.spread
    rate = plan.framing.rate_needed_fps if plan.camera is None else plan.camera.capture_fps
    shares = {count: number / spread.trials for count, number in spread.histogram.items()}
    return render(
        "plan",
        script=True,
        headline=plan_headline(plan),
        count=plan.burst.count,
        request=request,
        variations=variations,
        log_rate=math.log10(rate),
        shares=[(count, share) for count, share in shares.items() if share >= DRAWN_SHARE][::-1],
        notes=dict(plan_notes(plan)),
        table=table_lines(plan.table),
        picture=picture,
        data={
            "request": request_object(request),
            "rate": rate,
            "table": plain(variations.adjustments_of(request, plan.burst.theory)),
            "measured": plain(MEASURED),
            "resolved": variations.RESOLVED_FRAMES,
            "options": _options_beside(request),
        },
    )


def _options_beside(request: PlanRequest) -> str:
    """Options of the command line that are not their defaults and have no slider."""
    options = f" --thread {request.heavy_thread_m:g} {request.light_thread_m:g}"
    options += f" --restitution {request.restitution:g}"
    usual = PlanRequest(1, 1)
    if request.ball_diameter_m != usual.ball_diameter_m:
        options += f" --ball-diameter-mm {1e3 * request.ball_diameter_m:g}"
    options += f" --damping {request.damping_per_s:g}" if request.damping_per_s else ""
    for name, (field, _) in TOLERANCES.items():
        value = getattr(request.tolerances, field)
        if value != getattr(Tolerances(), field):
            options += f" --tolerance {name}={value:g}"
    return options + (f" --seed {request.seed}" if request.seed else "")
