"""Damage to bytes, as it happens to files and as somebody would do it on purpose."""

from __future__ import annotations

import random
import struct
from collections.abc import Callable

Edit = Callable[[bytearray, int, random.Random], None]

_BYTES = (0x00, 0x01, 0x7F, 0x80, 0xFF)
_WORDS = (0, 1, 2, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 40_000_000, 60_000)
_TEXTS = (b"nan", b"1e308", b"9" * 400, b"-1", b"\0", b'"', b"{", b"[" * 50, b"\xff\xfe", b",\n")


def flip_a_bit(data: bytearray, place: int, chance: random.Random) -> None:
    data[place] ^= 1 << chance.randrange(8)


def set_a_byte(data: bytearray, place: int, chance: random.Random) -> None:
    data[place] = chance.choice(_BYTES)


def set_a_number(data: bytearray, place: int, chance: random.Random) -> None:
    order = chance.choice("<>")
    data[place : place + 4] = struct.pack(f"{order}I", chance.choice(_WORDS))


def insert_a_text(data: bytearray, place: int, chance: random.Random) -> None:
    data[place:place] = chance.choice(_TEXTS)


def cut_out(data: bytearray, place: int, chance: random.Random) -> None:
    del data[place : place + chance.choice((1, 8, 100, 1000))]


def blank_out(data: bytearray, place: int, chance: random.Random) -> None:
    end = min(len(data), place + chance.choice((8, 100, 1000)))
    data[place:end] = bytes(end - place)


def repeat(data: bytearray, place: int, chance: random.Random) -> None:
    data[place:place] = data[place : place + chance.choice((1, 8, 100, 1000))]


def cut_off(data: bytearray, place: int, _chance: random.Random) -> None:
    del data[place:]


EDITS: tuple[Edit, ...] = (
    *(flip_a_bit, set_a_byte, set_a_number, insert_a_text),
    *(cut_out, blank_out, repeat, cut_off),
)
HEADER_BYTES = 1000
"""Sizes, counts and tags stand there in files whose index comes first."""


def mutated(data: bytes, seed: int) -> bytes:
    """Damage bytes in 1 to 8 places; the same seed damages them the same way."""
    chance = random.Random(seed)
    damaged = bytearray(data)
    reach = HEADER_BYTES if chance.random() < 0.6 else len(data)
    for _ in range(chance.choice((1, 1, 2, 3, 8))):
        if damaged:
            place = chance.randrange(min(reach, len(damaged)))
            chance.choice(EDITS)(damaged, place, chance)
    return bytes(damaged)
