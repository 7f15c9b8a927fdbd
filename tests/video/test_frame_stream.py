from __future__ import annotations

import os
import weakref
from collections import deque
from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest
from numbered_frames import HEIGHT, WIDTH, number_in, numbered, numbers_of, write_numbered

from count_video.errors import FootageError
from count_video.video.decoding import Tally
from count_video.video.reader import Footage, open_footage
from count_video.video.writer import WriteOptions

FRAMES = 80
LUMAS_ALIVE = 8
"""The frame in hand, those that are compared with it, and the one ahead."""


@pytest.fixture
def clip(tmp_path: Path) -> Path:
    return write_numbered(tmp_path / "clip.mp4", FRAMES, WriteOptions(more={"g": "30"}))


@pytest.mark.parametrize(
    ("start", "end", "first", "last"),
    [
        (0, None, 0, FRAMES),
        (17, 43, 17, 43),
        (0, 1, 0, 1),
        (70, 500, 70, FRAMES),
        (79, None, 79, 80),
    ],
)
def test_a_part_of_a_clip_keeps_the_indices_of_the_whole(
    clip: Path, start: int, end: int | None, first: int, last: int
) -> None:
    with open_footage(clip) as footage:
        frames = list(footage.frames(start, end))
    assert [frame.index for frame in frames] == list(range(first, last))
    assert numbers_of(frames) == list(range(first, last))


@pytest.mark.parametrize(("start", "end"), [(FRAMES, None), (5, 5), (9, 4), (500, 600), (0, 0)])
def test_a_part_without_frames_is_empty(clip: Path, start: int, end: int | None) -> None:
    with open_footage(clip) as footage:
        assert list(footage.frames(start, end)) == []


def test_every_picture_is_decoded_once(clip: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    decoded, add = [], Tally.add

    def counted(tally: Tally, picture: av.VideoFrame) -> None:
        decoded.append(picture.pts)
        add(tally, picture)

    monkeypatch.setattr(Tally, "add", counted)
    with open_footage(clip) as footage:
        assert numbers_of(list(footage.frames())) == list(range(FRAMES))
    assert len(decoded) == len(set(decoded)) == FRAMES


def test_a_clip_can_be_streamed_again_and_starts_anew(clip: Path) -> None:
    with open_footage(clip) as footage:
        once = numbers_of(list(footage.frames()))
        again = numbers_of(list(footage.frames()))
        assert footage.report().frames_decoded == FRAMES
    assert once == again == list(range(FRAMES))


def test_a_new_stream_ends_the_one_before(clip: Path) -> None:
    with open_footage(clip) as footage:
        first = footage.frames()
        assert number_in(next(first).luma) == 0
        second = footage.frames()
        assert number_in(next(second).luma) == 0
        assert list(first) == []
        assert number_in(next(second).luma) == 1


def test_the_report_counts_what_was_decoded_so_far(clip: Path) -> None:
    with open_footage(clip) as footage:
        list(footage.frames(end=25))
        assert footage.report().frames_decoded == 25
        list(footage.frames())
        assert footage.report().frames_decoded == FRAMES


def is_open(path: Path) -> bool:
    descriptors = Path("/proc/self/fd")
    if not descriptors.is_dir():
        pytest.skip("the system does not list open files")
    links = (descriptors / name for name in os.listdir(descriptors))
    return any(link.exists() and link.resolve() == path.resolve() for link in links)


def test_the_file_is_open_until_the_footage_is_closed(clip: Path) -> None:
    with open_footage(clip) as footage:
        next(footage.frames())
        assert is_open(clip)
    assert not is_open(clip)


def test_a_stream_that_is_never_begun_leaves_no_file_open(clip: Path) -> None:
    with open_footage(clip) as footage:
        stream = footage.frames()
    assert not is_open(clip)
    del stream


def test_the_file_is_closed_where_the_reader_fails_half_way(clip: Path) -> None:
    def read(footage: Footage) -> None:
        for frame in footage.frames():
            if frame.index == 5:
                raise RuntimeError

    with pytest.raises(RuntimeError), open_footage(clip) as footage:
        read(footage)
    assert not is_open(clip)


def test_a_stream_that_is_dropped_half_way_ends_in_peace(clip: Path) -> None:
    with open_footage(clip) as footage:
        stream = footage.frames()
        next(stream)
    assert list(stream) == []


@pytest.mark.parametrize("pixel_format", ["yuv420p", "yuv420p10le"])
def test_frames_do_not_pile_up_in_memory(tmp_path: Path, pixel_format: str) -> None:
    path = write_numbered(tmp_path / "clip.mp4", FRAMES, WriteOptions(pixel_format=pixel_format))
    alive: deque[weakref.ref[np.ndarray]] = deque()
    most = 0
    with open_footage(path) as footage:
        for frame in footage.frames():
            alive.append(weakref.ref(frame.luma))
            most = max(most, sum(luma() is not None for luma in alive))
    assert len(alive) == FRAMES
    assert most <= LUMAS_ALIVE


def test_a_frame_that_is_kept_stays_as_it_was(clip: Path) -> None:
    with open_footage(clip) as footage:
        kept = list(footage.frames())
    assert numbers_of(kept) == list(range(FRAMES))


def test_a_change_of_the_picture_size_is_refused_with_frame_and_sizes(tmp_path: Path) -> None:
    path = tmp_path / "clip.avi"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mjpeg", rate=30)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuvj420p"
        other = av.CodecContext.create("mjpeg", "w")
        other.width, other.height, other.pix_fmt = WIDTH // 2, HEIGHT, "yuvj420p"
        other.time_base = Fraction(1, 30)
        for k in range(6):
            picture = numbered(k) if k < 4 else np.ascontiguousarray(numbered(k)[:, ::2])
            frame = av.VideoFrame.from_ndarray(picture, format="gray").reformat(format="yuvj420p")
            frame.pts, frame.time_base = k, Fraction(1, 30)
            for packet in (stream if k < 4 else other).encode(frame):
                packet.stream = stream
                container.mux(packet)
    with open_footage(path) as footage:
        stream_of_frames = footage.frames()
        with pytest.raises(FootageError, match=r"frame 4 from 160 x 96 to 80 x 96"):
            list(stream_of_frames)


def write_tracks(path: Path, tracks: list[tuple[int, int, int]]) -> None:
    """Write several video streams: width, height and number of frames of each."""
    with av.open(str(path), "w") as container:
        streams = []
        for width, height, _ in tracks:
            stream = container.add_stream("libx264", rate=30)
            stream.width, stream.height, stream.pix_fmt = width, height, "yuv420p"
            streams.append(stream)
        for stream, (width, height, frames) in zip(streams, tracks, strict=True):
            for k in range(frames):
                picture = np.full((height, width), 20 + k, np.uint8)
                frame = av.VideoFrame.from_ndarray(picture, format="gray")
                frame.pts = k
                container.mux(stream.encode(frame.reformat(format="yuv420p")))
            container.mux(stream.encode(None))


@pytest.mark.parametrize("film", [0, 1])
def test_the_film_is_preferred_to_a_large_still_beside_it(tmp_path: Path, film: int) -> None:
    path = tmp_path / "clip.mp4"
    tracks = [(640, 480, 1)]
    tracks.insert(film, (160, 96, 20))
    write_tracks(path, tracks)
    with open_footage(path) as footage:
        assert (footage.info.width_px, footage.info.frames_promised) == (160, 20)
        assert len(list(footage.frames())) == 20


def test_of_two_films_the_default_one_is_taken_else_the_larger(tmp_path: Path) -> None:
    path = tmp_path / "clip.mkv"
    write_tracks(path, [(160, 96, 20), (320, 96, 20)])
    with open_footage(path) as footage:
        assert footage.info.width_px in (160, 320)
        chosen = footage.info.width_px
    with av.open(str(path)) as container:
        defaults = [
            bool(stream.disposition & av.stream.Disposition.default) for stream in container.streams
        ]
    assert chosen == (160 if defaults == [True, False] else 320)


@pytest.mark.parametrize("uneven", [False, True])
def test_time_stamps_are_given_in_usual_steps_where_they_are_uneven(
    tmp_path: Path, uneven: bool
) -> None:
    path = tmp_path / "clip.mp4"
    ticks = np.delete(np.arange(24), [5, 6, 17]) if uneven else np.arange(24)
    with av.open(str(path), "w") as container:
        stream = container.add_stream("libx264", rate=30)
        stream.width, stream.height, stream.pix_fmt = WIDTH, HEIGHT, "yuv420p"
        for k, tick in enumerate(ticks.tolist()):
            frame = av.VideoFrame.from_ndarray(numbered(k), format="gray")
            frame.pts, frame.time_base = tick, Fraction(1, 30)
            container.mux(stream.encode(frame.reformat(format="yuv420p")))
        container.mux(stream.encode(None))
    rows = np.arange(3, len(ticks))
    with open_footage(path) as footage:
        list(footage.frames())
        stamped = footage.stamped(rows)
    assert (stamped is not None) == uneven
    if stamped is not None:
        assert stamped == pytest.approx(3.0 + ticks[rows] - ticks[3])
