"""Running an evaluation: the same rows on any number of workers, resuming after a kill, refusing other rows."""

import json
from dataclasses import dataclass, field

import numpy as np
import pytest
from evaluation_shapes import tools

from graft.errors import InputError
from graft.evaluate.affordance import methods, pictured, worst
from graft.evaluate.baselines import RandomPart
from graft.evaluate.methods import Graft, Graphs, Prediction
from graft.evaluate.protocols import Posing, from_objects
from graft.evaluate.runner import build_graphs, evaluate
from graft.library import Library
from graft.transport import UFGW


@pytest.fixture(scope="module")
def benchmark():
    return from_objects("leave-category-out", tools(), Posing(seed=3))


@pytest.fixture(scope="module")
def rows(benchmark):
    return evaluate(benchmark, methods(), k=2)


def test_every_method_answers_every_query(benchmark, rows):
    names = [method.name for method in methods()]
    assert [(row.query, row.method) for row in rows] == [(q.key, n) for q in benchmark.queries for n in names]
    for row in rows:
        assert len(row.answers) == (32 if row.exchangeable else 2)
        assert all(answer.source is None for answer in row.answers) == row.exchangeable
        assert all(answer.source_category != row.category for answer in row.answers)
        assert all(np.isfinite([*a.point, a.nss, a.distance]).all() for a in row.answers)
        assert all(answer.distance == 0 for answer in row.answers if answer.inside)
        # Parts are as drawn; a point on the seam, of either part, is inside.
        assert all(answer.inside for answer in row.answers if answer.right)


def test_graft_is_the_library(benchmark, rows):
    # The runner reuses graphs; what it finds is what `Library.retrieve` finds.
    library = Library()
    library.extend(source.demonstration for source in benchmark.sources)
    for query in benchmark.queries:
        allowed = {benchmark.sources[i].demonstration.name for i in query.sources}
        target = benchmark.subjects[query.target].object
        expected = [m.demonstration.name for m in library.retrieve(target, 2, where=lambda d, a=allowed: d.name in a)]
        row = next(row for row in rows if row.query == query.key and row.method == "graft")
        assert [answer.source for answer in row.answers] == expected


@pytest.mark.slow
def test_workers_do_not_change_the_rows(benchmark, rows, tmp_path):
    assert evaluate(benchmark, methods(), k=2, workers=2, out=tmp_path / "two") == rows
    assert evaluate(benchmark, methods(), k=2, workers=1, out=tmp_path / "one") == rows
    two, one = ((tmp_path / name / "rows.jsonl").read_bytes() for name in ("two", "one"))
    assert two == one


@dataclass(frozen=True)
class Counting:
    """Answers with the origin and counts how often it was asked."""

    asked: list = field(default_factory=list, repr=False)
    name: str = "counting"
    graphs: Graphs = field(default_factory=Graphs)
    exchangeable: bool = False

    def fit(self, benchmark, graphs):
        return self

    def predict(self, query, k, rng):
        self.asked.append(query.key)
        return [Prediction(rng.random(3), 0)]


def test_a_killed_run_goes_on(benchmark, tmp_path):
    path = tmp_path / "rows.jsonl"
    whole = evaluate(benchmark, [Counting()], out=tmp_path)
    text = path.read_bytes()
    # Killed while the third query was written: its line has no end.
    lines = text.split(b"\n")
    path.write_bytes(b"\n".join(lines[:3]) + b"\n" + lines[3][:37])
    method = Counting()
    assert evaluate(benchmark, [method], out=tmp_path) == whole
    assert method.asked == ["paddle_a", "paddle_b"]
    assert path.read_bytes() == text
    # All there: nothing is asked again.
    method.asked.clear()
    assert evaluate(benchmark, [method], out=tmp_path) == whole
    assert method.asked == []


def test_killed_within_the_header(benchmark, tmp_path):
    (tmp_path / "rows.jsonl").write_bytes(b'{"graft": "0.')
    method = Counting()
    evaluate(benchmark, [method], out=tmp_path)
    assert len(method.asked) == 4


@pytest.mark.parametrize(("k", "seed", "culprit"), [(3, 3, "k"), (2, 4, "posing")])
def test_rows_of_other_settings_are_refused(benchmark, tmp_path, k, seed, culprit):
    evaluate(benchmark, [Counting()], k=2, out=tmp_path)
    other = from_objects("leave-category-out", tools(), Posing(seed=seed))
    with pytest.raises(InputError, match=rf"rows\.jsonl: rows made with another {culprit};"):
        evaluate(other, [Counting()], k=k, out=tmp_path)


def test_other_parameters_of_a_method_are_refused(benchmark, tmp_path):
    evaluate(benchmark, [Graft()], out=tmp_path)
    with pytest.raises(InputError, match="another parameters"):
        evaluate(benchmark, [Graft(solver=UFGW(alpha=0.3))], out=tmp_path)


@pytest.mark.parametrize("line", [b"nonsense", b"[]", b'{"rows": [{}]}', b'{"rows": []}', b'{"rows": 3}'])
def test_a_spoiled_file_is_named(benchmark, tmp_path, line):
    evaluate(benchmark, [Counting()], out=tmp_path)
    path = tmp_path / "rows.jsonl"
    path.write_bytes(path.read_bytes() + line + b"\n")
    with pytest.raises(InputError, match=r"rows\.jsonl: line 6"):
        evaluate(benchmark, [Counting()], out=tmp_path)


def test_bad_arguments_are_named(benchmark):
    with pytest.raises(InputError, match="unique names"):
        evaluate(benchmark, [RandomPart(), RandomPart()])
    with pytest.raises(InputError, match="workers: expected at least 1"):
        evaluate(benchmark, [RandomPart()], workers=0)


def test_worst_are_outside_then_weak(benchmark, rows):
    mine = [row for row in rows if row.method == "functional map"]
    bad = worst(mine, 10)
    assert len(bad) == len(mine)
    keys = [(-row.answers[0].distance, row.answers[0].nss) for row in bad]
    assert keys == sorted(keys)
    # Rows are lines of JSON: they come back as they were.
    json.dumps([row.answers[0].point for row in bad], allow_nan=False)


def test_pictures_show_what_the_rows_say(benchmark, rows):
    mine = worst([row for row in rows if row.method == "graft"], 2)
    (graphs,) = build_graphs(benchmark, [Graphs()], workers=2)
    transfers = pictured(benchmark, Graft().fit(benchmark, graphs), mine)
    for row, transfer in zip(mine, transfers, strict=True):
        assert transfer.match.target.object.name == row.target
        assert transfer.match.demonstration.name == row.answers[0].source
        np.testing.assert_allclose(transfer.contact.point, row.answers[0].point, rtol=1e-6, atol=1e-8)
