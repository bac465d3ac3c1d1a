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
    waves = np.empty((*points.shape[:-1], bands, 6))
    sine, cosine = np.sin(points * (np.pi / 2.0)), np.cos(points * (np.pi / 2.0))
    for octave in range(bands):
        waves[..., octave, :3] = decay**octave * sine
        waves[..., octave, 3:] = decay**octave * cosine
        sine, cosine = 2.0 * sine * cosine, 1.0 - 2.0 * sine * sine  # the next octave is the double angle
    return waves.reshape(*points.shape[:-1], 6 * bands)
