"""Write clips: luma planes or RGB pictures to any container and codec that PyAV offers.

The same pictures and options give the same bytes: one encoder thread by default, and no dates or
random identifiers in the container.
"""

from __future__ import annotations

import os
import platform
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import chain, count
from pathlib import Path

import av
import av.error
import numpy as np
from av.container import OutputContainer
from numpy.typing import NDArray

from count_video.errors import UsageError
from count_video.outputs import appearing, remedy
from count_video.video.opening import plain_words
from count_video.video.pictures import luma_shift

Pixels = NDArray[np.uint8]

FINEST_TICK_S = Fraction(1, 90_000)
"""Time base of clips with given time stamps: the customary clock of MPEG, divides 24 to 240 fps."""


@dataclass(frozen=True)
class WriteOptions:
    """How to encode a clip."""

    container_fps: Fraction | float = Fraction(30)
    """Frames per second of footage time (the playing rate)."""
    codec: str = "libx264"
    """Name of the encoder: libx264, libx265, mjpeg, ffv1, libvpx-vp9, rawvideo ..."""
    crf: int = 18
    """Constant quality, 0 (best) to 51; lossless codecs take no notice."""
    preset: str = "veryfast"
    """Speed of libx264 and libx265."""
    pixel_format: str = "yuv420p"
    """Stored pixel layout, e.g. ``yuv420p10le``."""
    metadata: dict[str, str] = field(default_factory=dict)
    """Tags of the container, e.g. ``com.android.capture.fps``."""
    rotation_deg: int = 0
    """Counter-clockwise turn that display is asked for: 0, 90, 180 or 270."""
    more: dict[str, str] = field(default_factory=dict)
    """Other options of the encoder, by FFmpeg's names, e.g. ``g``, the frames from one key frame to
    the next, or ``threads``: more than one may change the bytes, 0 takes all cores."""
    frame_times_s: Sequence[Fraction | float] | None = None
    """Footage time of every frame for a variable rate, increasing; None for a constant rate."""
    index_first: bool = True
    """Put the index of MP4 and MOV before the pictures: then a file that was cut is readable up
    to the cut. Cameras write it last."""


def write_clip(path: Path, frames: Iterable[Pixels], options: WriteOptions | None = None) -> None:
    """Encode pictures into a file that appears under its name only when it is complete.

    UsageError if it cannot be written as asked; no file is left behind.

    Parameters
    ----------
    path
        Target; its suffix chooses the container (.mp4, .mov, .avi, .mkv, .webm).
    frames
        Luma, shape (height, width), written into the Y plane as it is with neutral chroma; or
        RGB, shape (height, width, 3). All of one shape; sides even for 4:2:0 formats.
    options
        Defaults to H.264 at 30 frames/s.
    """
    options = options or WriteOptions()
    pictures = iter(frames)
    first = next(pictures, None)
    if first is None:
        raise UsageError(f"cannot write {path}: there is no frame; give at least one")
    try:
        with appearing(path) as partial, _open(partial, options) as container:
            stream = _add_stream(container, first.shape, options)
            stamps = _time_stamps(options)
            for picture, ticks in zip(chain([first], pictures), stamps, strict=False):
                frame = _video_frame(picture, stream.codec_context.pix_fmt or options.pixel_format)
                frame.pts, frame.time_base = ticks, stream.codec_context.time_base
                container.mux(stream.encode(frame))
            container.mux(stream.encode(None))
    except (av.error.FFmpegError, OSError, _RefusalError) as error:
        # The text of the system's errors repeats a name that nobody gave.
        raise UsageError(
            f"cannot write {path} ({options.codec}, {options.pixel_format}): {plain_words(error)}; "
            + remedy(error, "check the folder, the suffix and that codec and container go together")
        ) from error


class _RefusalError(Exception):
    """The options or the pictures do not make a clip."""


def _open(path: Path, options: WriteOptions) -> OutputContainer:
    muxer_options = {"fflags": "+bitexact"}
    if path.suffix.lower() in (".mp4", ".mov", ".m4v"):
        muxer_options["movflags"] = "use_metadata_tags" + "+faststart" * options.index_first
    try:
        container = av.open(os.path.abspath(path), "w", options=muxer_options)
    except ValueError as error:  # no container has such a suffix
        raise _RefusalError(error) from error
    container.metadata.update(options.metadata)
    return container


def _add_stream(
    container: OutputContainer, shape: tuple[int, ...], options: WriteOptions
) -> av.VideoStream:
    rate = Fraction(options.container_fps).limit_denominator(100_000)
    try:
        stream = container.add_stream(options.codec, rate=rate, options=_encoder_options(options))
        if not isinstance(stream, av.VideoStream):
            raise _RefusalError(f"{options.codec} is no video codec")
        stream.height, stream.width = shape[:2]
        stream.pix_fmt = options.pixel_format
        if options.codec == "mjpeg":  # full range only, for which FFmpeg has names of its own
            stream.pix_fmt = options.pixel_format.replace("yuv4", "yuvj4")
    except (ValueError, TypeError) as error:  # unknown to FFmpeg, or not for this container
        raise _RefusalError(error) from error
    if "420" in options.pixel_format and (stream.height % 2 or stream.width % 2):
        raise _RefusalError(f"{stream.width} x {stream.height} px: both sides must be even")
    stream.codec_context.time_base = 1 / rate if options.frame_times_s is None else FINEST_TICK_S
    if options.rotation_deg:
        stream.set_display_rotation(options.rotation_deg)
    return stream


def _encoder_options(options: WriteOptions) -> dict[str, str]:
    chosen = {"flags": "+bitexact", "threads": "1"}
    if options.codec in ("libx264", "libx265"):
        chosen |= {"crf": str(options.crf), "preset": options.preset}
    if options.codec == "libx264" and platform.machine() in ("x86_64", "AMD64"):
        # With the wider instructions of newer processors libx264's mb-tree gives other bytes now
        # and then on a busy machine.
        chosen["x264-params"] = "asm=AVX2"
    if options.codec == "libx265":
        chosen["x265-params"] = "log-level=none"  # it writes to stderr past FFmpeg's log
    elif options.codec.startswith("libvpx"):
        # VP8 and VP9 count from 4 to 63.
        quality = str(max(4, round(options.crf * 63 / 51)))
        chosen |= {"crf": quality, "b": "0", "deadline": "realtime", "cpu-used": "8"}
    elif options.codec == "mjpeg":
        # JPEG's quantiser runs from 2 (best) to 31; spread the 0 to 51 of crf over it.
        scale = str(max(2, round(options.crf * 31 / 51)))
        chosen |= {"qmin": scale, "qmax": scale}
    return chosen | options.more


def _time_stamps(options: WriteOptions) -> Iterator[int]:
    """Yield the time stamp of each frame in ticks of the encoder's clock."""
    times_s, last = options.frame_times_s, -1
    if times_s is None:
        yield from count()
        return
    for number, time_s in enumerate(times_s):
        ticks = round(Fraction(time_s) / FINEST_TICK_S)
        if ticks <= last:
            raise _RefusalError(f"frame_times_s[{number}] does not come after the one before it")
        yield ticks
        last = ticks
    raise _RefusalError(f"frame_times_s ends after {len(times_s)} frames, but there are more")


def _video_frame(picture: Pixels, pixel_format: str) -> av.VideoFrame:
    """Put a picture into a frame of the stored layout; luma goes in unconverted."""
    shift = luma_shift(pixel_format)
    if picture.ndim == 3 or shift is None:
        source = "gray" if picture.ndim == 2 else "rgb24"
        return av.VideoFrame.from_ndarray(picture, format=source).reformat(format=pixel_format)
    height, width = picture.shape
    frame = av.VideoFrame(width, height, pixel_format)
    stored = "<u2" if shift else "u1"
    for plane in frame.planes:
        np.frombuffer(memoryview(plane), stored)[...] = 128 << shift  # neutral, where it is chroma
    luma = np.frombuffer(memoryview(frame.planes[0]), stored).reshape(height, -1)
    luma[...] = 0
    np.left_shift(picture, shift, out=luma[:, :width], dtype=stored)
    return frame
