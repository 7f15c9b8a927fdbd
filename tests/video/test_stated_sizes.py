"""What a file states of its size is checked before memory is taken for it."""

from __future__ import annotations

import io
import struct
import zlib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from numbered_frames import write_numbered

from count_video.errors import FootageError
from count_video.video.opening import (
    LONGEST_SIDE_PX,
    MOST_FRAMES,
    MOST_PIXELS,
    check_size,
    frames_in_index,
)
from count_video.video.reader import open_footage

FRAMES = 5


def png(width: int, height: int) -> bytes:
    """Make a picture that states a size and holds one row of it."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    row = zlib.compress(bytes(width + 1))
    parts = [chunk(b"IHDR", head), chunk(b"IDAT", row), chunk(b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


def box(name: bytes, *parts: bytes) -> bytes:
    content = b"".join(parts)
    return struct.pack(">I4s", 8 + len(content), name) + content


def track(kind: bytes, samples: int, ticks: int) -> bytes:
    """Make the boxes of a track whose samples all have one size and one duration."""
    handler = box(b"hdlr", bytes(8), kind, bytes(12))
    times = box(b"stts", bytes(4), struct.pack(">III", 1, samples, ticks))
    sizes = box(b"stsz", bytes(4), struct.pack(">II", 1, samples))
    table = box(b"stbl", times, sizes)
    return box(b"trak", box(b"mdia", handler, box(b"minf", table)))


def test_an_index_of_millions_of_frames_is_refused_before_it_is_built(tmp_path: Path) -> None:
    path = write_numbered(tmp_path / "clip.mp4", FRAMES)
    content = bytearray(path.read_bytes())
    sizes = content.index(b"stsz") + 4
    struct.pack_into(">II", content, sizes + 4, 1, 40 * MOST_FRAMES)
    path.write_bytes(content)
    with pytest.raises(FootageError, match=f"states {40 * MOST_FRAMES} frames, more than"):
        open_footage(path)


@pytest.mark.parametrize("suffix", ["mp4", "mov"])
def test_the_index_of_a_sound_clip_states_its_frames(tmp_path: Path, suffix: str) -> None:
    with write_numbered(tmp_path / f"clip.{suffix}", FRAMES).open("rb") as file:
        assert frames_in_index(file) == FRAMES


def test_a_file_without_such_an_index_states_nothing(tmp_path: Path) -> None:
    with write_numbered(tmp_path / "clip.mkv", FRAMES).open("rb") as file:
        assert frames_in_index(file) == 0


@pytest.mark.parametrize(
    ("kind", "ticks", "counted"),
    [(b"vide", 1, 7), (b"vide", 512, 7), (b"soun", 512, 7), (b"soun", 1, 0)],
    ids=["video, one tick each", "video", "compressed sound", "plain sound waves"],
)
def test_plain_sound_waves_are_no_frames(kind: bytes, ticks: int, counted: int) -> None:
    other = track(b"vide", 3, 512)
    film = box(b"moov", other, track(kind, 7, ticks), other)
    assert frames_in_index(io.BytesIO(film)) == 6 + counted


@given(st.binary(max_size=300), st.integers(0, 400))
def test_whatever_bytes_an_index_is_made_of_reading_it_ends(noise: bytes, place: int) -> None:
    content = box(b"moov", track(b"vide", 3, 512), track(b"soun", 3, 1))
    damaged = content[:place] + noise + content[place + len(noise) :]
    assert frames_in_index(io.BytesIO(damaged)) >= 0


@pytest.mark.parametrize("side", [16_000, 60_000])
def test_a_picture_that_is_too_large_is_refused(tmp_path: Path, side: int) -> None:
    path = tmp_path / "picture.mp4"
    path.write_bytes(png(side, side))
    with pytest.raises(FootageError, match="too large"):
        open_footage(path)


@pytest.mark.parametrize(
    ("width", "height", "words"),
    [
        (LONGEST_SIDE_PX + 1, 16, "too large"),
        (5000, 1 + MOST_PIXELS // 5000, "too large"),
        (15, 480, "show nothing"),
        (640, 1, "show nothing"),
    ],
)
def test_sizes_that_make_no_sense_are_refused_with_their_figures(
    width: int, height: int, words: str
) -> None:
    with pytest.raises(FootageError, match=f"{width} x {height} px .*{words}") as caught:
        check_size(Path("clip.mp4"), width, height)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(("width", "height"), [(4096, 4320), (16, 16), (0, 0)])
def test_sizes_of_cameras_and_sizes_not_stated_pass(width: int, height: int) -> None:
    check_size(Path("clip.mp4"), width, height)


def test_a_name_in_the_form_of_a_pattern_is_the_name_of_one_file(tmp_path: Path) -> None:
    for name in ("clip%03d.png", "clip000.png", "clip001.png"):
        (tmp_path / name).write_bytes(png(64, 1 if name == "clip%03d.png" else 64))
    with pytest.raises(FootageError, match="64 x 1 px"):
        open_footage(tmp_path / "clip%03d.png")
