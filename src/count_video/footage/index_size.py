"""How many frames the index of an MP4 or MOV states, read before the decoder builds it in memory.

Such a file is a tree of boxes, each with a size and a name (ISO/IEC 14496-12). A sample table may
give all frames one size: then a few bytes state millions of frames, and every one of them takes
memory in the decoder's own index.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator
from typing import BinaryIO

_FOLDERS = frozenset({b"moov", b"trak", b"mdia", b"minf", b"stbl", b"moof", b"traf"})
"""Boxes that hold boxes, on the way to a table of samples."""
_TABLES = frozenset({b"stsz", b"stz2", b"trun", b"hdlr", b"stts"})
_BOXES_AT_MOST = 200_000
"""Fragments of an hour are fewer; files that have more are as large as what they state."""
_ONE_TICK_EACH = struct.pack(">I", 1)


def frames_in_index(file: BinaryIO) -> int:
    """Return the number of entries that the decoder's index would have; 0 for another format."""
    frames, is_sound, is_plain, samples = 0, False, False, 0
    for name, table in _tables(file):
        if name == b"trak":
            frames, is_sound, is_plain, samples = frames + samples, False, False, 0
        elif name == b"hdlr":
            is_sound = table[8:12] == b"soun"
        elif name == b"stts":
            is_plain = table[4:8] == _ONE_TICK_EACH == table[12:16]
        elif name == b"trun":
            frames += int.from_bytes(table[4:8], "big")
        else:
            samples = int.from_bytes(table[8:12], "big")
        if is_sound and is_plain:  # plain sound waves: the decoder's index has their chunks alone
            samples = 0
    return frames + samples


def _tables(file: BinaryIO) -> Iterator[tuple[bytes, bytes]]:
    """Yield the name of every track and table, and the first bytes of what a table holds."""
    file_end = file.seek(0, os.SEEK_END)
    place = 0
    for _ in range(_BOXES_AT_MOST):
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
        if name in _TABLES or name == b"trak":
            yield name, file.read(16)
        if name in _FOLDERS:
            place = start
        elif 8 <= size <= file_end - place:
            place += size
        else:
            return
