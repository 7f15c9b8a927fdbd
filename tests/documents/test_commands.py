"""What README.md and docs/ promise: their commands run, and they know every option."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

from count_video import cli as count_cli
from pages import PAGES, TOP, blocks, section
from synth_video import cli as synth_cli

OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*")
COMMANDS: dict[str, Callable[[list[str]], int]] = {
    "count-video": count_cli.main,
    "synth-video": synth_cli.main,
}
SUBCOMMANDS = {"count-video": (), "synth-video": ("campaign", "suite", "score")}


def quick_start() -> list[str]:
    """Return the shell blocks of README.md's "Quick start" that make an environment."""
    return [block for block in blocks(section("README.md", "Quick start"), "sh") if "venv" in block]


def calls(text: str, command: str) -> list[list[str]]:
    """Return the arguments of every line that calls a command, with or without its folder."""
    lines = [shlex.split(line, comments=True) for line in text.replace("\\\n", " ").splitlines()]
    return [words[1:] for words in lines if words and Path(words[0]).name == command]


def documents() -> list[tuple[str, str]]:
    """Return the pages for users with their names."""
    return [(str(path.relative_to(TOP)), path.read_text("utf-8")) for path in PAGES]


def options_in_help(command: str, capsys: pytest.CaptureFixture[str], *part: str) -> set[str]:
    with suppress(SystemExit):  # argparse leaves that way
        COMMANDS[command]([*part, "--help"])
    return set(OPTION.findall(capsys.readouterr().out))


def test_the_quick_start_is_two_blocks_that_each_make_their_environment() -> None:
    first, second = quick_start()
    for block in (first, second):
        assert "python3 -m venv" in block
        assert "pip install" in block
    assert calls(first, "count-video") != []
    assert "pytest" in second.strip().splitlines()[-1], "the summary of the tests comes last"


@pytest.mark.parametrize("command", COMMANDS)
def test_every_option_is_documented(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    documented = set(OPTION.findall("".join(text for _, text in documents())))
    assert options_in_help(command, capsys) - documented - {"--help"} == set()


@pytest.mark.parametrize("command", COMMANDS)
def test_every_option_in_an_example_exists(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    existing = options_in_help(command, capsys)
    for part in SUBCOMMANDS[command]:
        existing |= options_in_help(command, capsys, part)
    used = {
        word.partition("=")[0]
        for _, text in documents()
        for block in blocks(text, "sh", "console", "text", "")
        for arguments in example_calls(block, command)
        for word in arguments
        if OPTION.match(word)
    }
    assert used
    assert used - existing == set()


def example_calls(block: str, command: str) -> list[list[str]]:
    """Return the calls in a block that may also show output, as after a prompt."""
    lines = [line.removeprefix("$ ") for line in block.replace("\\\n", " ").splitlines()]
    named = [line for line in lines if re.match(rf"\S*{command}(\s|$)", line)]
    return [call for line in named for call in calls(line, command)]
