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
from dataclasses import asdict, dataclass
from pathlib import Path
from urllib.parse import quote

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from count_video.planning import plan as measured
from count_video.planning.comparison import expected_counts
from count_video.planning.plan import Measured, Plan
from count_video.records import Collision, Estimate, Floats, TrialResult
from count_video.reports.campaign import (
    CampaignSummary,
    TrialRow,
    advice,
    physics_lines,
    summary_lines,
)
from count_video.reports.material import ContactFrame
from count_video.reports.plan_text import change_words, plan_headline, plan_notes, table_lines
from count_video.reports.tables import collision_lines
from count_video.reports.text import comparison_lines, result_notes
from count_video.reports.words import (
    counts_words,
    percent,
    plural,
    printable,
    ratio_words,
    storable,
)

MEDIA_TYPES = {"png": "image/png", "svg": "image/svg+xml"}


@dataclass(frozen=True)
class Footage:
    """The annotated clip on the page."""

    mp4: bytes
    frame: Floats
    """Frames of the footage that it shows, shape (n,)."""
    shown_s: Floats
    """When it shows each, in seconds from its start, shape (n,)."""
    cuts: Mapping[int, Sequence[ContactFrame]]
    """Enlarged frames of each contact, by the collision's number."""
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


def clip_page(result: TrialResult, footage: Footage | None, picture: Picture | None) -> str:
    """Write the page; without footage (no bodies were followed) it holds the answer alone."""
    name = Path(result.clip).name
    return render(
        "clip",
        () if footage is None else ("clip",),
        clip=printable(name),
        command=_command(name),
        answer=_answer(result),
        doubt=printable(result.reason or ""),
        facts=_facts(result),
        notes=result_notes(result),
        table="\n".join(collision_lines(result)),
        compared="\n".join(comparison_lines(result.comparison)),
        video=None if footage is None else _base64(footage.mp4),
        picture=None if picture is None else _base64(picture.data),
        picture_type=None if picture is None else picture.media_type,
        data=None if footage is None else _data(result, footage, picture),
    )


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
    made.filters["digest"] = _digest
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


def _command(name: str) -> str:
    saved = f"{Path(name).stem}.corrections.json"
    return printable(f"count-video {shlex.quote(name)} --corrections {shlex.quote(saved)}")


def _answer(result: TrialResult) -> str:
    return "not counted" if result.count is None else plural(result.count, "collision")


def _facts(result: TrialResult) -> list[tuple[str, str]]:
    """List what stands beside the count at the top; what is not known is left out."""
    chance = None if result.count is None else result.probability.get(result.count)
    ratio, expected = result.mass_ratio, expected_counts(result)
    measured = None if ratio is None else Estimate(ratio, result.mass_ratio_sigma or 0.0)
    facts = [
        ("Probability", None if chance is None else percent(chance)),
        ("Theory", None if expected is None else counts_words(*expected.free)),
        ("Mass ratio", None if measured is None else f"{ratio_words(measured)} : 1"),
    ]
    if result.pi_low is not None and result.pi_high is not None:
        facts.append(("π lies between", f"{result.pi_low:.5g} and {result.pi_high:.5g}"))
    return [(label, value) for label, value in facts if value is not None]


def _base64(data: bytes) -> str:
    return base64.b64encode(data).decode("ascii")


def _data(result: TrialResult, footage: Footage, picture: Picture | None) -> dict[str, object]:
    """Collect what the script works with; jinja2 escapes it so that no name can end the script."""
    name = storable(Path(result.clip).name)
    size = result.burst_size
    return {
        "clip": name,
        "clip_sha256": footage.clip_sha256,
        "save_as": f"{Path(name).stem}.corrections.json",
        "count": result.count,
        "ms_a_frame": None if not result.capture_fps else 1000 / result.capture_fps,
        "panels": [] if picture is None else list(picture.panels),
        "burst_ends": min((c.frame for c in result.beyond_burst), default=1e300),
        "frames": [int(frame) for frame in footage.frame],
        "times": [round(float(time), 5) for time in footage.shown_s],
        "collisions": [_entry(c, size, footage.cuts.get(c.number, ())) for c in result.collisions],
        "corrections": [
            {key: getattr(correction, key) for key in ("action", "kind", "frame", "number")}
            for correction in result.corrections
        ],
    }


def _entry(collision: Collision, size: int, cuts: Sequence[ContactFrame]) -> dict[str, object]:
    return {
        "number": collision.number,
        "kind": collision.kind,
        "frame": round(collision.frame, 3) if math.isfinite(collision.frame) else 0.0,
        "seen": collision.seen,
        "in_burst": collision.number <= size,
        "cuts": [
            {"frame": cut.frame, "picture": f"data:image/jpeg;base64,{_base64(cut.jpeg)}"}
            for cut in cuts
        ],
    }


# ---- a campaign --------------------------------------------------------------------------------


def campaign_page(
    rows: Sequence[TrialRow], summary: CampaignSummary, picture: tuple[bytes, str]
) -> str:
    """Write the page; those that need a person come first."""
    ordered = sorted(rows, key=lambda row: not row.needs_a_person)
    return render(
        "campaign",
        ("campaign",),
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
        "chance": "" if row.probability is None else percent(row.probability),
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


# ---- a plan ------------------------------------------------------------------------------------

MOST_RATIO = 10_000.0
"""Largest mass ratio that the sliders reach, unless a larger one is planned."""
LIGHT_FACTOR = 4.0


def plan_page(plan: Plan) -> str:
    """Write the page: sliders over the same simulation, in one file, without a network."""
    sliders = _sliders(plan)
    planned = {name: planned for name, (*_, planned) in sliders.items()}
    return render(
        "plan",
        ("plan_core", "plan"),
        headline=plan_headline(plan),
        count=plan.burst.count,
        sliders=[_slider(name, *slider) for name, slider in sliders.items()],
        alike=planned["heavyThread"] == planned["lightThread"],
        change=change_words(plan),
        notes=plan_notes(plan),
        table="\n".join(table_lines(plan.table)),
        data=_plan_data(plan, planned),
    )


def _sliders(plan: Plan) -> dict[str, tuple[str, float, float, float, float]]:
    """Label, ends, step and planned value of each slider.

    They are in metres, the masses' unit and frames a second; a step of 0 is for even steps of the
    logarithm.
    """
    request, camera = plan.request, plan.camera
    heavy, light = float(request.heavy), float(request.light)
    most = light * max(MOST_RATIO, heavy / light)
    rate = plan.framing.rate_needed_fps if camera is None else camera.capture_fps
    return {
        "gap": ("Gap, ball to wall", 0.005, 0.1, 0.0005, request.gap_m),
        "release": ("Release", 0.02, 0.2, 0.001, request.release_m),
        "heavy": ("Mass of the cylinder", light, most, 0, heavy),
        "light": ("Mass of the ball", light / LIGHT_FACTOR, light * LIGHT_FACTOR, 0, light),
        "heavyThread": ("Thread of the cylinder", 0.2, 3.0, 0.001, request.heavy_thread_m),
        "lightThread": ("Thread of the ball", 0.2, 3.0, 0.001, request.light_thread_m),
        "restitution": ("Restitution", 0.85, 1.0, 0.001, request.restitution),
        "rate": ("Camera", 24.0, 100_000.0, 0, rate),
    }


def _slider(
    name: str, label: str, low: float, high: float, step: float, planned: float
) -> dict[str, object]:
    """Describe a slider for the page; its ends reach as far as what is planned."""
    least, most, value = min(planned, low), max(planned, high), planned
    if not step:
        step, value = 0.002, math.log10(planned)
        least, most = round(math.log10(least), 4), round(math.log10(most), 4)
    about = {"name": name, "label": label, "step": step}
    return {**about, "least": least, "most": most, "value": value}


def _plan_data(plan: Plan, planned: Mapping[str, float]) -> dict[str, object]:
    request = plan.request

    def like(clips: Measured) -> dict[str, object]:
        return {**asdict(clips), "chance": clips.chance}

    return {
        "planned": planned,
        "damping": request.damping_per_s,
        "ballDiameter": request.ball_diameter_m,
        "tolerances": asdict(request.tolerances),
        "seed": request.seed,
        "measured": {
            "resolved": like(measured.RESOLVED),
            "between": like(measured.BETWEEN),
            "close": like(measured.CLOSE),
            "long": like(measured.LONG),
            "closest_frames": measured.CLOSEST_FRAMES,
            "closer_frames": measured.CLOSER_FRAMES,
            "most_of_a_short_burst": measured.MOST_OF_A_SHORT_BURST,
            "long_burst": list(measured.LONG_BURST),
            "long_burst_fps": measured.LONG_BURST_FPS,
        },
    }
