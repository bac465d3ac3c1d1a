import numpy as np
from numpy.testing import assert_allclose

from graft.contact.encoding import BAND_DECAY, BANDS, fourier_encoding


def test_matches_the_formula_octave_by_octave():
    point = np.array([0.3, -0.7, 1.0])
    code = fourier_encoding(point)
    expected = np.concatenate(
        [
            BAND_DECAY**k * np.concatenate([np.sin(2**k * np.pi * point / 2), np.cos(2**k * np.pi * point / 2)])
            for k in range(BANDS)
        ]
    )
    assert_allclose(code, expected, atol=1e-12)


def test_the_two_ends_of_a_part_have_different_codes():
    # Under the paper's phi(p) = [sin(2^k pi p), cos(2^k pi p)] they coincide at every octave.
    ends = fourier_encoding(np.array([[-1.0, 0, 0], [1.0, 0, 0]]))
    assert np.linalg.norm(ends[0] - ends[1]) > 1.0
    papers = [np.sin(2**k * np.pi * np.array([-1.0, 1.0])) for k in range(BANDS)]
    assert_allclose([p[0] - p[1] for p in papers], 0, atol=1e-9)


def test_distance_grows_with_the_offset():
    offsets = np.linspace(0, 1.6, 200)
    codes = fourier_encoding(np.stack([offsets, 0 * offsets, 0 * offsets], axis=1))
    distance = np.linalg.norm(codes - codes[0], axis=1)
    assert (np.diff(distance) > 0).all()


def test_shape_follows_the_points():
    assert fourier_encoding(np.zeros((4, 5, 3))).shape == (4, 5, 6 * BANDS)
    assert fourier_encoding(np.zeros(3), bands=2).shape == (12,)
