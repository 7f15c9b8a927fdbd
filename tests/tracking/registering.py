"""One template placed in one picture."""

from __future__ import annotations

import numpy as np

from count_video.records import Luma
from count_video.tracking.registration import Fit, register_all
from count_video.tracking.template import Template


def register(picture: Luma, template: Template, guess: tuple[float, float]) -> Fit | None:
    """Place the template in a picture, starting from a guess; None where there is no place."""
    return register_all([picture], template, np.array([guess])).fit(0)
