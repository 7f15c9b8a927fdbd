from __future__ import annotations

import re
import shlex
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from count_video import __version__
from count_video.errors import UsageError
from count_video.options import is_campaign, read_options


def test_a_clip_alone_leaves_everything_to_be_found() -> None:
    options = read_options(["trial.mp4"])
    assert options.clips == [Path("trial.mp4")]
    assert options.ball_diameter_mm == 40.0
    assert options.start == 0
    nothing = (options.capture_fps, options.wall, options.region, options.end, options.masses)
    assert nothing == (None,) * 5
    assert not options.json


def test_every_option_arrives_in_its_unit() -> None:
    options = read_options(
        shlex.split(
            "--json --capture-fps 959.04 --start 10 --end 20 --region 1,2,640,240 --wall right "
            "--ball-diameter-mm 38.5 --masses 1050 10.5 a.mp4 b.mp4"
        )
    )
    assert options.json
    assert options.capture_fps == 959.04
    assert (options.start, options.end) == (10, 20)
    assert options.region == (1, 2, 640, 240)
    assert options.wall == "right"
    assert options.ball_diameter_mm == 38.5
    assert options.masses == (Fraction(1050), Fraction(21, 2))
    assert options.clips == [Path("a.mp4"), Path("b.mp4")]


@given(st.decimals(min_value=0, allow_nan=False, allow_infinity=False, places=9).filter(bool))
def test_a_mass_is_taken_at_its_exact_decimal_value(mass: object) -> None:
    options = read_options(["a.mp4", "--masses", f"{mass:f}", "0.000000001"])
    assert options.masses == (Fraction(f"{mass:f}"), Fraction(1, 10**9))


@pytest.mark.parametrize(
    "arguments",
    [
        "",
        "--json",
        "a.mp4 --no-such-option",
        "a.mp4 --capture 960",
        "a.mp4 --capture-fps",
        "a.mp4 --capture-fps 0",
        "a.mp4 --capture-fps -960",
        "a.mp4 --capture-fps nan",
        "a.mp4 --capture-fps inf",
        "a.mp4 --capture-fps fast",
        "a.mp4 --ball-diameter-mm 0",
        "a.mp4 --ball-diameter-mm -40",
        "a.mp4 --ball-diameter-mm nan",
        "a.mp4 --ball-diameter-mm 4cm",
        "a.mp4 --wall top",
        "a.mp4 --region 1,2,3",
        "a.mp4 --region 1,2,3,4,5",
        "a.mp4 --region 1,2,3,x",
        "a.mp4 --region 1.5,2,3,4",
        "a.mp4 --region=-1,2,3,4",
        "a.mp4 --region 1,2,0,4",
        "a.mp4 --region 1,2,3,0",
        "a.mp4 --start -1",
        "a.mp4 --start 1.5",
        "a.mp4 --end 0",
        "a.mp4 --start 5 --end 5",
        "a.mp4 --start 6 --end 5",
        "a.mp4 --masses 100",
        "a.mp4 --masses 100 0",
        "a.mp4 --masses 100 -1",
        "a.mp4 --masses 1 100",
        "a.mp4 --masses nan 1",
        "a.mp4 --masses 100 10,5",
        "a.mp4 --masses 1e999999999 1",
        "a.mp4 --format svg",
        "a.mp4 --csv-dialect semicolon",
        "clips --fresh",
        "--corrections a.json trials.csv",
        "--corrections a.json a.mp4 b.mp4",
        "--corrections a.json --scheduler host:8786 a.mp4",
    ],
)
def test_a_wrong_request_is_refused_in_one_line(arguments: str) -> None:
    with pytest.raises(UsageError) as refusal:
        read_options(arguments.split())
    assert str(refusal.value).splitlines() == [str(refusal.value)]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ("a.mp4 --region -10,0,50,50", "'-10,0,50,50' begins outside the picture"),
        ("a.mp4 --region=-10,0,50,50", "'-10,0,50,50' begins outside the picture"),
        ("a.mp4 --end 0", "leaves no frame before end 0: give an end above it"),
        ("http://example.com/x.mp4", "'http://example.com/x.mp4' is an address; download"),
        ("a.mp4 --capture-fps 1e8", "from 1 to 10 000 000 frames per second"),
        ("--plan 2 1 --gap 5000", "from 0.000001 to 1000 m"),
    ],
)
def test_a_refusal_names_the_fault_itself(arguments: str, words: str) -> None:
    with pytest.raises(UsageError) as refusal:
        read_options(arguments.split())
    assert words in str(refusal.value)


def test_clips_may_stand_on_both_sides_of_an_option() -> None:
    assert read_options(["a.mp4", "--json", "b.mp4"]).clips == [Path("a.mp4"), Path("b.mp4")]


@pytest.mark.parametrize(("jobs", "together"), [("", False), ("--jobs 2", True)])
def test_clips_that_are_counted_at_the_same_time_are_a_campaign(jobs: str, together: bool) -> None:
    assert is_campaign(read_options(f"a.mp4 b.mp4 {jobs}".split())) == together


@pytest.mark.parametrize("option", ["--capture-fps", "--region", "--ball-diameter-mm", "--start"])
def test_a_refusal_names_the_option_and_the_value(option: str) -> None:
    with pytest.raises(UsageError, match=f"{option}.*'bad'"):
        read_options(["a.mp4", option, "bad"])


def test_the_version_is_that_of_the_package(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        read_options(["--version"])
    assert left.value.code == 0
    assert capsys.readouterr().out == f"count-video {__version__}\n"


def test_the_help_gives_every_value_its_default(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        read_options(["--help"])
    text = capsys.readouterr().out
    # An entry starts with an option and runs to the next entry or heading.
    entries = re.split(r"\n(?=  -|\w|\n)", text.partition("options:")[2])
    with_value = [entry for entry in entries if re.match(r"  --[a-z-]+ [A-Z{]", entry)]
    assert len(with_value) == 24
    assert all("(default: " in " ".join(entry.split()) for entry in with_value)


def test_the_help_fits_a_terminal_of_eighty_columns(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    with pytest.raises(SystemExit):
        read_options(["--help"])
    assert max(map(len, capsys.readouterr().out.splitlines())) <= 80


@pytest.mark.parametrize("argument", ["--end=", "--capture-fps=", "--nope=", "--wall="])
@pytest.mark.parametrize("sign", ["9", "'", '"', "\x1b", "\u202e"])
def test_a_long_value_comes_back_short_and_in_one_pair_of_quotes(argument: str, sign: str) -> None:
    with pytest.raises(UsageError) as refusal:
        read_options([f"{argument}{sign * 6000}", "a.mp4"])
    said = str(refusal.value)
    assert len(said) < 1200, "an escape takes up to ten characters"
    assert sign.isprintable() or sign not in said
    assert sign != "9" or not re.search("""["']{2}""", said), "quoted twice"
