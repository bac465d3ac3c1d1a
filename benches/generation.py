"""Print how many attempts a second generation makes, where an attempt's time goes, and what memory it needs.

    python benches/generation.py [--n 64] [--workers 2]

The zoo's four demonstrated categories, by script, for its eight unseen ones; state-only, episodes written. The start of
the processes and the preparation of objects are in, the demonstrations are not.
"""

import argparse
import os
import resource
import tempfile
import time
from collections import defaultdict
from pathlib import Path

from graft import zoo
from graft.datagen import attempt as attempts
from graft.datagen.attempt import Target, run_attempt
from graft.datagen.config import GenerationConfig
from graft.datagen.generate import generate
from graft.datagen.selection import replayable
from graft.datagen.writers.robomimic import write_part
from graft.evaluate.generation import zoo_library
from graft.grasp import PANDA_HAND


def main():
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--n", type=int, default=64)
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    print(f"load average {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    library, objects = zoo_library(0), [zoo.make(category) for category in zoo.unseen()]
    _stages(library, objects)
    memory = []

    def told(tally):
        if tally.fresh in (arguments.n // 4, arguments.n):
            memory.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)

    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        tally = generate(library, objects, folder, n=arguments.n, workers=arguments.workers, progress=told)
        seconds = time.perf_counter() - start
        size = sum(entry.stat().st_size for entry in os.scandir(folder)) / 1e6
    workers = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    pace = tally.done / seconds
    print(
        f"{tally.done} attempts, {tally.kept} kept, {arguments.workers} workers: {seconds:.1f} s, {pace:.2f} a second "
        f"(10,000 in {10_000 / pace / 60:.0f} minutes), {size / max(tally.kept, 1):.2f} MB an episode"
    )
    print(f"memory, MB: {memory[0]:.0f} after a quarter, {memory[-1]:.0f} at the end; the largest worker {workers:.0f}")


def _stages(library, objects):
    """Print the milliseconds of an attempt's stages: of each object's second, the first prepares."""
    spent, planner, config = defaultdict(float), attempts.plan_reach, GenerationConfig()

    def timed(*arguments):
        start = time.perf_counter()
        found = planner(*arguments)
        spent["planning"] += time.perf_counter() - start
        return found

    sources = replayable(library, config.task)
    with tempfile.TemporaryDirectory() as folder:
        for obj in objects:
            start = time.perf_counter()
            target = Target.lay(obj, library, sources, config.physics)
            first = run_attempt(target, PANDA_HAND, config, run=0, number=0)
            spent["preparing"] += time.perf_counter() - start
            attempts.plan_reach = timed
            made = run_attempt(target, PANDA_HAND, config, run=0, number=1)
            attempts.plan_reach = planner
            spent["attempt"] += made.seconds
            spent["actions"] += made.steps / 1e3
            for number, episode in enumerate(e for e in (first.episode, made.episode) if e is not None):
                start = time.perf_counter()
                write_part(Path(folder) / f"demo_{number}.hdf5", episode)
                spent["writing"] += (time.perf_counter() - start) / 2
    each = {name: 1e3 * value / len(objects) for name, value in spent.items()}
    print(
        f"milliseconds: attempt {each['attempt']:.0f}, of it planning {each['planning']:.0f}; writing an episode "
        f"{each['writing']:.0f}; an object with its first attempt {each['preparing']:.0f}; "
        f"{each['actions']:.0f} actions an attempt"
    )


if __name__ == "__main__":
    main()
