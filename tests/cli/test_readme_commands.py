"""What README.md promises: its commands run, and it knows every option."""

from __future__ import annotations

import re
import shlex
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

from count_video import cli as count_cli
from synth_video import cli as synth_cli

TOP = Path(__file__).parents[2]
OPTION = re.compile(r"(?<![\w-])--[a-z][a-z-]*")
COMMANDS: dict[str, Callable[[list[str]], int]] = {
    "count-video": count_cli.main,
    "synth-video": synth_cli.main,
}


def readme() -> str:
    return (TOP / "README.md").read_text("utf-8")


def quick_start() -> list[str]:
    """Return the shell blocks of README.md's "Quick start"."""
    section = re.search(r"^## Quick start\n(.*?)(?=^## |\Z)", readme(), re.M | re.S)
    assert section is not None, "README.md has a section Quick start"
    return re.findall(r"^```sh\n(.*?)^```$", section[1], re.M | re.S)


def calls(text: str, command: str) -> list[list[str]]:
    """Return the arguments of every line that calls a command, with or without its folder."""
    lines = [shlex.split(line, comments=True) for line in text.replace("\\\n", " ").splitlines()]
    return [words[1:] for words in lines if words and Path(words[0]).name == command]


def options_in_help(command: str, capsys: pytest.CaptureFixture[str]) -> set[str]:
    with suppress(SystemExit):  # argparse leaves that way
        COMMANDS[command](["--help"])
    return set(OPTION.findall(capsys.readouterr().out))


def test_the_quick_start_is_two_blocks_that_each_make_their_environment() -> None:
    first, second = quick_start()
    for block in (first, second):
        assert "python3 -m venv" in block
        assert "pip install" in block
    assert calls(first, "count-video") != []
    assert "pytest" in second.strip().splitlines()[-1], "the summary of the tests comes last"


def test_the_first_block_counts_what_it_says(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(TOP)
    for arguments in calls(quick_start()[0], "count-video"):
        assert count_cli.main(arguments) == 0
        assert capsys.readouterr().out != ""


@pytest.mark.parametrize("command", COMMANDS)
def test_every_option_is_documented(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    documented = set(OPTION.findall(readme()))
    assert options_in_help(command, capsys) - documented - {"--help"} == set()


@pytest.mark.parametrize("command", COMMANDS)
def test_every_option_in_an_example_exists(
    command: str, capsys: pytest.CaptureFixture[str]
) -> None:
    existing = options_in_help(command, capsys)
    blocks = re.findall(r"^```(?:sh|console|text)?\n(.*?)^```$", readme(), re.M | re.S)
    used = {
        word.partition("=")[0]
        for block in blocks
        for arguments in example_calls(block, command)
        for word in arguments
        if OPTION.match(word)
    }
    assert used - existing == set()


def example_calls(block: str, command: str) -> list[list[str]]:
    """Return the calls in a block that may also show output, as after a prompt."""
    lines = [line.removeprefix("$ ") for line in block.replace("\\\n", " ").splitlines()]
    named = [line for line in lines if re.match(rf"\S*{command}(\s|$)", line)]
    return [call for line in named for call in calls(line, command)]
