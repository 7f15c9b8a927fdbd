"""Damaged files of every kind are read as far as they go, or refused in one line."""

from __future__ import annotations

from pathlib import Path

import pytest
from mutations import mutated
from readers import CONTAINERS, READERS, Reader, refusal

CORPUS = Path(__file__).with_name("corpus")
QUICK, WHOLE = range(30), range(30, 1000)
DEEPER_THAN_ANY_PARSER_GOES = 200_000


def check(reader: Reader, case: Path) -> None:
    refused = refusal(reader, case)  # raises what is no refusal
    assert "\n" not in refused


@pytest.mark.parametrize("name", READERS)
def test_a_sound_file_is_not_refused(name: str, tmp_path: Path) -> None:
    case = tmp_path / READERS[name].file
    READERS[name].sound(case)
    assert refusal(READERS[name], case) == ""


@pytest.mark.parametrize("seeds", [QUICK, pytest.param(WHOLE, marks=pytest.mark.slow)], ids=len)
@pytest.mark.parametrize("name", READERS)
def test_a_damaged_file_is_read_or_refused(name: str, seeds: range, tmp_path: Path) -> None:
    case = tmp_path / READERS[name].file
    READERS[name].sound(case)
    sound = case.read_bytes()
    for seed in seeds:
        case.write_bytes(mutated(sound, seed))
        check(READERS[name], case)


@pytest.mark.parametrize("opening", [b"[", b'{"name":'])
@pytest.mark.parametrize("name", [name for name in READERS if name not in CONTAINERS])
def test_what_is_nested_without_end_is_read_or_refused(
    name: str, opening: bytes, tmp_path: Path
) -> None:
    case = tmp_path / READERS[name].file
    READERS[name].sound(case)
    case.write_bytes(opening * DEEPER_THAN_ANY_PARSER_GOES + b"\n")
    check(READERS[name], case)


@pytest.mark.parametrize("kept", sorted(CORPUS.glob("*-*")), ids=lambda kept: kept.name)
def test_what_once_failed_is_read_or_refused(kept: Path, tmp_path: Path) -> None:
    reader = READERS[kept.name.partition("-")[0]]
    case = tmp_path / reader.file
    case.parent.mkdir(exist_ok=True)
    case.write_bytes(kept.read_bytes())
    check(reader, case)
