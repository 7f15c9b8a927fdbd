"""Stated uncertainties that hold: judged by how smooth the track is, not by the pictures alone.

The registration takes the noise of a picture for white. Encoders leave errors that neighbouring
pixels share, and quarter-pixel motion of whole blocks, so its uncertainties come out too small by
factors of two to five. The track tells: bodies move smoothly from frame to frame but for the
collisions, and third differences show what does not belong to such a motion.
"""

from __future__ import annotations

import numpy as np

from count_video.records import Floats
from count_video.signals import noise_px


def stated_sigma(position_px: Floats, sigma_px: Floats) -> Floats:
    """Enlarge uncertainties until they cover the noise of the track, all by one factor.

    Parameters
    ----------
    position_px, sigma_px
        Shape (n,), places of one body and their standard uncertainties by the registration, in px;
        NaN where not seen.

    Returns
    -------
    Floats
        Shape (n,); never smaller than ``sigma_px``. Errors that last for many frames do not show in
        the track and are not covered.
    """
    seen = sigma_px[np.isfinite(sigma_px)]
    typical = float(np.median(seen)) if len(seen) else 0.0
    if typical == 0.0:
        return sigma_px
    return sigma_px * max(1.0, noise_px(position_px) / typical)
