"""Open a file and choose its video stream; whatever is wrong becomes one sentence."""

from __future__ import annotations

import os
import stat
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import av
import av.error
from av.container import InputContainer
from av.stream import Disposition

from count_video.errors import FootageError
from count_video.footage.index_size import frames_in_index
from count_video.process import check_memory

MOST_PIXELS = 20_000_000
"""Of one picture: above the 4096 x 4320 of today's cameras, and 16 reference pictures of this size
take half a gigabyte in the decoder."""
LONGEST_SIDE_PX = 16_384
SHORTEST_SIDE_PX = 16
"""A body of use is larger, and no filter of the tracker fits into less."""
MOST_FRAMES = 1_000_000
"""More than an hour at 240 frames per second. Each takes some 60 bytes of an index in memory."""

OPENING_BYTES = 700_000_000
"""To open a file takes an index of up to 100 MB and a few decoded pictures."""
_one_at_a_time = threading.Lock()

_OPTIONS = {
    "protocol_whitelist": "file",  # playlists reach no network
    "pattern_type": "none",  # img%03d.png is the name of one file
    "max_pixels": str(MOST_PIXELS),  # checked before a decoder allocates a picture
}
_TEXT_FORMATS = frozenset({"tty", "bin", "adf", "idf", "xbin", "concat", "hls"})
"""FFmpeg paints text as pictures and follows lists of other files; nobody means that as footage."""
_STILLS = frozenset({"mjpeg", "png", "bmp", "gif", "tiff", "webp"})
"""Coded so, a stream beside another one is likely its cover, where no header says so."""
_TABLES = frozenset({".txt", ".tsv", ".xls", ".xlsx", ".ods"})
_GIVE_CLIPS = (
    "give the clip itself, or a table of clips saved as CSV, with a name that ends in .csv"
)


def open_container(path: Path) -> InputContainer:
    """Open a media file.

    Raises
    ------
    FootageError
        If there is no such file, it may not be read, it is no media file, or its index is too
        long.
    MemoryError
        If there is not as much memory as it may take to open a file.
    """
    _check_readable(path)
    try:
        with _bounded_memory():
            # An absolute path can never be taken for a URL.
            container = av.open(os.path.abspath(path), options=_OPTIONS, metadata_errors="replace")
    except (av.error.FFmpegError, OSError, ValueError) as error:
        if isinstance(error, MemoryError):
            check_memory(OPENING_BYTES)
        if path.suffix.lower() in _TABLES:
            raise FootageError(f"{path}: this is no video; {_GIVE_CLIPS}") from error
        raise FootageError(
            f"{path}: not readable as video ({_short(error)}); the file is damaged, cut off before "
            "its index was written, or no video file: copy it again from the camera"
        ) from error
    if container.format.name in _TEXT_FORMATS:
        container.close()
        raise FootageError(f"{path}: this is a text file, not a video; {_GIVE_CLIPS}")
    return container


@contextmanager
def _bounded_memory() -> Iterator[None]:
    """Let this process take little more memory than it has, where the system (Linux) can.

    Headers state how many entries of many kinds there are, and FFmpeg takes memory for some of them
    before it finds that they are not there.
    """
    with _one_at_a_time:
        try:
            pages = int(Path("/proc/self/statm").read_text("ascii").split()[5])
        except (OSError, ValueError, LookupError):
            yield
            return
        import resource  # noqa: PLC0415 - not on every system

        before, most = resource.getrlimit(resource.RLIMIT_DATA)
        limit = pages * resource.getpagesize() + OPENING_BYTES
        if before == resource.RLIM_INFINITY or limit < before:
            resource.setrlimit(resource.RLIMIT_DATA, (limit, most))
        try:
            yield
        finally:
            resource.setrlimit(resource.RLIMIT_DATA, (before, most))


def choose_stream(path: Path, container: InputContainer) -> av.VideoStream:
    """Return the video stream to count in: the default one, else the film, else the largest.

    Raises
    ------
    FootageError
        If the file holds no moving picture that can be decoded, or states a picture too large.
    """
    films = [
        stream
        for stream in container.streams.video
        if stream.codec_context is not None
        and not stream.disposition & (Disposition.attached_pic | Disposition.timed_thumbnails)
    ]
    if not films:
        kinds = ", ".join(sorted({stream.type for stream in container.streams})) or "no stream"
        raise FootageError(
            f"{path}: no video stream that can be decoded (found: {kinds}); give a clip with "
            "pictures, or convert it to H.264"
        )

    def rank(stream: av.VideoStream) -> tuple[bool, bool, bool, int]:
        size = stream.codec_context.width * stream.codec_context.height
        # Phones store a large still beside the film and call both the default.
        default = bool(stream.disposition & Disposition.default)
        still = stream.codec_context.name in _STILLS
        return stream.frames != 1, default, not still, size

    film = max(films, key=rank)
    film.codec_context.options = {"max_pixels": str(MOST_PIXELS)}
    check_size(path, film.codec_context.width, film.codec_context.height)
    return film


def check_size(path: Path, width_px: int, height_px: int) -> None:
    """Raise FootageError if pictures are too large to decode or too small to show anything.

    A size of 0 is one that is not stated.
    """
    longest, shortest = max(width_px, height_px), min(width_px, height_px)
    if width_px * height_px > MOST_PIXELS or longest > LONGEST_SIDE_PX:
        raise FootageError(
            f"{path}: pictures of {width_px} x {height_px} px are too large (at most "
            f"{MOST_PIXELS // 1_000_000} million pixels, {LONGEST_SIDE_PX} px a side); scale the "
            "clip down"
        )
    if 0 < shortest < SHORTEST_SIDE_PX:
        raise FootageError(
            f"{path}: pictures of {width_px} x {height_px} px show nothing that could be counted; "
            f"give a clip of at least {SHORTEST_SIDE_PX} px a side"
        )


def _check_readable(path: Path) -> None:
    try:
        mode = path.stat().st_mode
        if stat.S_ISDIR(mode):
            raise FootageError(f"{path}: this is a folder, not a video file; give a file in it")
        if not stat.S_ISREG(mode):
            raise FootageError(f"{path}: this is no regular file; save the clip to a file first")
        with path.open("rb") as file:
            if not file.read(1):
                raise FootageError(f"{path}: the file is empty; copy it again from the camera")
            frames = frames_in_index(file)
            if frames > MOST_FRAMES:
                raise FootageError(
                    f"{path}: its index states {frames} frames, more than {MOST_FRAMES}; the file "
                    "is damaged, or cut the clip into parts"
                )
    except FileNotFoundError as error:
        raise FootageError(f"{path}: no such file; check the name") from error
    except (OSError, ValueError) as error:
        raise FootageError(f"{path}: cannot be read ({_short(error)}); check its rights") from error


def _short(error: Exception) -> str:
    """Return what the system says about an error, without its bookkeeping."""
    text = getattr(error, "strerror", None) or str(error)
    return " ".join(text.split())
