"""Strips and films of a trial."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from sim_scenes import box, grasp

from graft.errors import InputError
from graft.sim import PreparedObject, SimulationConfig, Trial, prepare, simulate_grasp
from graft.sim.pictures import save_trial, trial_panels, view_trial

SIZE = 96


@pytest.fixture(scope="module")
def block() -> PreparedObject:
    return prepare(box(0.05, 0.05, 0.1))


@pytest.fixture(scope="module")
def trial(block: PreparedObject) -> Trial:
    found = simulate_grasp(block, grasp((0, 0, 0.08)), SimulationConfig(hold_time=0.1))
    try:
        trial_panels(block, found, size=SIZE)
    except InputError as error:
        pytest.skip(str(error))
    return found


def test_a_strip_shows_the_object_before_and_lifted(block: PreparedObject, trial: Trial) -> None:
    panels = trial_panels(block, trial, size=SIZE)
    assert [panel.shape for panel in panels] == [(SIZE, SIZE, 3)] * 3
    blue = [(panel[..., 2].astype(int) - panel[..., 0] > 15) for panel in panels]
    rows = [float(np.argwhere(mask)[:, 0].mean()) for mask in blue]
    assert rows[1] == pytest.approx(rows[0], abs=2)
    assert rows[2] < rows[0] - 0.15 * SIZE


def test_files(block: PreparedObject, trial: Trial, tmp_path: Path) -> None:
    Image = pytest.importorskip("PIL.Image")
    av = pytest.importorskip("av")
    save_trial(tmp_path / "trial.png", block, trial, size=SIZE)
    with Image.open(tmp_path / "trial.png") as picture:
        assert picture.size == (3 * SIZE, SIZE)
    save_trial(tmp_path / "trial.mp4", block, trial, size=SIZE)
    with av.open(str(tmp_path / "trial.mp4")) as film:
        frames = sum(1 for _ in film.decode(video=0))
    seconds = trial.steps * trial.config.timestep
    assert frames == pytest.approx(30 * seconds, abs=3)


def test_what_cannot_be_drawn_is_said(
    block: PreparedObject, trial: Trial, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(InputError, match=r"ending in .png or .mp4"):
        save_trial(tmp_path / "trial.gif", block, trial)
    with pytest.raises(InputError, match="even number"):
        save_trial(tmp_path / "trial.png", block, trial, size=97)
    with pytest.raises(InputError, match="it has no grasp to show"):
        save_trial(tmp_path / "trial.png", block, Trial.no_grasp("wardrobe", "too wide"))
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(InputError, match="needs a display"):
        view_trial(block, trial)
