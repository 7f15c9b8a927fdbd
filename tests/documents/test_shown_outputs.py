"""The outputs that README.md and docs/ show are what the commands print now."""

from __future__ import annotations

import io
import re
import shlex
from contextlib import redirect_stdout
from functools import cache

import pytest

from count_video.cli import main
from pages import TOP, blocks, page, section


def shown(name: str) -> tuple[list[str], str]:
    """Return the arguments of the call that a page shows, and the output below it."""
    (block,) = blocks(page(name), "console")
    call, _, output = block.partition("\n")
    return shlex.split(call)[2:], output


def without_digits(text: str) -> list[str]:
    """Return the lines with every number replaced, however many signs it takes."""
    return [" ".join(re.sub(r"-?\d+(\.\d+)?", "#", line).split()) for line in text.splitlines()]


@cache
def printed_by(*arguments: str) -> str:
    """Return what the command prints in the top folder; it must succeed."""
    out = io.StringIO()
    with pytest.MonkeyPatch.context() as patch, redirect_stdout(out):
        patch.chdir(TOP)
        patch.delenv("COLUMNS", raising=False)
        assert main(arguments) == 0
    return out.getvalue()


def test_the_first_block_of_the_quick_start_counts_the_clip_whose_output_is_shown() -> None:
    block, *_ = blocks(section("README.md", "Quick start"), "sh")
    call = shlex.split(block.splitlines()[-1])
    assert call[0].endswith("bin/count-video")
    assert call[1:] == shown("README.md")[0]


@pytest.mark.parametrize("name", ["README.md", "docs/result.md"])
def test_the_output_of_a_clip_is_what_the_command_prints(name: str) -> None:
    arguments, output = shown(name)
    printed = printed_by(*arguments)
    # Counts and sentences stand as printed; measured places may differ in their last digits.
    exact = [line for line in output.splitlines() if re.search("collisions|Kinds|Evidence", line)]
    assert len(exact) == 3
    assert set(exact) <= set(printed.splitlines())
    left_out = "..."
    assert set(without_digits(output)) - {left_out} <= set(without_digits(printed))


def test_the_output_of_a_plan_is_what_the_command_prints() -> None:
    arguments, output = shown("docs/filming.md")
    assert printed_by(*arguments) == output


def test_the_figures_of_the_readme_are_those_of_the_table() -> None:
    table = section("docs/accuracy.md", "As people really film")
    (row,) = [line for line in table.splitlines() if line.startswith("| all |")]
    _, _, clips, exact, left, wrong, *_, median, _, _, _ = row.strip("| ").split("|")
    said = " ".join(section("README.md", "How accurate it is").split())
    assert f"On {int(clips)} rendered clips" in said
    assert f"{int(exact)} counts were exact" in said
    numbers = {"no": 0, "one": 1, "two": 2, "three": 3, "four": 4, "five": 5}
    words = re.findall(r"exact, (\w+) clips? w\w+ not counted, and (\w+) counts? w\w+ wrong", said)
    assert [int(numbers.get(word, word)) for word in words[0]] == [int(left), int(wrong)]
    assert f"time was {float(median):.3f} frames" in said
