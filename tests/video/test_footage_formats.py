from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path

import av
import numpy as np
import pytest
from av.stream import Disposition
from numbered_frames import FPS, HEIGHT, WIDTH, number_in, numbered, write_numbered

from coded import coding_of
from count_video.video.reader import open_footage
from count_video.video.writer import WriteOptions, write_clip

FRAMES = 40

FORMATS = [
    ("clip.mp4", "libx264", "yuv420p"),
    ("clip.mov", "libx264", "yuv420p10le"),
    ("clip.mkv", "libx264", "yuv444p"),
    ("clip.avi", "libx264", "yuv420p"),
    ("clip.mp4", "libx265", "yuv420p"),
    ("clip.mov", "libx265", "yuv420p10le"),
    ("clip.mkv", "libx265", "yuv422p10le"),
    ("clip.avi", "mjpeg", "yuv420p"),
    ("clip.mov", "mjpeg", "yuv422p"),
    ("clip.webm", "libvpx-vp9", "yuv420p"),
    ("clip.webm", "libvpx", "yuv420p"),
    ("clip.mkv", "ffv1", "gray"),
    ("clip.mkv", "ffv1", "yuv420p10le"),
    ("clip.mkv", "ffv1", "bgr0"),
    ("clip.avi", "rawvideo", "yuyv422"),
]

CODING_ERROR_LEVELS = 2.0
"""Mean error over a frame at the writer's default quality, in grey levels; limited range that is
scaled to full would be off by 16."""


@pytest.mark.parametrize(
    ("name", "codec", "pixel_format", "reordered"),
    [
        *((*one, {"bf": "0"} if one[1] in ("libx264", "libx265") else {}) for one in FORMATS),
        *((*one, {"bf": "2"}) for one in FORMATS if one[1] in ("libx264", "libx265")),
    ],
)
def test_every_frame_arrives_in_order_whatever_container_and_codec(
    tmp_path: Path, name: str, codec: str, pixel_format: str, reordered: dict[str, str]
) -> None:
    more = {"g": "12", **reordered}
    options = WriteOptions(codec=codec, pixel_format=pixel_format, more=more)
    path = write_numbered(tmp_path / name, FRAMES, options)
    with open_footage(path) as footage:
        frames = list(footage.frames())
        report = footage.report()
    assert [number_in(frame.luma) for frame in frames] == list(range(FRAMES))
    assert [frame.index for frame in frames] == list(range(FRAMES))
    assert report.frames_decoded == report.frames_promised == FRAMES
    assert report.warnings == ()
    assert report.frames_missing == 0
    assert not any(frame.repeats_previous for frame in frames)


@pytest.mark.parametrize(("name", "codec", "pixel_format"), FORMATS)
def test_luma_is_what_was_written(tmp_path: Path, name: str, codec: str, pixel_format: str) -> None:
    options = WriteOptions(codec=codec, pixel_format=pixel_format, crf=12)
    path = write_numbered(tmp_path / name, 3, options)
    with open_footage(path) as footage:
        frames = list(footage.frames())
    for number, frame in enumerate(frames):
        assert frame.luma.dtype == np.uint8
        error = frame.luma.astype(float) - numbered(number)
        assert np.abs(error).mean() < CODING_ERROR_LEVELS


def test_a_still_beside_the_film_is_not_the_film(tmp_path: Path) -> None:
    """It comes first and is larger, and the header says of neither how many pictures it has."""
    film = write_numbered(tmp_path / "film.mkv", FRAMES)
    still, both = tmp_path / "still.mkv", tmp_path / "both.mkv"
    write_clip(still, [np.tile(numbered(0), (2, 2))], WriteOptions(codec="mjpeg"))
    with av.open(both, "w") as target, ExitStack() as stack:
        sources = [stack.enter_context(av.open(path)) for path in (still, film)]
        streams = [target.add_stream_from_template(one.streams.video[0]) for one in sources]
        for source, stream in zip(sources, streams, strict=True):
            stream.disposition = Disposition(0)
            for packet in source.demux(video=0):
                if packet.size:
                    packet.stream = stream
                    target.mux(packet)
    with open_footage(both) as footage:
        assert [number_in(frame.luma) for frame in footage.frames()] == list(range(FRAMES))


def test_the_info_says_what_the_file_says(tmp_path: Path) -> None:
    options = WriteOptions(codec="libx265", pixel_format="yuv420p10le", container_fps=FPS)
    path = write_numbered(tmp_path / "clip.mp4", FRAMES, options)
    with open_footage(path) as footage:
        info = footage.info
    assert coding_of(path) == ("hevc", "yuv420p10le")
    assert (info.width_px, info.height_px, info.rotation_deg) == (WIDTH, HEIGHT, 0)
    assert (info.frames_promised, info.container_fps) == (FRAMES, float(FPS))
    assert (info.capture_fps, info.capture_fps_source) == (None, "unknown")
    assert info.path == path


@pytest.mark.parametrize("codec", ["libx264", "libx265"])
def test_nothing_is_written_to_the_standard_streams(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], codec: str
) -> None:
    path = write_numbered(
        tmp_path / "clip.mp4", FRAMES, WriteOptions(codec=codec, more={"g": "10"})
    )
    data = path.read_bytes()
    path.write_bytes(data[: -len(data) // 4])
    with open_footage(path) as footage:
        decoded = len(list(footage.frames()))
    assert 0 < decoded < FRAMES
    captured = capfd.readouterr()
    assert (captured.out, captured.err) == ("", "")
