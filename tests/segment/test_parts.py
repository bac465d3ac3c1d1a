"""What automatic parts of known solids are, and what they do not depend on."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from grid_solids import Rule, ball, dumbbell, mug, pan, voxel_mesh
from scipy.spatial.transform import Rotation

import graft
from graft.errors import InputError
from graft.evaluate.cut_measures import rand_index_error
from graft.objects import Floats, Ints, Part, PartObject
from graft.parts import cut_part

Mesh = tuple[Floats, Ints, Ints]


@pytest.fixture(scope="module")
def solid() -> Callable[[Rule], Mesh]:
    made: dict[Rule, Mesh] = {}

    def get(rule: Rule) -> Mesh:
        if rule not in made:
            made[rule] = voxel_mesh(rule)
        return made[rule]

    return get


def cut(vertices: Floats, faces: Ints, **options: int) -> Ints:
    return cut_part(Part("object", vertices, faces), **options).labels


@pytest.mark.parametrize(("rule", "most"), [(mug, 0.05), (pan, 0.05), (dumbbell, 0.05), (ball, 0.0)])
def test_parts_of_known_solids_are_found(solid, rule: Rule, most: float) -> None:
    vertices, faces, drawn = solid(rule)
    assert rand_index_error(cut(vertices, faces), drawn) <= most


def test_a_mug_has_two_parts_in_any_pose_and_unit(solid) -> None:
    vertices, faces, drawn = solid(mug)
    for seed in range(3):
        turn = Rotation.random(rng=np.random.default_rng(seed)).as_matrix()
        moved = 10.0 ** (4 * seed - 4) * (vertices @ turn.T + [5.0, -3.0, 2.0])
        assert rand_index_error(cut(moved, faces), drawn) < 0.06


def test_the_same_seed_gives_the_same_parts(solid) -> None:
    vertices, faces, _ = solid(dumbbell)
    assert np.array_equal(cut(vertices, faces, seed=3), cut(vertices, faces, seed=3))


def test_the_number_of_parts_is_as_asked(solid) -> None:
    vertices, faces, _ = solid(dumbbell)
    for n_parts in (1, 2, 5):
        assert len(np.unique(cut(vertices, faces, n_parts=n_parts))) == n_parts


def test_parts_are_numbered_by_falling_area(solid) -> None:
    vertices, faces, _ = solid(mug)
    labels = cut(vertices, faces)
    corners = vertices[faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    sizes = np.bincount(labels, areas)
    assert (np.diff(sizes) <= 0).all()


def test_every_level_is_made_of_parts_of_the_next(solid) -> None:
    vertices, faces, _ = solid(mug)
    cuts = cut_part(Part("mug", vertices, faces), hierarchy=True)
    counts = [len(np.unique(labels)) for labels in cuts.levels]
    assert counts == list(range(1, len(counts) + 1))
    assert counts[cuts.chosen] == 2
    for coarse, fine in zip(cuts.levels[:-1], cuts.levels[1:], strict=True):
        for part in np.unique(fine):
            assert len(np.unique(coarse[fine == part])) == 1


def test_a_cloud_is_cut_like_its_mesh(solid) -> None:
    vertices, faces, drawn = solid(dumbbell)
    points, labels = vertices[faces].mean(axis=1), drawn
    cuts = cut_part(Part("cloud", points))
    assert rand_index_error(cuts.labels, labels) < 0.15


def test_named_parts_are_kept_and_fused_on_request(solid) -> None:
    vertices, faces, drawn = solid(mug)
    pieces = tuple(Part(f"p{k}", vertices, faces[drawn == k]) for k in (0, 1))
    obj = PartObject("mug", pieces, graspable=(1,))
    kept = graft.segment(obj)
    assert kept.part_names == ("p0", "p1")
    assert "kept" in kept.notes[-1]
    anew = graft.segment(obj, fuse=True)
    assert len(anew.parts) == 2
    assert anew.graspable == ()
    assert sum(len(part.faces) for part in anew.parts) == len(faces)


def test_hierarchy_of_an_object_goes_from_one_part_up(solid) -> None:
    vertices, faces, _ = solid(dumbbell)
    levels = graft.segment_hierarchy((vertices, faces))
    assert [len(level.parts) for level in levels][:3] == [1, 2, 3]
    assert all(level.n_faces == len(faces) for level in levels)


@pytest.mark.parametrize("options", [{"n_parts": 0}, {"seed": -1}, {"n_parts": 2, "hierarchy": True}])
def test_bad_options_are_named(solid, options: dict[str, int]) -> None:
    vertices, faces, _ = solid(ball)
    with pytest.raises(InputError, match=next(iter(options))):
        cut_part(Part("ball", vertices, faces), **options)
