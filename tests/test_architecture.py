from __future__ import annotations

import re
from collections.abc import Iterator
from fnmatch import fnmatch
from pathlib import Path

import pytest

from import_walls import ALCOVES, MAY_IMPORT, read_modules, violations

TOP = Path(__file__).parents[1]
# Folders that only exist on somebody's machine; written so that this line is none of them.
MACHINE_PATH = re.compile(r"(?<![\w.*)])/(?:home|root|work|tmp|Users)/\w|\b[A-Z]:\\Users")


def test_every_import_respects_the_walls() -> None:
    modules = read_modules(TOP / "src", TOP / "synth")
    assert len(modules) > len(MAY_IMPORT)
    assert violations(modules) == []


def test_the_walls_name_every_room_of_the_house() -> None:
    modules = read_modules(TOP / "src", TOP / "synth")
    assert {module.room for module in modules.values()} - {""} == MAY_IMPORT.keys()


def test_the_walls_name_every_alcove_of_a_room() -> None:
    modules = read_modules(TOP / "src", TOP / "synth")
    for room, alcoves in ALCOVES.items():
        packages = (TOP / "src/count_video" / room).glob("*/__init__.py")
        assert {package.parent.name for package in packages} == alcoves.keys()
    assert any(module.room in ALCOVES for module in modules.values())


PLANTED = {
    "a lower room imports a higher one": (
        "count_video/physics/planted.py",
        "from count_video import trial",
    ),
    "a relative import climbs out of its room": (
        "count_video/physics/planted.py",
        "from ..campaign import count_clips",
    ),
    "one stage imports another": (
        "count_video/tracking/planted.py",
        "import count_video.motion",
    ),
    "an import hides in a function": (
        "count_video/records.py",
        "def late():\n    from count_video import cli",
    ),
    "an import hides behind a call": (
        "count_video/errors.py",
        "import importlib\nimportlib.import_module('count_video.cli')",
    ),
    "a second door to the decoder": ("count_video/tracking/planted.py", "import av.video.frame"),
    "the decoder in the renderer": ("synth_video/planted.py", "from av import open"),
    "the tracker asks the simulator": (
        "count_video/tracking/planted.py",
        "from count_video.physics import simulator",
    ),
    "the collisions ask the simulator through another": (
        "count_video/motion/planted.py",
        "from count_video.physics.between import anything",
    ),
    "the renderer uses the tracker": (
        "synth_video/planted.py",
        "from count_video.tracking import anything",
    ),
    "an alcove imports another": (
        "count_video/tracking/looks/planted.py",
        "from count_video.tracking.pairs import anything",
    ),
    "the library imports the renderer": (
        "count_video/footage/planted.py",
        "import synth_video.scene",
    ),
    "a room imports itself in a circle": (
        "count_video/footage/planted.py",
        "from count_video.footage import circle",
    ),
    "the library prints": ("count_video/footage/planted.py", "print(1)"),
    "the library logs": ("count_video/footage/planted.py", "import logging"),
    "the library writes to a stream": (
        "count_video/trial.py",
        "import sys\nsys.stderr.write('done')",
    ),
}


@pytest.fixture
def small_house(tmp_path: Path) -> Path:
    """A sound tree with the modules that the planted faults lean on."""
    for name in ("cli", "campaign", "trial", "records", "errors"):
        _write(tmp_path, f"count_video/{name}.py", "")
    for room in ("physics", "footage", "tracking", "motion"):
        _write(tmp_path, f"count_video/{room}/__init__.py", "")
    for alcove in ("looks", "pairs"):
        _write(tmp_path, f"count_video/tracking/{alcove}/__init__.py", "")
    _write(tmp_path, "count_video/__init__.py", "__version__ = '1'")
    _write(tmp_path, "count_video/cli.py", "from count_video import __version__\nprint(1)")
    _write(
        tmp_path, "count_video/physics/simulator.py", "from count_video.errors import UsageError"
    )
    _write(tmp_path, "count_video/physics/between.py", "from .simulator import anything")
    _write(tmp_path, "count_video/footage/circle.py", "from . import planted")
    _write(tmp_path, "synth_video/scene.py", "import count_video.footage")
    return tmp_path


def _write(top: Path, name: str, text: str) -> None:
    file = top / name
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, "utf-8")


def test_a_sound_house_has_no_breach(small_house: Path) -> None:
    assert violations(read_modules(small_house)) == []


@pytest.mark.parametrize(("name", "text"), PLANTED.values(), ids=PLANTED.keys())
def test_a_planted_breach_is_found(small_house: Path, name: str, text: str) -> None:
    _write(small_house, name, text)
    planted = name.removesuffix(".py").replace("/", ".")
    found = violations(read_modules(small_house))
    assert len(found) >= 1
    assert all(planted in breach for breach in found)


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
    """Yield the files below a folder that are the project's own: not what git is told to ignore."""
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
