from __future__ import annotations

import re
from collections.abc import Iterator
from fnmatch import fnmatch
from pathlib import Path

import pytest

TOP = Path(__file__).parents[1]
# Folders that only exist on somebody's machine; written so that this line is none of them.
MACHINE_PATH = re.compile(r"(?<![\w.*)])/(?:home|root|work|tmp|Users)/\w|\b[A-Z]:\\Users")


def test_every_import_respects_the_contracts() -> None:
    pytest.importorskip("importlinter", reason="comes with the extra 'lint'")
    from importlinter.cli import EXIT_STATUS_SUCCESS, lint_imports  # noqa: PLC0415

    assert lint_imports(config_filename=str(TOP / "pyproject.toml"), cache_dir=None) == (
        EXIT_STATUS_SUCCESS
    )


def test_no_file_names_a_folder_of_somebodys_machine() -> None:
    files = list(_own_files(TOP))
    assert Path(__file__) in files
    assert [
        f"{file.relative_to(TOP)}: {line.strip()}"
        for file in files
        for line in _text(file).splitlines()
        if MACHINE_PATH.search(line)
    ] == []


@pytest.mark.parametrize("folder", ["home", "root", "work", "tmp", "Users"])
def test_a_folder_of_somebodys_machine_is_recognised(folder: str) -> None:
    assert MACHINE_PATH.search(f'open("/{folder}/somebody/clip.mp4")')


def test_a_folder_of_the_project_is_not_taken_for_one_of_a_machine() -> None:
    assert not MACHINE_PATH.search("../shared/work/clip.mp4 and frames/tmp/one")


def _own_files(folder: Path) -> Iterator[Path]:
    """Yield the files below a folder that are the project's own: not what git ignores."""
    ignored = [".git", *(line.strip("/ ") for line in _text(TOP / ".gitignore").split())]
    for entry in sorted(folder.iterdir()):
        if any(fnmatch(entry.name, pattern) for pattern in ignored):
            continue
        if entry.is_dir():
            yield from _own_files(entry)
        else:
            yield entry


def _text(file: Path) -> str:
    try:
        return file.read_text("utf-8")
    except UnicodeDecodeError:  # a clip or a picture
        return ""
