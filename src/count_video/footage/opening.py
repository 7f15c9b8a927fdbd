"""Open a file and choose its video stream; whatever is wrong becomes one sentence."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import av
import av.error
from av.container import InputContainer
from av.stream import Disposition

from count_video.errors import FootageError

_TEXT_FORMATS = frozenset({"tty", "bin", "adf", "idf", "xbin", "concat", "hls"})
"""FFmpeg paints text as pictures and follows lists of other files; nobody means that as footage."""


def open_container(path: Path) -> InputContainer:
    """Open a media file.

    Raises
    ------
    FootageError
        If there is no such file, it may not be read, or it is no media file.
    """
    _check_readable(path)
    try:
        # An absolute path can never be taken for a URL, and playlists reach no network.
        container = av.open(
            os.path.abspath(path), options={"protocol_whitelist": "file"}, metadata_errors="replace"
        )
    except (av.error.FFmpegError, OSError, ValueError) as error:
        raise FootageError(
            f"{path}: not readable as video ({_short(error)}); the file is damaged, cut off before "
            "its index was written, or no video file: copy it again from the camera"
        ) from error
    if container.format.name in _TEXT_FORMATS:
        container.close()
        raise FootageError(f"{path}: this is a text file, not a video; give the clip itself")
    return container


def choose_stream(path: Path, container: InputContainer) -> av.VideoStream:
    """Return the video stream to count in: the default one, else the largest.

    Raises
    ------
    FootageError
        If the file holds no moving picture that can be decoded.
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

    def rank(stream: av.VideoStream) -> tuple[bool, bool, int]:
        size = stream.codec_context.width * stream.codec_context.height
        # Phones store a large still beside the film and call both the default.
        return stream.frames != 1, bool(stream.disposition & Disposition.default), size

    return max(films, key=rank)


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
    except FileNotFoundError as error:
        raise FootageError(f"{path}: no such file; check the name") from error
    except (OSError, ValueError) as error:
        raise FootageError(f"{path}: cannot be read ({_short(error)}); check its rights") from error


def _short(error: Exception) -> str:
    """Return what the system says about an error, without its bookkeeping."""
    text = getattr(error, "strerror", None) or str(error)
    return " ".join(text.split())
