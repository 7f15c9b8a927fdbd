"""Frames that carry their own number, so that it can be read back after any codec."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from count_video.records import FootageReport, Frame
from count_video.video.reader import open_footage
from count_video.video.writer import WriteOptions, write_clip

Luma = NDArray[np.uint8]

HEIGHT, WIDTH = 96, 160
BITS = 10
BIT_PX = 16
DARK, BRIGHT = 40, 210
FPS = Fraction(30)


def numbered(number: int) -> Luma:
    """Draw a scene with its number as a bar code on top and a ball that moves 3 px a frame."""
    rows, columns = np.indices((HEIGHT, WIDTH))
    picture = (90 + columns // 4).astype(np.uint8)
    ball_x = 20 + (3 * number) % (WIDTH - 40)
    picture[(rows - 60) ** 2 + (columns - ball_x) ** 2 < 15**2] = BRIGHT
    for bit in range(BITS):
        level = BRIGHT if number >> bit & 1 else DARK
        picture[:BIT_PX, bit * BIT_PX : (bit + 1) * BIT_PX] = level
    return picture


def number_in(luma: Luma) -> int:
    """Read the bar code: the mean of each block's middle, clear of its blurred rim."""
    middles = luma[4 : BIT_PX - 4].reshape(-1, WIDTH // BIT_PX, BIT_PX)[:, :BITS, 4:-4]
    bits = middles.mean(axis=(0, 2)) > (DARK + BRIGHT) / 2
    return int(bits @ (1 << np.arange(BITS)))


def write_numbered(path: Path, frames: int, options: WriteOptions | None = None) -> Path:
    write_clip(path, map(numbered, range(frames)), options or WriteOptions())
    return path


def numbers_read(path: Path) -> tuple[list[int], FootageReport]:
    """Decode a clip to its end: the number in each frame, and the report."""
    with open_footage(path) as footage:
        numbers = [number_in(frame.luma) for frame in footage.frames()]
        return numbers, footage.report()


def numbers_of(frames: list[Frame]) -> list[int]:
    return [number_in(frame.luma) for frame in frames]
