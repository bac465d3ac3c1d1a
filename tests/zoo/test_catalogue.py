"""Names, errors, seeds and demonstrations of the parametric objects."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import time

import numpy as np
import pytest
from mesh_measures import point_to_part, winding_numbers

from graft import zoo
from graft.errors import InputError
from graft.objects import PartObject

DIGESTS = """
import hashlib
from graft import zoo
for category in zoo.categories():
    h = hashlib.sha256()
    for part in zoo.make(category, 7).parts:
        h.update(part.vertices.tobytes() + part.faces.tobytes())
    print(category, h.hexdigest())
"""


def digest(obj: PartObject) -> str:
    h = hashlib.sha256()
    for part in obj.parts:
        h.update(part.vertices.tobytes() + part.faces.tobytes())
    return h.hexdigest()


def test_groups_share_nothing_and_make_up_the_whole() -> None:
    assert zoo.demonstrated() == ("water_bucket", "teapot", "wine_bottle", "mug")
    assert len(zoo.unseen()) == 8
    assert zoo.categories() == zoo.demonstrated() + zoo.unseen() + zoo.more()
    assert len(set(zoo.categories())) == 22


@pytest.mark.parametrize("category", zoo.categories())
def test_demonstrated_contact_lies_on_the_part_that_a_person_takes(category: str) -> None:
    for seed in range(12):
        shown = zoo.demonstration(category, seed)
        contact, obj = shown.contact, shown.object
        part = obj.parts[contact.part]
        assert contact.part in obj.graspable
        assert point_to_part(contact.point, part) < 1e-9
        inner, outer = winding_numbers(contact.point + 1e-5 * np.array([[-1.0], [1.0]]) * contact.normal, part)
        assert inner > 0.9
        assert outer < 0.1
        assert contact.approach is not None
        assert contact.approach @ contact.normal < -0.85
        assert shown.metadata["task"]


@pytest.mark.parametrize("category", zoo.categories())
def test_demonstrated_contact_is_not_covered_by_another_part(category: str) -> None:
    for seed in range(12):
        shown = zoo.demonstration(category, seed)
        before = (shown.contact.point + 1e-4 * shown.contact.normal)[None]
        for index, part in enumerate(shown.object.parts):
            if index != shown.contact.part:
                assert winding_numbers(before, part)[0] < 0.5, (seed, part.name)


@pytest.mark.parametrize("category", zoo.categories())
def test_seeds_give_other_variants_and_the_same_seed_the_same(category: str) -> None:
    variants = [zoo.make(category, seed) for seed in range(6)]
    assert len({digest(v) for v in variants}) == 6
    sizes = np.array([np.ptp(v.bounds, axis=0) for v in variants])
    assert (sizes.std(axis=0) / sizes.mean(axis=0)).max() > 0.03
    assert digest(zoo.make(category, 3)) == digest(variants[3])
    assert digest(zoo.demonstration(category, 3).object) == digest(variants[3])


@pytest.mark.parametrize("category", ["water_bucket", "teapot", "kettle", "watering_can", "basket", "handbag"])
def test_handles_change_their_place_or_number(category: str) -> None:
    places = set()
    for seed in range(16):
        shown = zoo.demonstration(category, seed)
        places.add((tuple(np.round(shown.contact.normal).astype(int)), shown.object.part_names))
    assert len(places) >= 2


def test_other_processes_make_the_same_objects() -> None:
    outputs = []
    for hash_seed in ("1", "2"):
        environment = os.environ | {"PYTHONHASHSEED": hash_seed, "PYTHONPATH": os.pathsep.join(sys.path)}
        outputs.append(
            subprocess.run([sys.executable, "-c", DIGESTS], env=environment, capture_output=True, check=True)
        )
    assert outputs[0].stdout == outputs[1].stdout
    here = {category: digest(zoo.make(category, 7)) for category in zoo.categories()}
    assert dict(line.split() for line in outputs[0].stdout.decode().splitlines()) == here


def test_a_variant_takes_less_than_50_ms() -> None:
    for category in zoo.categories():
        best = np.inf
        for _ in range(5):
            start = time.perf_counter()
            zoo.make(category, 1)
            best = min(best, time.perf_counter() - start)
        assert best < 0.05, category


def test_unknown_category_is_named_with_the_nearest() -> None:
    with pytest.raises(InputError, match=r"got 'teapott'; did you mean 'teapot'\?"):
        zoo.make("teapott")
    with pytest.raises(InputError, match="did you mean 'water_bucket'"):
        zoo.demonstration("Water Bucket")
    with pytest.raises(InputError, match="expected one of water_bucket, teapot"):
        zoo.make("xyz")


@pytest.mark.parametrize("seed", [-1, 1.5, "0", True, None])
def test_bad_seed_is_refused(seed: object) -> None:
    with pytest.raises(InputError, match="seed: expected a whole number"):
        zoo.make("mug", seed)  # type: ignore[arg-type]
