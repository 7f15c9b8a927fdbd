from __future__ import annotations

import errno
import os
import struct
import wave
from collections.abc import Callable, Iterator
from pathlib import Path

import av
import av.error
import cv2
import numpy as np
import pytest
from numbered_frames import numbered, write_numbered

from count_video.errors import FootageError, MachineError
from count_video.video import decoding
from count_video.video.decoding import Reading
from count_video.video.reader import open_footage


def missing(path: Path) -> None:
    assert not path.exists()


def folder(path: Path) -> None:
    path.mkdir()


def empty(path: Path) -> None:
    path.touch()


def text(path: Path) -> None:
    path.write_text("One collision, two collisions.\n" * 300, "utf-8")


def list_of_files(path: Path) -> None:
    write_numbered(path.with_name("other.mp4"), 5)
    path.write_text("ffconcat version 1.0\nfile other.mp4\n", "utf-8")


def random_bytes(path: Path) -> None:
    path.write_bytes(np.random.default_rng(1).bytes(30_000))


def sound_only(path: Path) -> None:
    with path.open("wb") as file, wave.open(file) as sound:
        sound.setnchannels(1)
        sound.setsampwidth(2)
        sound.setframerate(8000)
        sound.writeframes(bytes(16_000))


def no_whole_picture(path: Path) -> None:
    write_numbered(path, 5)
    with av.open(str(path)) as container:
        first = next(container.demux(video=0))
    path.write_bytes(path.read_bytes()[: (first.pos or 0) + first.size // 2])


def animated_webp(path: Path) -> None:
    """Write the header of an animation, whose frames FFmpeg cannot decode."""

    def chunk(name: bytes, data: bytes) -> bytes:
        return name + struct.pack("<I", len(data)) + data + bytes(len(data) % 2)

    canvas = struct.pack("<I", 63)[:3] + struct.pack("<I", 47)[:3]
    extended = chunk(b"VP8X", b"\x02\0\0\0" + canvas) + chunk(b"ANIM", bytes(6))
    encoded, still = cv2.imencode(".webp", np.zeros((48, 64), np.uint8))
    assert encoded
    frame = bytes(6) + canvas + struct.pack("<I", 33)[:3] + b"\0" + still.tobytes()[12:]
    path.write_bytes(chunk(b"RIFF", b"WEBP" + extended + 2 * chunk(b"ANMF", frame)))


UNREADABLE: dict[Callable[[Path], None], str] = {
    missing: "no such file",
    folder: "folder",
    empty: "empty",
    text: "not readable as video",
    list_of_files: "text file",
    random_bytes: "not readable as video",
    sound_only: "audio",
    no_whole_picture: "not one picture",
    animated_webp: "animated WebP",
}


@pytest.mark.parametrize(("make", "said"), UNREADABLE.items(), ids=lambda value: str(value)[:20])
def test_the_refusal_is_one_sentence_with_the_name_and_the_reason(
    tmp_path: Path, make: Callable[[Path], None], said: str
) -> None:
    path = tmp_path / "clip.mp4"
    make(path)
    with pytest.raises(FootageError, match=said) as caught:
        open_footage(path)
    message = str(caught.value)
    assert message.startswith(str(path))
    assert "\n" not in message


def test_a_text_file_is_no_film_of_text(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    text(path)
    with pytest.raises(FootageError, match="text file"):
        open_footage(path)


@pytest.mark.parametrize("name", ["trials.xlsx", "trials.TSV", "trials.txt"])
def test_a_table_that_is_no_csv_gets_advice_of_its_own(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_bytes(b"PK\x03\x04 clip name")
    with pytest.raises(FootageError, match=r"saved as CSV.*\.csv"):
        open_footage(path)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="the system has no named pipes")
def test_a_pipe_is_refused_rather_than_waited_for(tmp_path: Path) -> None:
    path = tmp_path / "clip.mp4"
    os.mkfifo(path)
    with pytest.raises(FootageError, match="no regular file"):
        open_footage(path)


def test_a_file_without_read_permission_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_numbered(tmp_path / "clip.mp4", 3)

    def refuse(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    # Not by chmod: who may do everything would read the file all the same.
    monkeypatch.setattr(Path, "open", refuse)
    with pytest.raises(FootageError, match=r"clip\.mp4.*Permission denied"):
        open_footage(path)


def test_a_still_picture_is_a_clip_of_one_frame(tmp_path: Path) -> None:
    path = tmp_path / "still.png"
    encoded, data = cv2.imencode(".png", numbered(7))
    assert encoded
    path.write_bytes(data.tobytes())
    with open_footage(path) as footage:
        (frame,) = footage.frames()
    assert np.abs(frame.luma.astype(int) - numbered(7)).max() <= 1


@pytest.mark.parametrize("name", ["a:b.mp4", "100 %d.mp4", "größe.mp4", "-.mp4", "a'b.mp4"])
def test_a_name_is_only_a_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.chdir(tmp_path)
    with open_footage(write_numbered(Path(name), 5)) as footage:
        assert len(list(footage.frames())) == 5


def test_what_follows_the_end_of_a_stream_is_not_asked_for() -> None:
    """A damaged transport stream grows streams on the way, at whose end PyAV fails."""

    class Damaged:
        def demux(self, stream: object) -> Iterator[av.Packet]:
            yield av.Packet(b"a picture")
            yield av.Packet()
            raise IndexError("list index out of range")

    reading = Reading(Damaged(), Reluctant(0))  # type: ignore[arg-type]
    assert [bytes(packet) for packet in reading.packets()] == [b"a picture"]


class Reluctant:
    """A decoder that gives pictures until it is asked once more than that."""

    time_base = None

    def __init__(self, pictures: int) -> None:
        self.pictures = pictures

    def decode(self, packet: av.Packet | None) -> list[av.VideoFrame]:
        if self.pictures == 0:
            raise av.error.BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN))
        self.pictures -= 1
        return [av.VideoFrame(16, 16, "gray")]


class Packets:
    def demux(self, stream: object) -> Iterator[av.Packet]:
        yield from (av.Packet(b"a picture") for _ in range(5))


def test_a_decoder_that_gets_no_threads_is_no_damaged_clip() -> None:
    with pytest.raises(MachineError, match="no more threads"):
        list(Reading(Packets(), Reluctant(0)).pictures)  # type: ignore[arg-type]


def test_packets_refused_for_want_of_memory_are_no_damage(monkeypatch: pytest.MonkeyPatch) -> None:
    def find_no_memory() -> None:
        raise MemoryError

    monkeypatch.setattr(decoding, "check_memory", find_no_memory)
    with pytest.raises(MemoryError):
        list(Reading(Packets(), Reluctant(3)).pictures)  # type: ignore[arg-type]


def test_a_decoder_that_stops_later_was_opened_and_met_damage() -> None:
    reading = Reading(Packets(), Reluctant(3))  # type: ignore[arg-type]
    assert len(list(reading.pictures)) == 3
    # Two packets and the decoder's last pictures.
    assert (reading.tally.pictures, reading.tally.refused) == (3, [3, 3, 3])
