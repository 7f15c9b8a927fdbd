"""Open a file and choose its video stream; whatever is wrong becomes one sentence."""

from __future__ import annotations

import os
import stat
import struct
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO

import av
import av.error
from av.container import InputContainer
from av.stream import Disposition

from count_video.errors import FootageError
from count_video.process import check_memory

WEB_ADDRESSES = (("http:",), ("https:",), ("ftp:",))
"""First parts of paths that were meant for addresses on the web."""
MOST_PIXELS = 20_000_000
"""Of one picture: above the 4096 x 4320 of today's cameras, and 16 reference pictures of this size
take half a gigabyte in the decoder."""
SHORTEST_SIDE_PX, LONGEST_SIDE_PX = 16, 16_384
"""A body of use is larger than the first, and no filter of the tracker fits into less."""
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
_GIVE_CLIPS = (
    "give the clip itself, or a table of clips saved as CSV, with a name that ends in .csv"
)


def open_container(path: Path) -> InputContainer:
    """Open a media file.

    FootageError if there is no such file, it may not be read, it is no media file, or its index is
    too long; MemoryError if there is not as much memory as it may take to open a file.
    """
    _check_readable(path)
    try:
        with _bounded_memory():
            # An absolute path can never be taken for a URL.
            container = av.open(os.path.abspath(path), options=_OPTIONS, metadata_errors="replace")
    except (av.error.FFmpegError, OSError, ValueError) as error:
        if isinstance(error, MemoryError):
            check_memory(OPENING_BYTES)
        if path.suffix.lower() in (".txt", ".tsv", ".xls", ".xlsx", ".ods"):
            raise FootageError(f"{path}: this is no video; {_GIVE_CLIPS}") from error
        raise FootageError(
            f"{path}: not readable as video ({plain_words(error)}); the file is damaged, cut off "
            "before its index was written, or no video file: copy it again from the camera"
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

    FootageError if there is none that can be decoded, or it states a picture too large.
    """
    no_film = Disposition.attached_pic | Disposition.timed_thumbnails
    films = [
        stream
        for stream in container.streams.video
        if stream.codec_context is not None and not stream.disposition & no_film
    ]
    if not films:
        kinds = ", ".join(sorted({stream.type for stream in container.streams})) or "no stream"
        raise FootageError(
            f"{path}: no video stream that can be decoded (found: {kinds}); give a clip with "
            "pictures, or convert it to H.264"
        )

    def rank(stream: av.VideoStream) -> tuple[bool, bool, bool, int]:
        context = stream.codec_context
        # Phones store a large still beside the film and call both the default.
        default = bool(stream.disposition & Disposition.default)
        still = context.name in _STILLS
        return stream.frames != 1, default, not still, context.width * context.height

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
    except FileNotFoundError as error:
        if path.parts[:1] in WEB_ADDRESSES:
            raise FootageError(
                f"{path}: this is an address on the web; download it first"
            ) from error
        lost = "is a link to a file that is not there" if path.is_symlink() else "no such file"
        raise FootageError(f"{path}: {lost}; check the name") from error
    except (OSError, ValueError) as error:
        reason = plain_words(error)
        raise FootageError(f"{path}: cannot be read ({reason}); check its rights") from error
    if frames > MOST_FRAMES:
        raise FootageError(
            f"{path}: its index states {frames} frames, more than {MOST_FRAMES}; the file "
            "is damaged, or cut the clip into parts"
        )


def plain_words(error: Exception) -> str:
    """Return what the system says about an error, on one line and without its bookkeeping."""
    return " ".join((getattr(error, "strerror", None) or str(error)).split())


def frames_in_index(file: BinaryIO) -> int:
    """How many entries the decoder's index of an MP4 or MOV would have; 0 for another format.

    A sample table may give all frames one size: then a few bytes state millions of frames, and
    every one of them takes memory in the decoder's own index.
    """
    frames, is_sound, is_plain, samples = 0, False, False, 0
    for name, table in _tables(file):
        if name == b"trak":
            frames, is_sound, is_plain, samples = frames + samples, False, False, 0
        elif name == b"hdlr":
            is_sound = table[8:12] == b"soun"
        elif name == b"stts":
            is_plain = table[4:8] == struct.pack(">I", 1) == table[12:16]  # one tick each
        elif name == b"trun":
            frames += int.from_bytes(table[4:8], "big")
        else:
            samples = int.from_bytes(table[8:12], "big")
        if is_sound and is_plain:  # plain sound waves: the decoder's index has their chunks alone
            samples = 0
    return frames + samples


def _tables(file: BinaryIO) -> Iterator[tuple[bytes, bytes]]:
    """Yield name and first bytes of the tables in a tree of boxes (ISO/IEC 14496-12)."""
    file_end = file.seek(0, os.SEEK_END)
    place = 0
    # Fragments of an hour are fewer; files that have more are as large as what they state.
    for _ in range(200_000):
        file.seek(place)
        header = file.read(8)
        if len(header) < 8:
            return
        size, name = struct.unpack(">I4s", header)
        start = place + 8
        if size == 1:  # the true size follows, in 64 bits
            size, start = int.from_bytes(file.read(8), "big"), place + 16
        elif size == 0:  # to the end of the file
            size = file_end - place
        if name in (b"trak", b"stsz", b"stz2", b"trun", b"hdlr", b"stts"):
            yield name, file.read(16)
        if name in (b"moov", b"trak", b"mdia", b"minf", b"stbl", b"moof", b"traf"):
            place = start
        elif 8 <= size <= file_end - place:
            place += size
        else:
            return
