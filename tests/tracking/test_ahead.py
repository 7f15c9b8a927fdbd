from __future__ import annotations

import numpy as np

from count_video.tracking.ahead import has_face


def strip(face: int | None, body: int) -> np.ndarray:
    """What lies ahead of a body that ends at a place, with a wall that begins at another."""
    picture = np.full((21, 80), 100.0)
    picture[:, :body] = 40.0
    if face is not None:
        picture[:, face:] = 120.0
    return picture


def test_a_wall_ahead_is_seen_and_the_edge_of_the_body_itself_is_not() -> None:
    assert has_face(strip(60, 20), strip(60, 30))
    assert not has_face(strip(None, 20), strip(None, 30))


def test_what_is_lower_than_the_body_is_no_wall() -> None:
    before, after = strip(60, 20), strip(60, 30)
    for picture in (before, after):
        picture[:10] = np.where(np.arange(80) < 30, picture[:10], 100.0)

    assert not has_face(before, after)
