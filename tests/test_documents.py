import json

import pytest

from graft import zoo
from graft.contact import transfer_contact
from graft.documents import object_document, transfer_document
from graft.graph import build_graph
from graft.library import match


@pytest.mark.parametrize("category", ["mug", "kettle", "phone"])
def test_object_documents_are_json_and_complete(category):
    obj = zoo.make(category)
    document = object_document(obj, build_graph(obj, descriptor=None))
    assert json.loads(json.dumps(document, allow_nan=False)) == document
    assert [part["name"] for part in document["parts"]] == list(obj.part_names)
    assert sum(part["graspable"] for part in document["parts"]) == len(obj.graspable)
    assert document["diagonal_metres"] == pytest.approx(document["diagonal"] * obj.scale_to_metres)


def test_transfer_documents_agree_with_the_result():
    result = transfer_contact(match(zoo.demonstration("teapot"), zoo.make("kettle")))
    document = transfer_document(result)
    assert json.loads(json.dumps(document, allow_nan=False)) == document
    assert document["contact"]["point"] == result.contact.point.tolist()
    assert document["source_parts"][result.source_part] == document["demonstrated"]["part"]
    assert document["target_parts"][result.target_part] == document["contact"]["part"]
    assert document["graspable"] == (result.target_part in result.match.target.object.graspable)
