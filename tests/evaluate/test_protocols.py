import json

import numpy as np
import pytest
from evaluation_shapes import hammer, tools
from numpy.testing import assert_allclose

from graft import zoo
from graft.errors import InputError
from graft.evaluate.protocols import (
    Posing,
    from_objects,
    load_objects,
    middles,
    paper,
    pose,
    random_similarity,
    stream,
)


def sources_of(benchmark, query):
    return [benchmark.sources[i].demonstration.name for i in query.sources]


def test_leave_category_out_never_answers_from_the_own_category():
    benchmark = from_objects("leave-category-out", tools(), Posing())
    assert [query.key for query in benchmark.queries] == ["hammer_a", "hammer_b", "paddle_a", "paddle_b"]
    assert sources_of(benchmark, benchmark.queries[0]) == ["paddle_a:shaft", "paddle_b:shaft"]


def test_within_category_leaves_the_target_out_and_skips_loners():
    lone = hammer("lone", category="mallet")
    benchmark = from_objects("within-category", [*tools(), lone], Posing())
    assert {query.key: sources_of(benchmark, query) for query in benchmark.queries} == {
        "hammer_a": ["hammer_b:handle"],
        "hammer_b": ["hammer_a:handle"],
        "paddle_a": ["paddle_b:shaft"],
        "paddle_b": ["paddle_a:shaft"],
    }


def test_one_source_asks_every_other_object_one_by_one():
    benchmark = from_objects("one-source", tools(), Posing(), source="paddle_b")
    assert [query.key for query in benchmark.queries] == [
        "hammer_a<paddle_b:shaft",
        "hammer_b<paddle_b:shaft",
        "paddle_a<paddle_b:shaft",
    ]
    # Without a source, the first object of each category answers.
    everyone = from_objects("one-source", tools(), Posing())
    assert {name for query in everyone.queries for name in sources_of(everyone, query)} == {
        "hammer_a:handle",
        "paddle_a:shaft",
    }


def test_halves_share_no_target_and_leave_none_out():
    whole, tuning, reporting = (
        [q.key for q in from_objects("leave-category-out", tools(), Posing(), half=half).queries]
        for half in ("both", "tuning", "reporting")
    )
    assert tuning == ["hammer_a", "paddle_a"]
    assert reporting == ["hammer_b", "paddle_b"]
    assert sorted(tuning + reporting) == whole


def test_limit_spreads_over_the_objects():
    benchmark = from_objects("leave-category-out", tools(), Posing(), limit=2)
    assert [query.key for query in benchmark.queries] == ["hammer_a", "paddle_a"]


def test_pose_moves_contact_up_and_metres_along():
    obj = hammer("hammer_a")
    shown = middles(obj)
    subject, (moved,) = pose("hammer_a", obj, Posing(seed=4), shown)
    sizes = [np.linalg.norm(o.parts[0].vertices - o.parts[0].vertices[0], axis=1).max() for o in (subject.object, obj)]
    factor = sizes[0] / sizes[1]
    assert 0.5 < factor < 2.0
    assert_allclose(subject.object.scale_to_metres * factor, obj.scale_to_metres)
    # Distances scale, the angle between normal and up stays.
    before = np.linalg.norm(obj.parts[1].vertices - shown[0].contact.point, axis=1)
    after = np.linalg.norm(subject.object.parts[1].vertices - moved.contact.point, axis=1)
    assert_allclose(after, factor * before, rtol=1e-6)
    assert_allclose(moved.contact.normal @ subject.object.up, shown[0].contact.normal @ obj.up, atol=1e-9)


def test_pose_depends_on_seed_and_name_only():
    obj = hammer("x")
    first = pose("x", obj, Posing(seed=1))[0].object.parts[0].vertices
    assert (pose("x", obj, Posing(seed=1))[0].object.parts[0].vertices == first).all()
    assert not np.allclose(pose("x", obj, Posing(seed=2))[0].object.parts[0].vertices, first)
    assert not np.allclose(pose("y", obj, Posing(seed=1))[0].object.parts[0].vertices, first)


def test_dropping_up_and_perturbing():
    subject, (moved,) = pose(
        "hammer_a", hammer("hammer_a"), Posing(up=False, perturb=True), middles(hammer("hammer_a"))
    )
    assert subject.object.up is None
    assert subject.defect in ("split", "shifted")
    assert subject.truth.part_names == ("head", "handle")
    # The contact belongs to the part that has its place now.
    part = subject.object.parts[moved.contact.part]
    closest = np.linalg.norm(part.vertices - moved.contact.point, axis=1).min()
    others = [p for i, p in enumerate(subject.object.parts) if i != moved.contact.part]
    assert closest <= min(np.linalg.norm(p.vertices - moved.contact.point, axis=1).min() for p in others)


def test_rotations_are_uniform():
    # The mean of uniformly drawn rotations is zero; of 4000 its entries deviate by 1 / sqrt(3 * 4000).
    rng = stream(0)
    mean = np.mean([random_similarity(rng, (1.0, 1.0))[:3, :3] for _ in range(4000)], axis=0)
    assert np.abs(mean).max() < 5 / np.sqrt(3 * 4000)


def test_paper_protocol_answers_unseen_from_demonstrated():
    benchmark = paper(Posing(), variants=2, limit=3)
    assert len(benchmark.queries) == 3
    assert len({benchmark.category(query.target) for query in benchmark.queries}) == 3
    shown = {benchmark.category(source.subject) for source in benchmark.sources}
    assert shown == {zoo.demonstration(c, 0).object.category for c in zoo.demonstrated()}
    assert all(benchmark.category(query.target) not in shown for query in benchmark.queries)


def test_folders_of_labelled_objects(tmp_path):
    for obj in tools()[:2]:
        folder = tmp_path / obj.name
        folder.mkdir()
        vertices = np.concatenate([part.vertices for part in obj.parts])
        faces = np.concatenate([obj.parts[0].faces, obj.parts[1].faces + len(obj.parts[0].vertices)])
        lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a} {b} {c}" for a, b, c in faces + 1]
        (folder / "mesh.obj").write_text("\n".join(lines))
        labels = np.repeat([0, 1], [len(part.faces) for part in obj.parts])
        (folder / "parts.seg").write_text("\n".join(map(str, labels)))
        (folder / "object.json").write_text(
            json.dumps({"category": "hammer", "part_names": ["head", "handle"], "graspable_parts": [1]})
        )
    objects = load_objects(tmp_path)
    assert [(obj.name, obj.graspable) for obj in objects] == [("hammer_a", (1,)), ("hammer_b", (1,))]


def test_bad_arguments_are_named(tmp_path):
    with pytest.raises(InputError, match="expected a folder"):
        load_objects(tmp_path / "nowhere")
    with pytest.raises(InputError, match="graspable_parts"):
        load_objects(tmp_path)
    with pytest.raises(InputError, match="no object called 'spoon'"):
        from_objects("one-source", tools(), Posing(), source="spoon")
    with pytest.raises(InputError, match="unique names"):
        from_objects("one-source", [*tools(), *tools()], Posing())
    with pytest.raises(InputError, match="no target has a source"):
        from_objects("leave-category-out", tools()[:2], Posing())
    with pytest.raises(InputError, match="expected one of"):
        from_objects("paper", tools(), Posing())
