"""Any request for a clip: one JSON object, one exit code, one line on stderr."""

from __future__ import annotations

import io
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path

import numpy as np
import pytest
from command import Answer, faults_of
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from count_video.cli import main
from count_video.video.writer import write_clip

VALUES = (
    *("nan", "inf", "-1", "0", "1", "7", "960", "1e308", "5e-324", "9" * 6000, "٣", "1_000", "--"),
    *("", " 5", "0x10", "1,5", "½", "\x1b[2J", "\u202e5", "0,0,16,16", "0,0,99999,16", "left"),
)
OPTIONS = (
    *("--capture-fps", "--ball-diameter-mm", "--start", "--end", "--region", "--wall", "--jobs"),
    *("--corrections", "--masses", "--format", "--theory", "--plan", "--plan-file"),
)


@pytest.fixture(scope="module")
def clip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A clip of two frames, which is read and refused at once."""
    path = tmp_path_factory.mktemp("any") / "clip.mp4"
    write_clip(path, [np.full((48, 64), level, np.uint8) for level in (40, 200)])
    return path


def answer_to(*arguments: str) -> Answer:
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        code = main(arguments)
    return Answer(code, out.getvalue(), err.getvalue(), 0)


@settings(max_examples=80, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    st.lists(
        st.builds("{}={}".format, st.sampled_from(OPTIONS), st.sampled_from(VALUES) | st.text())
        | st.sampled_from(("--json", "--seen-only", "--fresh", "--pages", "--nope", "-x")),
        max_size=3,
    )
)
def test_any_options_give_one_answer(clip: Path, options: list[str]) -> None:
    answer = answer_to("--json", *options, "--", str(clip))
    assert faults_of(answer, 1) == []
    assert answer.code in (1, 2)
    assert answer.err.count("\n") == 1


PLAN_OPTIONS = (
    *("--gap", "--release", "--thread", "--restitution", "--damping", "--trials", "--seed"),
    *("--tolerance", "--capture-fps", "--ball-diameter-mm"),
)


@settings(max_examples=80)
@given(
    st.sampled_from(("1e999999999", "1e-100", "1e100", "٣", "1e40", "-1", "1_000")),
    st.lists(
        st.builds("{}={}".format, st.sampled_from(PLAN_OPTIONS), st.sampled_from(VALUES)),
        max_size=3,
    ),
)
def test_any_plan_that_makes_no_sense_gives_one_line(light: str, options: list[str]) -> None:
    answer = answer_to("--json", "--plan", "1", light, *options)
    assert (answer.code, answer.out, answer.err.count("\n")) == (2, "", 1)


@settings(max_examples=80)
@given(st.text(st.characters(exclude_characters="\0"), min_size=1))
def test_any_name_of_a_clip_that_is_not_there_gives_one_answer(name: str) -> None:
    answer = answer_to("--json", "--", f"no-such-folder/{name}.mp4")
    assert faults_of(answer, 1) == []
    assert (answer.code, answer.err.count("\n")) == (1, 1)


def test_a_single_picture_is_said_to_be_one(tmp_path: Path) -> None:
    path = tmp_path / "clip.mp4"
    write_clip(path, [np.full((48, 64), 90, np.uint8)])
    answer = answer_to("--json", str(path))
    assert (answer.code, faults_of(answer, 1)) == (1, [])
    assert "one picture alone" in answer.err
