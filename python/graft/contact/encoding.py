"""Fourier encoding of canonical coordinates, by which points of two parts are compared."""

from __future__ import annotations

import numpy as np

from graft.objects import Floats

BANDS = 6
"""Octaves k = 0..5 (the paper's K)."""

BAND_DECAY = 0.5
"""Amplitude of each octave relative to the one below. With equal amplitudes the finest octave, whose period is a
sixteenth of the box, counts as much as the coarsest, and the nearest code of a point that has no exact counterpart
may lie anywhere; halving keeps the distance growing with the offset (checked in the tests) and leaves exact
counterparts exact."""


def fourier_encoding(points: Floats, *, bands: int = BANDS, decay: float = BAND_DECAY) -> Floats:
    """Encode canonical coordinates: phi(p) = decay^k [sin(2^k pi p / 2), cos(2^k pi p / 2)], k = 0..bands-1.

    The paper writes phi(p) = [sin(2^k pi p), cos(2^k pi p)] over [-1, 1], under which the two ends of a part,
    p = -1 and p = 1, have the same code at every octave. Halving p gives the coarsest octave a period of 4 and
    each point of the box a code of its own.

    Args:
        points: (..., 3) canonical coordinates, in [-1, 1] on the part.
        bands: Number of octaves.
        decay: Amplitude ratio of neighbouring octaves; 1 is the paper's.

    Returns:
        (..., 6 * bands) codes.
    """
    points = np.asarray(points, np.float64)
    octaves = np.arange(bands)
    angles = points[..., None, :] * (2.0**octaves * (np.pi / 2.0))[:, None]
    amplitude = (decay**octaves)[:, None]
    waves = np.concatenate([amplitude * np.sin(angles), amplitude * np.cos(angles)], axis=-1)
    return waves.reshape(*points.shape[:-1], 6 * bands)
