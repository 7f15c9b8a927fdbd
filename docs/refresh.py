"""Make the outputs and the pictures of README.md and docs/ anew, by the commands shown there.

``python docs/refresh.py`` in the top folder of the checkout replaces what stands below each command
of ``count-video`` in a block marked ``console``, and the pictures in ``docs/pictures`` but that of
the noise (``tests/tracking/noise_sweep.py`` makes it). A block that leaves lines out, by a line of
three dots, keeps as many lines before and after the dots as it had. The tests compare all of it
with what the commands do, but for the last digits of measured values.
"""

from __future__ import annotations

import io
import re
import shlex
import shutil
import sys
import tempfile
from collections.abc import Callable
from contextlib import redirect_stdout
from pathlib import Path

from count_video.cli import main

TOP = Path(__file__).parents[1]
PAGES = ("README.md", "docs/filming.md", "docs/result.md")
CLIP = "fixtures/ratio100-count31.mp4"
PICTURES = {
    "ratio100-count31.png": f"{CLIP} --masses 1.050 0.0105 --capture-fps 3000",
    "plan.png": "--plan 1050 10.5 --capture-fps 240",
    "theory.png": "--theory 1050 10.5",
}
"""For each picture the arguments that make it, without the folder."""
LEFT_OUT = "..."
BLOCK = re.compile(r"^```console\n\$ count-video (?P<call>.*?)\n(?P<shown>.*?)^```$", re.M | re.S)


def refreshed(page: str, output: Callable[[str], str]) -> str:
    """Return a page with the output of every command as it is now.

    Parameters
    ----------
    page
        Text of the page.
    output
        Gives what ``count-video`` prints for its arguments.
    """

    def block(found: re.Match[str]) -> str:
        lines = shortened(output(found["call"]).splitlines(), found["shown"].splitlines())
        return "\n".join(["```console", f"$ count-video {found['call']}", *lines, "```"])

    return BLOCK.sub(block, page)


def shortened(lines: list[str], like: list[str]) -> list[str]:
    """Leave out lines where others were left out before."""
    dots = next((place for place, line in enumerate(like) if line.strip() == LEFT_OUT), None)
    if dots is None:
        return lines
    # A sentence may take a line more or less than it did: the rows below the headings are kept.
    heading = heading_of(like)
    rows, last = dots - heading, len(like) - dots - 1
    return [*lines[: heading_of(lines) + rows], like[dots], *lines[len(lines) - last :]]


def heading_of(lines: list[str]) -> int:
    """Return the place of the line with the headings of the columns."""
    return next(place for place, line in enumerate(lines) if line.startswith("   no.  kind"))


def printed(call: str) -> str:
    """Return what the command prints, run in the top folder of the checkout."""
    printed = io.StringIO()
    with redirect_stdout(printed):
        main(shlex.split(call))
    return printed.getvalue()


def make_picture(name: str, folder: Path) -> Path:
    """Make one of the pictures in a folder."""
    printed(f"{PICTURES[name]} -o {shlex.quote(str(folder))}")
    return folder / name


def refresh() -> None:
    """Write all pages and pictures."""
    for name in PAGES:
        path = TOP / name
        path.write_text(refreshed(path.read_text("utf-8"), printed), "utf-8")
    with tempfile.TemporaryDirectory() as folder:
        for name in PICTURES:
            shutil.copy(make_picture(name, Path(folder)), TOP / "docs/pictures" / name)


if __name__ == "__main__":
    sys.exit(refresh())
