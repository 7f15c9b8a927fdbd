"""Numbers and text files from outside: whatever comes in is read, or refused in one short line."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from count_video import inputs
from count_video.errors import UsageError
from count_video.options import read_options

MOST_BYTES = 1000
LONGEST_LINE = 300
"""What is echoed, 83 characters with escapes and quotes, and the words about it."""
READERS: dict[str, Callable[[str], object]] = {
    reader: getattr(inputs, reader)
    for reader in (
        *("CAPTURE_RATE", "BALL_DIAMETER", "FRAME", "CLIPS_AT_A_TIME"),
        *("region", "address", "some_path"),
        *("LENGTH", "SHARE", "DAMPING", "TRIALS", "SEED", "tolerance"),
    )
} | {"mass": inputs.MASS.exact}
ODD_NUMBERS = (
    *("nan", "inf", "-inf", "-1", "1e308", "1e-300", "5e-324", "1e999999999", "9" * 6000),
    *(
        "٣",
        "３",
        "1_000",
        " 5",
        "5\n",
        "0x10",
        "1,5",
        "",
        ".",
        "1e",
        "--",
        "½",
        "\u202e5",
        "\x1b[2J",
        *("1/0", "1/", "/3", "1/1e3", f"{'9' * 401}/7"),
    ),
)


def tried(read: Callable[[], object]) -> tuple[object, str]:
    """Return what is read, and the refusal, of which one is empty."""
    try:
        return read(), ""
    except UsageError as error:
        return None, str(error)
    except SystemExit as done:  # --help
        return done.code, ""


@pytest.mark.parametrize("reader", READERS)
@given(text=st.text(max_size=200) | st.sampled_from(ODD_NUMBERS) | st.from_regex(r"[-+.,:eE0-9]+"))
def test_any_text_is_a_value_or_refused_in_one_short_line(reader: str, text: str) -> None:
    value, refusal = tried(lambda: READERS[reader](text))
    if refusal:
        assert len(refusal) <= LONGEST_LINE
        assert refusal.isprintable()
    else:
        assert isinstance(value, Path) or text.isascii()
        assert not isinstance(value, float) or math.isfinite(value)


def test_a_number_may_be_a_fraction() -> None:
    assert inputs.MASS.exact("1/3") == Fraction(1, 3)
    assert inputs.CAPTURE_RATE("60000/1001") == 60000 / 1001


@pytest.mark.parametrize("text", ODD_NUMBERS)
@pytest.mark.parametrize(
    "reader",
    [
        *("CAPTURE_RATE", "BALL_DIAMETER", "FRAME", "CLIPS_AT_A_TIME"),
        *("LENGTH", "TRIALS", "SEED"),
    ],
)
def test_what_is_no_number_of_physical_sense_is_refused(reader: str, text: str) -> None:
    with pytest.raises(UsageError):
        READERS[reader](text)


@pytest.mark.parametrize("text", sorted({*ODD_NUMBERS} - {"1e-300", "5e-324"}))
@pytest.mark.parametrize("reader", ["SHARE", "DAMPING"])
def test_what_may_be_0_may_be_next_to_it_but_no_other_odd_number(reader: str, text: str) -> None:
    assert READERS[reader]("1e-300") == 1e-300
    with pytest.raises(UsageError):
        READERS[reader](text)


@given(st.floats(inputs.CAPTURE_RATE.low, inputs.CAPTURE_RATE.high))
def test_every_number_in_the_range_is_read_as_it_is(rate: float) -> None:
    assert inputs.CAPTURE_RATE(repr(rate)) == rate


@given(st.floats(allow_nan=False).filter(lambda rate: not 1 <= rate <= 1e7))
def test_every_number_outside_of_the_range_is_refused(rate: float) -> None:
    with pytest.raises(UsageError, match="from 1 to 10 000 000 frames per second"):
        inputs.CAPTURE_RATE(repr(rate))


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (0, "0"),
        (1e-6, "0.000001"),
        (0.01, "0.01"),
        (1000, "1000"),
        (1e5, "100 000"),
        (1e40, "1e+40"),
    ],
)
def test_a_number_is_written_as_people_do(value: float, words: str) -> None:
    assert inputs.number_words(value) == words


def test_masses_are_exact_and_their_ratio_is_bounded() -> None:
    assert inputs.MASS.exact("10.5") == Fraction(21, 2)
    assert inputs.masses(Fraction(100), Fraction(1)) == (100, 1)
    with pytest.raises(UsageError, match="ratio"):
        inputs.masses(inputs.MASS.exact("1e99"), inputs.MASS.exact("1e-99"))


@given(st.sampled_from(sorted(inputs.TOLERANCES)), st.floats(0, 1))
def test_a_tolerance_is_a_field_and_a_number_in_its_range(name: str, value: float) -> None:
    field, allowed = inputs.TOLERANCES[name]
    assert inputs.tolerance(f"{name}={value!r}") == (field, value)
    above = repr(2 * allowed.high)
    for text in (
        name,
        f"{name}=",
        f"{name}= {value!r}",
        f"{name}=-1",
        f"{name}={above}",
        f"x{name}=1",
    ):
        with pytest.raises(UsageError):
            inputs.tolerance(text)


@given(st.recursive(st.none() | st.booleans() | st.floats() | st.integers() | st.text(), st.lists))
@example(10**400)
@example(-(10**400))
def test_a_number_in_json_is_within_its_range_or_none(value: object) -> None:
    number = inputs.stored_number(value, inputs.FRAME)
    assert number is None or 0 <= number <= inputs.FRAME.high
    assert number is None or number == value


@given(st.text(max_size=500))
def test_what_is_shown_of_a_text_is_short_and_printable(text: str) -> None:
    shown = inputs.shown(text)
    assert shown.isprintable()
    assert len(shown) <= inputs.SHOWN_CHARACTERS + 2, "both quotes, or the dots and one quote"


OPTIONS = (
    "--capture-fps",
    "--start",
    "--end",
    "--jobs",
    "--region",
    "--scheduler",
    "-o",
    "--masses",
    "--plan",
    "--plan-file",
    "--gap",
    "--trials",
    "--tolerance",
)


@settings(max_examples=60)
@given(
    st.lists(
        st.sampled_from((*OPTIONS, "--json", "--theory", "--", "a.mp4", "1", "100"))
        | st.builds("{}={}".format, st.sampled_from(OPTIONS), st.text(max_size=300))
        | st.text(max_size=300),
        max_size=6,
    )
)
@example(["--start=--", "a.mp4"])
@example(["-o--", "a.mp4"])
@example(["", "a.mp4"])
@example(["-o", "", "a.mp4"])
@example(["--json=" + "9" * 6000])
@example(["--nothing=" + "a " * 3000])
def test_any_command_line_is_read_or_refused_in_one_line(arguments: list[str]) -> None:
    options, refusal = tried(lambda: read_options(arguments))
    assert "\n" not in refusal
    assert len(refusal) < 1000
    if not refusal and options:
        assert set(options.clips) <= set(map(Path, arguments)), "no clip is made up"


def test_a_text_file_is_read_with_and_without_a_mark(tmp_path: Path) -> None:
    file = tmp_path / "file.csv"
    for content in ("clip\n", "\ufeffclip\n"):
        file.write_text(content, "utf-8")
        assert inputs.read_text(file, MOST_BYTES) == "clip\n"


def make_pipe(path: Path) -> None:
    os.mkfifo(path)


def make_endless(path: Path) -> None:
    path.symlink_to("/dev/zero")


def make_large(path: Path) -> None:
    path.write_bytes(b"a" * (MOST_BYTES + 1))


def make_binary(path: Path) -> None:
    path.write_bytes(b"\xff\xfe\x00")


def make_folder(path: Path) -> None:
    path.mkdir()


def make_nothing(path: Path) -> None:
    assert not path.exists()


@pytest.mark.parametrize(
    "make", [make_pipe, make_endless, make_large, make_binary, make_folder, make_nothing]
)
def test_what_is_no_bounded_text_file_is_refused_at_once(
    make: Callable[[Path], None], tmp_path: Path
) -> None:
    make(tmp_path / "file.csv")
    with pytest.raises(UsageError) as refused:
        inputs.read_text(tmp_path / "file.csv", MOST_BYTES)
    assert str(refused.value).startswith(f"{tmp_path / 'file.csv'}: ")
    assert "\n" not in str(refused.value)


@given(
    st.text()
    | st.recursive(st.floats() | st.integers() | st.text(), st.lists).map(json.dumps)
    | st.integers(1, 100_000).map(lambda depth: "[" * depth)
    | st.sampled_from(["9" * 5000, "[NaN]", '{"a": Infinity}', '{"a": 1e999}'])
)
def test_any_text_is_a_json_object_or_refused(
    tmp_path_factory: pytest.TempPathFactory, text: str
) -> None:
    file = tmp_path_factory.getbasetemp() / "any.json"
    file.write_bytes(text.encode("utf-8", "surrogatepass"))
    stored, refusal = tried(lambda: inputs.read_json_object(file))
    assert isinstance(stored, dict) or refusal
    assert "\n" not in refusal


@pytest.mark.parametrize("make", [make_pipe, make_endless, make_folder])
def test_what_is_no_regular_file_has_no_digest(
    make: Callable[[Path], None], tmp_path: Path
) -> None:
    make(tmp_path / "clip.mp4")
    with pytest.raises((UsageError, OSError)):
        inputs.content_digest(tmp_path / "clip.mp4")
