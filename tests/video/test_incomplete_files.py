from __future__ import annotations

import re
import struct
from fractions import Fraction
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import av
import numpy as np
import pytest
from numbered_frames import FPS, numbers_read, write_numbered

from count_video.errors import FootageError
from count_video.video.reader import open_footage
from count_video.video.writer import WriteOptions

FRAMES = 60
GOP = 12
CUTS = (0.2, 0.5, 0.8, 0.97)
REORDERED = 4
"""So many of the last pictures may come without those before them, which were stored later."""

COUNTED = [("clip.mp4", "libx264"), ("clip.mp4", "libx265"), ("clip.mov", "mjpeg")]
COUNTED += [("clip.avi", "mjpeg"), ("clip.avi", "libx264")]
TIMED = [("clip.mkv", "libx264"), ("clip.mkv", "ffv1"), ("clip.webm", "libvpx-vp9")]


def whole(path: Path, codec: str) -> Path:
    path.write_bytes(whole_file(path.suffix, codec))
    return path


@cache
def whole_file(suffix: str, codec: str) -> bytes:
    with TemporaryDirectory() as folder:
        reordered = {"bf": "3"} if codec in ("libx264", "libx265") else {}
        options = WriteOptions(codec=codec, more={"g": str(GOP), **reordered})
        return write_numbered(Path(folder, f"clip{suffix}"), FRAMES, options).read_bytes()


def packet_places(path: Path) -> list[tuple[int, int]]:
    """Position and size of every packet in the file."""
    with av.open(str(path)) as container:
        packets = container.demux(container.streams.video[0])
        return [(packet.pos or 0, packet.size) for packet in packets if packet.size]


def cut_after(path: Path, share: float) -> int:
    """Cut a file in the middle of a packet; return how many packets are whole."""
    places = packet_places(path)
    kept = int(share * len(places))
    position, size = places[kept]
    path.write_bytes(path.read_bytes()[: position + size // 2])
    return kept


def blank(path: Path, packet: int) -> None:
    """Put zeros in place of what is in a packet."""
    position, size = packet_places(path)[packet]
    data = bytearray(path.read_bytes())
    data[position : position + size] = bytes(size)
    path.write_bytes(data)


def numbers_in(text: str) -> set[float]:
    return {float(number) for number in re.findall(r"\d+(?:\.\d+)?", text)}


@pytest.mark.parametrize("share", CUTS)
@pytest.mark.parametrize(("name", "codec"), COUNTED)
def test_a_cut_file_gives_its_frames_and_a_warning_with_both_counts(
    tmp_path: Path, name: str, codec: str, share: float
) -> None:
    path = whole(tmp_path / name, codec)
    kept = cut_after(path, share)
    numbers, report = numbers_read(path)
    assert len(numbers) == kept
    assert numbers == sorted(numbers)
    assert numbers[: kept - REORDERED] == list(range(kept - REORDERED))
    assert (report.frames_promised, report.frames_decoded) == (FRAMES, len(numbers))
    assert any({FRAMES, len(numbers)} <= numbers_in(text) for text in report.warnings)


@pytest.mark.parametrize("share", CUTS)
@pytest.mark.parametrize(("name", "codec"), TIMED)
def test_a_cut_file_without_a_count_is_found_short_by_its_duration(
    tmp_path: Path, name: str, codec: str, share: float
) -> None:
    path = whole(tmp_path / name, codec)
    kept = cut_after(path, share)
    numbers, report = numbers_read(path)
    assert len(numbers) == kept
    assert numbers[: kept - REORDERED] == list(range(kept - REORDERED))
    whole_s, left_s = (round(count / FPS, 2) for count in (FRAMES, numbers[-1] + 1))
    (warning,) = (text for text in report.warnings if "s of film" in text)
    assert {float(whole_s), float(left_s), len(numbers)} <= numbers_in(warning)


def test_a_cut_file_whose_index_came_last_is_refused_in_one_sentence(tmp_path: Path) -> None:
    path = write_numbered(tmp_path / "clip.mp4", FRAMES, WriteOptions(index_first=False))
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(FootageError, match=r"clip\.mp4.*cut off before its index") as caught:
        open_footage(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("codec", ["libx264", "libx265"])
def test_a_blank_packet_costs_no_more_than_its_group_of_pictures(
    tmp_path: Path, codec: str
) -> None:
    path = whole(tmp_path / "clip.mp4", codec)
    blank(path, 2 * GOP + 3)
    numbers, report = numbers_read(path)
    assert numbers[: 2 * GOP] == list(range(2 * GOP))
    assert numbers[-2 * GOP :] == list(range(FRAMES - 2 * GOP, FRAMES))
    assert report.warnings


def test_an_empty_packet_within_a_file_does_not_end_it(tmp_path: Path) -> None:
    path = whole(tmp_path / "clip.mov", "mjpeg")
    data = bytearray(path.read_bytes())
    sizes = data.index(b"stsz") + 16  # after version, common size and number
    before, empty = struct.unpack_from(">II", data, sizes + 4 * 20)
    struct.pack_into(">II", data, sizes + 4 * 20, before + empty, 0)
    path.write_bytes(data)
    numbers, report = numbers_read(path)
    assert numbers == [number for number in range(FRAMES) if number != 21]
    assert report.frames_missing == 1


def test_a_picture_that_cannot_be_decoded_is_counted_as_an_error(tmp_path: Path) -> None:
    path = whole(tmp_path / "clip.avi", "mjpeg")
    blank(path, 20)
    numbers, report = numbers_read(path)
    assert numbers == [number for number in range(FRAMES) if number != 20]
    assert (report.frames_missing, report.frames_decoded) == (1, FRAMES - 1)
    refused, short, jump = report.warnings
    assert {1, 20} <= numbers_in(refused)
    assert {FRAMES, FRAMES - 1} <= numbers_in(short)
    assert {1, 19, 2.0} <= numbers_in(jump)


def test_packets_lost_in_the_middle_show_as_a_jump_of_the_time_stamps(tmp_path: Path) -> None:
    path = whole(tmp_path / "clip.mkv", "ffv1")
    data = bytearray(path.read_bytes())
    places = packet_places(path)
    first, last = places[20][0], sum(places[40])
    data[first - 16 : last] = bytes(last - first + 16)
    path.write_bytes(data)
    numbers, report = numbers_read(path)
    missing = sorted(set(range(FRAMES)) - set(numbers))
    assert set(range(21, 40)) <= set(missing)
    (jump,) = (text for text in report.warnings if "jump" in text)
    assert missing[0] - 1 in numbers_in(jump)


def test_the_uneven_steps_of_a_phone_are_no_jumps(tmp_path: Path) -> None:
    steps_ms = np.random.default_rng(4).choice([33, 50, 66, 108], FRAMES)
    times = [Fraction(int(time_ms), 1000) for time_ms in np.cumsum(steps_ms)]
    path = write_numbered(tmp_path / "clip.mp4", FRAMES, WriteOptions(frame_times_s=times))
    numbers, report = numbers_read(path)
    assert numbers == list(range(FRAMES))
    assert report.warnings == ()


@pytest.mark.parametrize(("name", "codec"), COUNTED + TIMED)
def test_a_whole_file_raises_no_alarm(tmp_path: Path, name: str, codec: str) -> None:
    numbers, report = numbers_read(whole(tmp_path / name, codec))
    assert numbers == list(range(FRAMES))
    assert report.frames_promised == FRAMES
    assert report.warnings == ()


@pytest.mark.parametrize(("first", "frames"), [(10, FRAMES - 10), (0, 30), (17, 20)])
def test_frames_that_an_edit_list_hides_are_neither_promised_nor_missed(
    tmp_path: Path, first: int, frames: int
) -> None:
    path = whole(tmp_path / "clip.mp4", "libx264")
    data = bytearray(path.read_bytes())
    # Box elst: version and flags, number of entries, then duration in ms of the film's clock (1000
    # ticks a second, as FFmpeg writes it) and first time stamp on the stream's clock.
    entry = data.index(b"elst") + 12
    _, start = struct.unpack(">Ii", data[entry : entry + 8])
    with av.open(str(path)) as container:
        tick_s = container.streams.video[0].time_base
    assert tick_s is not None
    shown_ms = round(1000 * frames / FPS)
    struct.pack_into(">Ii", data, entry, shown_ms, start + round(first / FPS / tick_s))
    path.write_bytes(data)
    numbers, report = numbers_read(path)
    assert numbers[0] == first
    assert abs(len(numbers) - frames) <= 1  # the duration is rounded to milliseconds
    assert report.frames_promised == len(numbers)
    assert report.warnings == ()


def test_reading_a_part_makes_no_complaint_about_the_rest(tmp_path: Path) -> None:
    with open_footage(whole(tmp_path / "clip.mp4", "libx264")) as footage:
        assert len(list(footage.frames(10, 20))) == 10
        report = footage.report()
    assert report.frames_decoded == 20
    assert report.warnings == ()
