"""Errors of a tracker that hang together: what depends on where in the picture a body is.

An outline is measured a little off where it lies unluckily on the pixels, before a bright board or
next to the ball. In one frame that is far less than the noise, but it is the same in the next, and
the mean of a hundred frames has it still. How near the heavy body comes to the wall, from which a
long burst is counted, is just such a mean. So the fit leaves the outline a drift along its
path, straight between knots, of which it knows beforehand that each rise is small.
"""

from __future__ import annotations

import numpy as np

from count_video.between.parameters import DRIFTS
from count_video.records import Floats

NEAREST_RISE_PX = 2.0
"""The first rise, from the heavy body's nearest place on, is so long; the farther, the longer they
are: there one px more or less matters less."""
LENGTHENING = 2.0


def drift_shape(heavy_px: Floats) -> Floats:
    """Share of each rise in the drift of each frame, shape (frames, DRIFTS); 0 where not seen.

    Far away the drift is 0: what remains there is part of the contact distance. A rise has its full
    share on the side of the wall, and none on the other.
    """
    seen = np.isfinite(heavy_px)
    far = heavy_px[seen, None] - heavy_px[seen].min(initial=np.inf)
    length = NEAREST_RISE_PX * LENGTHENING ** np.arange(DRIFTS)
    shape = np.zeros((len(heavy_px), DRIFTS))
    shape[seen] = np.clip((np.cumsum(length) - far) / length, 0.0, 1.0)
    return shape
