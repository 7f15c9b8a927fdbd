from __future__ import annotations

import av
import numpy as np
import pytest

from count_video.video.pictures import chroma_of, luma_of, luma_shift

HEIGHT, WIDTH = 48, 70  # no multiple of 32: FFmpeg pads every line

EIGHT_BIT = ["yuv420p", "yuvj420p", "yuv422p", "yuv444p", "yuv410p", "yuva420p", "gray", "nv12"]
DEEPER = {"yuv420p10le": 2, "yuv422p10le": 2, "yuv420p12le": 4, "gray10le": 2, "p010le": 8}
"""Formats and the bits that a stored value has below the upper 8."""
CONVERTED = ["rgb24", "bgr0", "yuyv422", "gbrp"]


def planar(pixel_format: str, luma: np.ndarray) -> av.VideoFrame:
    """Make a picture with the given values in its first plane."""
    frame = av.VideoFrame(WIDTH, HEIGHT, pixel_format)
    stored = np.frombuffer(memoryview(frame.planes[0]), luma.dtype).reshape(HEIGHT, -1)
    stored[...] = 99
    stored[:, :WIDTH] = luma
    return frame


def noise(levels: int) -> np.ndarray:
    return np.random.default_rng(5).integers(0, levels, (HEIGHT, WIDTH))


@pytest.mark.parametrize("pixel_format", EIGHT_BIT)
def test_eight_bit_luma_is_a_view_of_the_plane_without_its_padding(pixel_format: str) -> None:
    written = noise(256).astype(np.uint8)
    frame = planar(pixel_format, written)
    assert frame.planes[0].line_size > WIDTH
    luma = luma_of(frame)
    assert luma.ctypes.data == frame.planes[0].buffer_ptr
    np.testing.assert_array_equal(luma, written)


@pytest.mark.parametrize(("pixel_format", "shift"), DEEPER.items())
def test_deeper_luma_is_rounded_down_to_eight_bits(pixel_format: str, shift: int) -> None:
    written = noise(256 << shift).astype("<u2")
    luma = luma_of(planar(pixel_format, written))
    assert luma.dtype == np.uint8
    np.testing.assert_array_equal(luma, written >> shift)


@pytest.mark.parametrize("pixel_format", CONVERTED)
def test_other_layouts_are_converted_to_grey(pixel_format: str) -> None:
    grey = np.broadcast_to(np.linspace(20, 230, WIDTH).astype(np.uint8), (HEIGHT, WIDTH))
    source = av.VideoFrame.from_ndarray(np.ascontiguousarray(grey), format="gray")
    frame = source.reformat(format=pixel_format)
    assert luma_shift(pixel_format) is None
    # Each of the two conversions rounds, and one may go through limited range.
    assert np.abs(luma_of(frame).astype(int) - grey).max() <= 3


def test_a_view_outlives_the_picture_and_the_decoder_does_not_write_into_it() -> None:
    written = noise(256).astype(np.uint8)
    luma = luma_of(planar("yuv420p", written))
    others = [planar("yuv420p", np.zeros_like(written)) for _ in range(5)]
    np.testing.assert_array_equal(luma, written)
    assert len(others) == 5


@pytest.mark.parametrize("pixel_format", ["yuv420p", "yuv422p", "yuv444p", "nv12", "yuv420p10le"])
@pytest.mark.parametrize("size", [(48, 70), (47, 69)])
def test_chroma_is_that_of_the_picture_at_half_size(
    pixel_format: str, size: tuple[int, int]
) -> None:
    rows, columns = size
    rgb = np.full((rows, columns, 3), 90, np.uint8)
    rgb[:, columns // 2 :] = 220, 110, 40
    frame = av.VideoFrame.from_ndarray(rgb, format="rgb24").reformat(format=pixel_format)
    chroma = chroma_of(frame)
    assert chroma is not None
    assert chroma.shape == (2, (rows + 1) // 2, (columns + 1) // 2)
    grey, orange = chroma[:, :, :10].astype(int), chroma[:, :, -10:].astype(int)
    assert np.abs(grey - 128).max() <= 1
    # BT.601: U = 128 - 0.148 R - 0.291 G + 0.439 B, V = 128 + 0.439 R - 0.368 G - 0.071 B.
    expected = np.array([81.0, 181.0])[:, None, None]
    assert np.abs(orange - expected).max() <= 2


@pytest.mark.parametrize("pixel_format", ["gray", "gray10le", *CONVERTED])
def test_pictures_without_planes_of_colour_have_no_chroma(pixel_format: str) -> None:
    assert chroma_of(av.VideoFrame(WIDTH, HEIGHT, pixel_format)) is None
