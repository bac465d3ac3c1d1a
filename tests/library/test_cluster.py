"""Work spread over processes and over a Ray cluster gives what one process gives, and survives killed workers."""

import os
from dataclasses import dataclass
from pathlib import Path

import pytest
from library_workers import die_once, kill_itself, refuse
from test_disk import answers

from graft.errors import GraftError, InputError, MissingExtraError
from graft.library import Filter, Library, LocalExecutor, RayExecutor
from graft.library.executors import Lost
from graft.library.shards import shards


@dataclass(frozen=True)
class Here:
    """Runs tasks in this process."""

    workers: int = 3
    loses: int | None = None

    def map(self, work, tasks):
        for number, task in enumerate(tasks):
            yield Lost("it died") if number == self.loses else work(task)


def test_a_sharded_search_answers_as_one(made, targets):
    here = Library.open(made)
    for workers in (1, 2, 3, 8):
        sharded = Library.open(made, executor=Here(workers))
        for target in targets:
            assert answers(sharded, target) == answers(here, target)
            only = Filter(tags=("kitchen",))
            assert answers(sharded, target, only=only) == answers(here, target, only=only)
            assert answers(sharded, target, max_cost=0.3) == answers(here, target, max_cost=0.3)
    with pytest.raises(GraftError, match="it died"):
        answers(Library.open(made, executor=Here(2, loses=1)), targets[0])


def test_shards_are_every_segment_once(made):
    snapshot = Library.open(made).snapshot
    for count in range(1, 9):
        found = shards(snapshot, count)
        assert len(found) <= count
        assert [i for first, end in found for i in range(first, end)] == [0, 1, 2, 3]


def test_a_killed_process_loses_only_the_task_that_killed_it():
    tasks = ["a", "b", "die", "c", "d", "e", "die", "f"]
    found = list(LocalExecutor(2).map(kill_itself, tasks))
    assert [None if isinstance(x, Lost) else x for x in found] == ["aa", "bb", None, "cc", "dd", "ee", None, "ff"]


def test_a_task_whose_neighbour_died_is_run_again(tmp_path):
    tasks = [(number, str(tmp_path)) for number in range(12)]
    assert list(LocalExecutor(2).map(die_once, tasks)) == list(range(12))


def test_errors_of_tasks_reach_the_caller():
    with pytest.raises(InputError, match="no: nothing"):
        list(LocalExecutor(1).map(refuse, ["nothing"]))
    with pytest.raises(InputError, match="workers: expected at least 1"):
        LocalExecutor(0)


def test_ray_that_is_not_installed_is_named(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "ray", None)
    with pytest.raises(MissingExtraError, match=r"graft-robotics\[ray\]"):
        list(RayExecutor().map(die_once, []))


@pytest.fixture(scope="module")
def cluster():
    """A Ray cluster of two nodes on this machine."""
    ray = pytest.importorskip("ray")
    utilities = pytest.importorskip("ray.cluster_utils")
    # Workers import what the tests hand them.
    patched = pytest.MonkeyPatch()
    patched.setenv("PYTHONPATH", os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")]))
    cluster = utilities.Cluster(initialize_head=True, head_node_args={"num_cpus": 1, "include_dashboard": False})
    cluster.add_node(num_cpus=1)
    ray.init(address=cluster.address, log_to_driver=False, logging_level="error")
    yield cluster
    ray.shutdown()
    cluster.shutdown()
    patched.undo()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_ray_cluster_answers_as_one_process_while_workers_and_a_node_die(cluster, made, targets, tmp_path):
    executor = RayExecutor()
    assert executor.workers == 2
    tasks = [(number, str(tmp_path)) for number in range(12)]
    assert list(executor.map(die_once, tasks)) == list(range(12))
    with pytest.raises(InputError, match="no: nothing"):
        list(executor.map(refuse, ["nothing"]))
    lost = list(executor.map(kill_itself, ["a", "die", "b"]))
    assert isinstance(lost[1], Lost)
    assert (lost[0], lost[2]) == ("aa", "bb")
    here, there = Library.open(made), Library.open(made, executor=executor)
    for target in targets:
        assert answers(there, target) == answers(here, target)
    asked = executor.map(die_once, [(number, str(tmp_path)) for number in range(20, 40)])
    first = next(asked)
    cluster.remove_node(next(node for node in cluster.list_all_nodes() if node != cluster.head_node))
    assert [first, *asked] == list(range(20, 40))
    for target in targets:
        assert answers(there, target) == answers(here, target)
