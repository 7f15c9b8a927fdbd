"""What a file says of its film, by PyAV alone: how it is coded, and when its pictures are shown."""

from __future__ import annotations

from pathlib import Path

import av


def coding_of(path: Path) -> tuple[str, str]:
    """FFmpeg's names of the decoder and of the layout of the pixels."""
    with av.open(str(path)) as container:
        context = container.streams.video[0].codec_context
        return context.name, str(context.pix_fmt)


def time_stamps_s(path: Path) -> list[float]:
    """Seconds of footage time at which each picture is shown, rounded once."""
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        assert stream.time_base is not None
        return [float((frame.pts or 0) * stream.time_base) for frame in container.decode(stream)]
