from __future__ import annotations

import errno
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from numbered_frames import Luma, number_in, numbered, numbers_read, write_numbered

from count_video.errors import UsageError
from count_video.video.reader import open_footage
from count_video.video.writer import WriteOptions, write_clip

FRAMES = 12


@pytest.mark.parametrize(
    ("name", "codec"),
    [
        ("a.mp4", "libx264"),
        ("a.mov", "libx265"),
        ("a.avi", "mjpeg"),
        ("a.mkv", "ffv1"),
        ("a.webm", "libvpx-vp9"),
    ],
)
def test_the_same_pictures_give_the_same_bytes(tmp_path: Path, name: str, codec: str) -> None:
    options = WriteOptions(codec=codec, metadata={"title": "trial"})
    once = write_numbered(tmp_path / name, FRAMES, options).read_bytes()
    again = write_numbered(tmp_path / name, FRAMES, options).read_bytes()
    assert once == again


def test_every_picture_of_a_generator_is_written(tmp_path: Path) -> None:
    write_clip(tmp_path / "clip.mp4", map(numbered, range(FRAMES)))
    assert numbers_read(tmp_path / "clip.mp4")[0] == list(range(FRAMES))


def test_a_full_disk_is_called_so(tmp_path: Path) -> None:
    def until_it_is_full() -> Iterator[Luma]:
        yield numbered(0)
        raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(UsageError, match="No space left on device; free space on that disk"):
        write_clip(tmp_path / "clip.mp4", until_it_is_full())


def test_colour_pictures_keep_their_brightness(tmp_path: Path) -> None:
    path = tmp_path / "clip.mkv"
    colours = [np.repeat(numbered(k)[:, :, None], 3, axis=2) for k in range(FRAMES)]
    write_clip(path, colours, WriteOptions(codec="ffv1", pixel_format="bgr0"))
    with open_footage(path) as footage:
        frames = list(footage.frames())
    assert [number_in(frame.luma) for frame in frames] == list(range(FRAMES))
    assert np.abs(frames[3].luma.astype(int) - numbered(3)).max() <= 1


def test_lossless_luma_is_stored_to_the_bit(tmp_path: Path) -> None:
    for pixel_format in ("gray", "yuv420p", "yuv420p10le"):
        path = tmp_path / f"{pixel_format}.mkv"
        write_clip(path, [numbered(5)], WriteOptions(codec="ffv1", pixel_format=pixel_format))
        with open_footage(path) as footage:
            (frame,) = footage.frames()
        np.testing.assert_array_equal(frame.luma, numbered(5))


def test_key_frames_come_as_often_as_asked(tmp_path: Path) -> None:
    sizes = [
        write_numbered(tmp_path / f"{gop}.mp4", 60, WriteOptions(more={"g": gop})).stat().st_size
        for gop in ("1", "60")
    ]
    assert sizes[0] > 2 * sizes[1]


def fails_half_way() -> Iterator[Luma]:
    yield numbered(0)
    raise ZeroDivisionError


@pytest.mark.parametrize("name", ["clip.mp4", "clip.mkv", "clip.avi"])
def test_nothing_is_left_behind_when_the_pictures_fail(tmp_path: Path, name: str) -> None:
    with pytest.raises(ZeroDivisionError):
        write_clip(tmp_path / name, fails_half_way())
    assert list(tmp_path.iterdir()) == []


def test_an_old_clip_survives_a_failed_rewrite(tmp_path: Path) -> None:
    path = write_numbered(tmp_path / "clip.mp4", FRAMES)
    with pytest.raises(ZeroDivisionError):
        write_clip(path, fails_half_way())
    numbers, _ = numbers_read(path)
    assert numbers == list(range(FRAMES))
    assert list(tmp_path.iterdir()) == [path]


def test_no_file_bears_the_name_before_it_is_complete(tmp_path: Path) -> None:
    path = tmp_path / "clip.mp4"

    def pictures() -> Iterator[Luma]:
        for k in range(FRAMES):
            assert not path.exists()
            yield numbered(k)

    write_clip(path, pictures())
    assert list(tmp_path.iterdir()) == [path]


ODD = numbered(0)[:95]
REFUSED = {
    "no frame": ("clip.mp4", [], WriteOptions(), "no frame"),
    "no folder": ("none/clip.mp4", [numbered(0)], WriteOptions(), "No such file"),
    "no container": ("clip.xyz", [numbered(0)], WriteOptions(), "output format"),
    "no such codec": ("clip.mp4", [numbered(0)], WriteOptions(codec="none"), "none"),
    "a codec for sound": ("clip.mp4", [numbered(0)], WriteOptions(codec="aac"), "aac"),
    "no such layout": ("clip.mp4", [numbered(0)], WriteOptions(pixel_format="foo"), "foo"),
    "a foreign codec": ("clip.webm", [numbered(0)], WriteOptions(), "does not support"),
    "odd sides": ("clip.mp4", [ODD], WriteOptions(), "even"),
    "too few times": (
        "clip.mp4",
        [numbered(0)] * 3,
        WriteOptions(frame_times_s=[0, Fraction(1, 30)]),
        "after 2 frames",
    ),
    "time that stands still": (
        "clip.mp4",
        [numbered(0)] * 3,
        WriteOptions(frame_times_s=[0, 1, 1]),
        "does not come after",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_written_is_refused_in_one_sentence(tmp_path: Path, case: str) -> None:
    name, frames, options, said = REFUSED[case]
    with pytest.raises(UsageError, match=said) as caught:
        write_clip(tmp_path / name, frames, options)
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []
