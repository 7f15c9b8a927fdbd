"""What the command keeps of a clip: it names each file; the tables; the clip for a talk."""

from __future__ import annotations

import csv
import io
from contextlib import redirect_stdout
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from evidence_made import CLIP
from PIL import Image
from PIL.ImageColor import getrgb

from coded import coding_of
from count_video import cli
from count_video.reports.clip import MARGIN_PX, SIZES, Gif, Shape, counter_px, font
from count_video.reports.drawing import BALL, HEAVY, MARKS
from count_video.reports.exports import COLLISION_COLUMNS
from count_video.video.reader import open_footage
from tiers import rest_slow

SMALL = CLIP.with_name("ratio1-count3.mp4")
PART = 12, 72
"""First frame, and the one to stop before: the collisions and some frames around them."""


@dataclass(frozen=True)
class Kept:
    """A folder that the command has written into, and what it printed."""

    folder: Path
    printed: str
    shape: Shape

    def file(self, suffix: str) -> Path:
        return self.folder / f"{SMALL.stem}.{suffix}"


@pytest.fixture(scope="module", params=rest_slow(["wide", "upright"]))
def kept(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Kept:
    folder, out = tmp_path_factory.mktemp("kept"), io.StringIO()
    options = ["-o", str(folder), "--presenter", request.param, "--csv-dialect", "semicolon"]
    options += ["--start", str(PART[0]), "--end", str(PART[1])]
    with redirect_stdout(out):
        assert cli.main([str(SMALL), *options]) == 0
    return Kept(folder, out.getvalue(), request.param)


def test_the_command_says_what_it_wrote(kept: Kept) -> None:
    said = "".join(kept.printed.partition("Written")[2].split())
    assert said.startswith(f"{kept.folder}/{SMALL.stem}.html")
    files = [file.name for file in kept.folder.iterdir() if not file.name.startswith(".")]
    assert f"{SMALL.stem}.presenter.mp4" in files
    assert [name for name in files if name not in said] == []


def test_tables_are_written_in_the_dialect_that_was_asked_for(kept: Kept) -> None:
    text = kept.file("collisions.csv").read_text("utf-8")
    rows = list(csv.DictReader(text.splitlines(), delimiter=";"))
    assert tuple(rows[0]) == COLLISION_COLUMNS.names
    assert [row["kind"] for row in rows] == ["bodies", "wall", "bodies"]
    assert all("," in row["frame"] and "." not in row["frame"] for row in rows)


def test_a_clip_for_a_talk_is_full_hd_and_counts_to_the_answer(kept: Kept) -> None:
    with open_footage(kept.file("presenter.mp4")) as footage:
        assert (footage.info.width_px, footage.info.height_px) == SIZES[kept.shape]
        assert coding_of(kept.file("presenter.mp4")) == ("h264", "yuv420p")
        width, height = SIZES[kept.shape]
        beside = (slice(None), slice(0, 300)) if width > height else (slice(0, 600), slice(None))
        counters = [frame.luma[beside].astype(np.int16) for frame in footage.frames()]
    assert len(counters) == PART[1] - PART[0]
    steps = [np.abs(b - a).max() for a, b in pairwise(counters)]
    assert sum(step > 150 for step in steps) == 3
    with Image.open(kept.file("presenter.gif")) as gif:
        assert getattr(gif, "n_frames", 1) > 20
        assert gif.info.get("loop") == 0
        assert gif.size[0] / gif.size[1] == pytest.approx(width / height, rel=0.01)


def test_small_marks_keep_their_colours_beside_much_grey() -> None:
    grey = np.tile(np.linspace(0, 255, 480).astype(np.uint8)[:, None], (270, 1, 3))
    colours = [getrgb(colour) for colour in (BALL, HEAVY, *(m.colour for m in MARKS.values()))]
    for number, colour in enumerate(colours):
        grey[100:108, 50 * number : 50 * number + 8] = colour
    gif = Gif(np.array([0.0, 1.0]))
    list(gif.keeping([grey, grey]))

    with Image.open(io.BytesIO(gif.data())) as shown:
        picture = np.array(shown.convert("RGB"))

    assert [tuple(picture[104, 50 * k + 4]) for k in range(len(colours))] == colours


@pytest.mark.parametrize("shape", SIZES)
@pytest.mark.parametrize("count", [8, 31, 314])
def test_a_count_of_any_length_fits_into_a_clip_for_a_talk(shape: Shape, count: int) -> None:
    size_px, width_px = counter_px(shape, count)
    assert font(size_px).getlength(str(count)) <= width_px <= SIZES[shape][0] - 2 * MARGIN_PX


@pytest.mark.parametrize("arguments", [[], ["other.mp4", "-o", "out"]])
def test_a_clip_for_a_talk_needs_one_clip_and_a_folder(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main([str(SMALL), *arguments, "--presenter", "wide"]) == 2
    assert capsys.readouterr().err.count("\n") == 1
