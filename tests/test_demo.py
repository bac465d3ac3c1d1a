import json

import pytest

from graft import zoo
from graft.demo import demo_document, run_demo, transfer_all
from graft.library import Library


def test_rows_say_whether_the_contact_is_in_the_mask():
    library = Library()
    library.extend(zoo.demonstration(category) for category in ("mug", "teapot"))
    targets = [zoo.make("kettle"), zoo.make("mug", 5)]
    rows = transfer_all(library, targets)
    document = demo_document(rows, seed=0)
    assert document["targets"] == 2
    assert document["in_mask"] == sum(
        r.transferred.target_part in t.graspable for r, t in zip(rows, targets, strict=True)
    )
    assert document["other_category"] == sum(not r.same_category for r in rows) < 2
    assert json.loads(json.dumps(document, allow_nan=False)) == document


@pytest.mark.slow
def test_the_demo_writes_everything_and_most_contacts_land(tmp_path):
    rows, written = run_demo(tmp_path / "out")
    for path in written.values():
        assert path.exists(), path
    inside = sum(row.in_mask for row in rows) / len(rows)
    assert inside >= 0.8, [r.transferred.match.target.object.name for r in rows if not r.in_mask]
    document = json.loads(written["results"].read_text())
    assert document["targets"] == len(rows) == len(document["results"])
    again = Library.open(written["library"])
    assert len(again) == len(zoo.demonstrated()) + len(zoo.ycb_names()[::2])
