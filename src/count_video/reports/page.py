"""The page of one clip: everything in one file, without a network, for a person to check."""

from __future__ import annotations

import base64
import hashlib
import math
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from count_video.planning.comparison import expected_counts
from count_video.records import Collision, Estimate, Floats, TrialResult
from count_video.reports.frame_samples import ContactFrame
from count_video.reports.material import burst_size
from count_video.reports.printable import printable, storable
from count_video.reports.text import counts_words, plural, ratio_words, result_text

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
    """Where on it time runs to the right, as ``figure.time_panels`` says."""


def clip_page(result: TrialResult, footage: Footage | None, picture: Picture | None) -> str:
    """Write the page; without footage (no bodies were followed) it holds the answer alone."""
    name = Path(result.clip).name
    return render(
        "clip",
        clip=printable(name),
        command=_command(name),
        answer=_answer(result),
        doubt=printable(result.reason or ""),
        facts=_facts(result),
        text=result_text(result),
        video=None if footage is None else _base64(footage.mp4),
        picture=None if picture is None else _base64(picture.data),
        picture_type=None if picture is None else picture.media_type,
        data=None if footage is None else _data(result, footage, picture),
    )


def render(name: str, **values: object) -> str:
    """Fill in a template of this package, with the style and the scripts that are called like it.

    Everything that is filled in is escaped; ``own`` reads a file of the package as it is.
    """
    made = Environment(
        loader=PackageLoader("count_video.reports"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters["digest"] = _digest
    made.globals["own"] = _own_file
    return made.get_template(f"{name}.html").render(**values)


def _digest(own_text: str) -> str:
    """Name a style or script as a page's policy does, so that the browser applies no other."""
    digest = hashlib.sha256(own_text.encode("utf-8")).digest()
    return f"sha256-{base64.b64encode(digest).decode('ascii')}"


def _own_file(*names: str) -> Markup:
    """Styles or scripts of this package, which go into a page as they are."""
    folder = Path(__file__).parent / "templates"
    return Markup("".join((folder / name).read_text("utf-8") for name in names))


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
        ("Probability", None if chance is None else f"{chance:.0%}"),
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
    size = burst_size(result)
    beyond = [c.frame for c in result.collisions if c.number > size]
    return {
        "clip": name,
        "clip_sha256": footage.clip_sha256,
        "save_as": f"{Path(name).stem}.corrections.json",
        "count": result.count,
        "ms_a_frame": None if not result.capture_fps else 1000 / result.capture_fps,
        "panels": [] if picture is None else list(picture.panels),
        "burst_ends": min(beyond, default=1e300),
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
