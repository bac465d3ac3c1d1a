import numpy as np
import pytest
from evaluation_shapes import hammer
from numpy.testing import assert_allclose

from graft.evaluate.perturb import perturb_parts
from graft.evaluate.protocols import stream
from graft.objects import Part, PartObject

DIAGONAL = 4.4


def surface_area(obj):
    corners = np.concatenate([part.vertices[part.faces] for part in obj.parts])
    return np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum() / 2


def forked():
    """A hammer with a second head, so that there are two parts of one kind to merge."""
    base = hammer("forked")
    claw = base.parts[0].transformed(np.array([[1, 0, 0, 0.8], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]], float))
    return PartObject(
        "forked", (*base.parts, Part("claw", claw.vertices, claw.faces)), graspable=(1,), category="hammer"
    )


@pytest.mark.parametrize("seed", range(8))
def test_the_surface_stays_and_some_part_is_graspable(seed):
    obj = forked()
    seen, defect = perturb_parts(obj, DIAGONAL, stream(seed))
    assert defect is not None
    assert seen.n_faces == obj.n_faces
    assert_allclose(surface_area(seen), surface_area(obj))
    assert seen.graspable
    assert seen.part_names != obj.part_names or any(
        len(a.faces) != len(b.faces) for a, b in zip(seen.parts, obj.parts, strict=True)
    )


def test_every_defect_comes_and_does_what_it_says():
    obj = forked()
    found = {}
    for seed in range(30):
        seen, defect = perturb_parts(obj, DIAGONAL, stream(seed))
        found[defect] = seen
    assert set(found) == {"merged", "split", "shifted"}
    assert len(found["merged"].parts) == 2
    # Only the two heads may be merged: head and handle are not both graspable.
    assert [len(part.faces) for part in found["merged"].parts] == [864, 432]
    assert found["merged"].graspable == (1,)
    assert len(found["split"].parts) == 4
    assert len(found["shifted"].parts) == 3


def test_a_two_part_object_is_never_merged():
    for seed in range(20):
        _, defect = perturb_parts(hammer("hammer"), DIAGONAL, stream(seed))
        assert defect in ("split", "shifted")


def test_seed_decides():
    first, again = (perturb_parts(forked(), DIAGONAL, stream(3)) for _ in range(2))
    assert first[1] == again[1]
    assert all((a.vertices == b.vertices).all() for a, b in zip(first[0].parts, again[0].parts, strict=True))


def test_clouds_keep_their_points_and_normals():
    rng = np.random.default_rng(0)
    parts = tuple(
        Part(name, rng.normal(size=(60, 3)) + np.array([offset, 0, 0]), normals=np.eye(3)[rng.integers(3, size=60)])
        for name, offset in (("left", 0.0), ("right", 2.0))
    )
    seen, defect = perturb_parts(PartObject("cloud", parts, graspable=(0,)), 8.0, stream(1))
    assert defect is not None
    assert sum(len(part.vertices) for part in seen.parts) == 120
    assert all(part.normals is not None and len(part.normals) == len(part.vertices) for part in seen.parts)


def test_nothing_is_possible_on_a_single_small_part():
    lone = PartObject("lone", (Part("a", np.eye(3), np.array([[0, 1, 2]])),), graspable=(0,))
    seen, defect = perturb_parts(lone, 2.0, stream(0))
    assert defect is None
    assert seen is lone
