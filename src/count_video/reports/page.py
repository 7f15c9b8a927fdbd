"""The pages of a clip, a campaign and a plan: each one file, without a network.

A clip's page has all that a person needs to check the count. A campaign's links to what lies beside
it in the folder: ``NAME.html`` and ``NAME.strip.jpg`` of each trial, as far as they are there. A
plan's has sliders over the same simulation.
"""

from __future__ import annotations

import base64
import hashlib
import math
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from count_video.inputs import TOLERANCES
from count_video.planning.comparison import expected_counts
from count_video.planning.plan import LIKENESSES, Plan
from count_video.planning.request import PlanRequest, Tolerances
from count_video.records import Floats, TrialResult
from count_video.reports.campaign import (
    CampaignSummary,
    TrialRow,
    advice,
    summary_lines,
)
from count_video.reports.json_object import json_object, plain
from count_video.reports.plan_text import change_words, plan_headline, plan_notes, table_lines
from count_video.reports.tables import collision_lines
from count_video.reports.text import answer_words, comparison_lines, result_notes
from count_video.reports.words import counts_words, percent, printable, ratio_words, storable


@dataclass(frozen=True)
class Footage:
    """The annotated clip on the page."""

    mp4: bytes
    frame: Floats
    """Frames of the footage that it shows, shape (n,)."""
    shown_s: Floats
    """When it shows each, in seconds from its start, shape (n,)."""
    cuts: Mapping[int, Sequence[tuple[int, bytes]]]
    """Enlarged frames of each contact, by the collision's number: their indices and JPEGs."""
    clip_sha256: str = ""
    """Digest of the clip's bytes, which no other clip has; empty if not known."""


@dataclass(frozen=True)
class Picture:
    """The picture of the trial on the page."""

    data: bytes
    media_type: str
    """``image/png`` or ``image/svg+xml``."""
    panels: Sequence[Mapping[str, object]] = ()
    """Panels in which time runs to the right, as ``figure.time_panels`` gives them."""


def render(name: str, scripts: Sequence[str] = (), **values: object) -> str:
    """Fill in a template of this package.

    Parameters
    ----------
    name
        Of the template; its style is called like it, and all pages share ``page.css``.
    scripts
        Names of the scripts that run on the page, in order.
    values
        What the template asks for. Everything that is filled in is escaped, so that no name can end
        a script or begin an element.
    """
    made = Environment(
        loader=PackageLoader("count_video.reports"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters |= {"digest": _digest, "printable": printable, "percent": percent}
    made.filters |= {"ratio_words": ratio_words}
    style = _own_file("page.css") + _own_file(f"{name}.css")
    texts = [_own_file(f"{script}.js") for script in scripts]
    template = made.get_template(f"{name}.html")
    return template.render({"data": None, **values, "style": style, "scripts": texts})


def _digest(own_text: str) -> str:
    """Name a style or script as a page's policy does, so that the browser applies no other."""
    digest = hashlib.sha256(own_text.encode("utf-8")).digest()
    return f"sha256-{base64.b64encode(digest).decode('ascii')}"


def _own_file(name: str) -> Markup:
    """Read a style or script of this package, which goes into a page as it is."""
    return Markup((Path(__file__).parent / "templates" / name).read_text("utf-8"))


def _address(data: bytes, media_type: str) -> str:
    """Write a file as an address that holds all of it."""
    return f"data:{media_type};base64,{base64.b64encode(data).decode('ascii')}"


# ---- a clip --------------------------------------------------------------------------------------


def clip_page(result: TrialResult, footage: Footage | None, picture: Picture | None) -> str:
    """Write the page; without footage (no bodies were followed) it holds the answer alone."""
    name = storable(Path(result.clip).name)
    saved = f"{Path(name).stem}.corrections.json"
    data = None
    if footage is not None:
        cuts = {
            number: [(frame, _address(jpeg, "image/jpeg")) for frame, jpeg in frames]
            for number, frames in footage.cuts.items()
        }
        data = {
            "clip": name,
            "clip_sha256": footage.clip_sha256,
            "save_as": saved,
            "result": json_object(result),
            "burst_size": result.burst_size,
            "burst_ends": min((c.frame for c in result.beyond_burst), default=1e300),
            "panels": [] if picture is None else list(picture.panels),
            "frames": footage.frame.astype(int).tolist(),
            "times": footage.shown_s.round(5).tolist(),
            "cuts": cuts,
        }
    return render(
        "clip",
        () if footage is None else ("clip",),
        clip=name,
        command=f"count-video {shlex.quote(name)} --corrections {shlex.quote(saved)}",
        answer=answer_words(result),
        doubt=result.reason or "",
        facts=_facts(result),
        notes=result_notes(result),
        table="\n".join(collision_lines(result)),
        compared="\n".join(comparison_lines(result.comparison)),
        video=None if footage is None else _address(footage.mp4, "video/mp4"),
        picture=None if picture is None else _address(picture.data, picture.media_type),
        data=data,
    )


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
    if result.pi_low is not None and result.pi_high is not None:
        facts["π lies between"] = f"{result.pi_low:.5g} and {result.pi_high:.5g}"
    return facts


# ---- a campaign --------------------------------------------------------------------------------


def campaign_page(
    rows: Sequence[TrialRow], summary: CampaignSummary, picture: tuple[bytes, str]
) -> str:
    """Write the page; those that need a person come first."""
    return render(
        "campaign",
        ("campaign",),
        summary=summary.whole,
        groups=[(ratio_words(group.mass_ratio), summary_lines(group)) for group in summary.groups],
        rows=sorted(rows, key=lambda row: not row.needs_a_person),
        doubt=_doubt,
        link=_link,
        picture=_address(*picture),
    )


def _doubt(row: TrialRow) -> str:
    """Say what is doubtful about a trial and what to do, in sentences."""
    what_to_do = advice(row)
    sentences = (row.not_kept or row.result.reason, what_to_do[:1].upper() + what_to_do[1:])
    return printable(". ".join(filter(None, sentences)))


def _link(row: TrialRow, suffix: str) -> str | None:
    """Address of a file beside the page; None if it is not there."""
    name = f"{row.name}.{suffix}"
    return quote(name) if name in row.files else None


# ---- a plan ------------------------------------------------------------------------------------

MOST_RATIO = 10_000.0
"""Largest mass ratio that the sliders reach, unless a larger one is planned."""
LIGHT_FACTOR = 4.0
LOGARITHMIC_STEP = 0.002


def plan_page(plan: Plan) -> str:
    """Write the page: sliders over the same simulation, in one file, without a network."""
    request = plan.request
    sliders = _sliders(plan)
    return render(
        "plan",
        ("plan_core", "plan"),
        headline=plan_headline(plan),
        count=plan.burst.count,
        sliders=sliders,
        alike=request.heavy_thread_m == request.light_thread_m,
        change=change_words(plan),
        notes=plan_notes(plan),
        table="\n".join(table_lines(plan.table)),
        data={
            "planned": {slider["name"]: slider["planned"] for slider in sliders},
            "damping": request.damping_per_s,
            "ballDiameter": request.ball_diameter_m,
            "tolerances": plain(request.tolerances),
            "seed": request.seed,
            "options": _options_beside(request),
            "likenesses": plain(LIKENESSES),
        },
    )


def _options_beside(request: PlanRequest) -> str:
    """Options of the command line that are not their defaults and have no slider."""
    options = f" --damping {request.damping_per_s:g}" if request.damping_per_s else ""
    for name, (field, _) in TOLERANCES.items():
        value = getattr(request.tolerances, field)
        if value != getattr(Tolerances(), field):
            options += f" --tolerance {name}={value:g}"
    return options + (f" --seed {request.seed}" if request.seed else "")


def _sliders(plan: Plan) -> list[dict[str, object]]:
    """Describe the sliders, in metres, the masses' unit and frames a second.

    Their ends reach as far as what is planned. Masses and rates go in even steps of the logarithm.
    """
    request, camera = plan.request, plan.camera
    heavy, light = float(request.heavy), float(request.light)
    rate = plan.framing.rate_needed_fps if camera is None else camera.capture_fps
    sliders: list[dict[str, object]] = []
    for name, label, low, high, step, planned in (
        ("gap", "Gap, ball to wall", 0.005, 0.1, 0.0005, request.gap_m),
        ("release", "Release", 0.02, 0.2, 0.001, request.release_m),
        ("heavy", "Mass of the cylinder", light, light * MOST_RATIO, None, heavy),
        ("light", "Mass of the ball", light / LIGHT_FACTOR, light * LIGHT_FACTOR, None, light),
        ("heavyThread", "Thread of the cylinder", 0.2, 3.0, 0.001, request.heavy_thread_m),
        ("lightThread", "Thread of the ball", 0.2, 3.0, 0.001, request.light_thread_m),
        ("restitution", "Restitution", 0.85, 1.0, 0.001, request.restitution),
        ("rate", "Camera", 24.0, 100_000.0, None, rate),
    ):
        least, most, value = min(planned, low), max(planned, high), planned
        if step is None:
            least, most = round(math.log10(least), 4), round(math.log10(most), 4)
            value = math.log10(planned)
        slider: dict[str, object] = {"name": name, "label": label, "step": step or LOGARITHMIC_STEP}
        sliders.append(slider | {"least": least, "most": most, "value": value, "planned": planned})
    return sliders
