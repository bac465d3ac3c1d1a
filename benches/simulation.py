"""Print how many trials an hour the physics makes, and where a trial's time goes.

    python benches/simulation.py [--trials 40] [--workers 2]

Zoo objects, prepared; the best planned grasp near the demonstrated contact of each, in random poses. Everything that a
trial costs is in: the pool's start is not.
"""

import argparse
import os
import statistics
import time

from graft import zoo
from graft.grasp import PANDA_HAND
from graft.grasp.planner import plan_grasps
from graft.sim import Job, Outcome, prepare, random_poses, simulate_grasp, simulate_grasps
from graft.sim.pictures import trial_panels

CATEGORIES = ("mug", "teapot", "wine_bottle", "water_bucket", "kettle", "spray", "handbag", "remote")


def main():
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=40, help="per object")
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    print(f"load average {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    jobs, total = [], 0.0
    print(
        f"{'object':<14}{'pieces':>7}{'prepare s':>11}{'trial ms':>10}{'CPU ms':>8}{'steps/CPU s':>12}"
        f"{'drawn ms':>10}  outcome"
    )
    for category in CATEGORIES:
        shown = zoo.demonstration(category, 1)
        start = time.perf_counter()
        prepared = prepare(shown.object)
        ready = time.perf_counter() - start
        grasp = plan_grasps(prepared.object, shown.contact, PANDA_HAND, support=prepared.support, k=1, seed=0)[0]
        simulate_grasp(prepared, grasp)
        start = time.process_time()
        trials = [simulate_grasp(prepared, grasp, pose=pose) for pose in random_poses(prepared, 5, 0)]
        used = (time.process_time() - start) / len(trials)
        total += used
        seconds = statistics.median(trial.wall_seconds for trial in trials)
        rate = sum(trial.steps for trial in trials) / (used * len(trials))
        start = time.perf_counter()
        trial_panels(prepared, trials[0])
        drawn = time.perf_counter() - start
        print(
            f"{category:<14}{len(prepared.body.pieces):>7}{ready:>11.2f}{1e3 * seconds:>10.1f}{1e3 * used:>8.1f}"
            f"{rate:>12.0f}{1e3 * drawn:>10.0f}  {trials[0].outcome.value}"
        )
        poses = random_poses(prepared, arguments.trials, 1)
        jobs += [Job(f"{category}/{i}", prepared, grasp, pose=pose) for i, pose in enumerate(poses)]
    mean = total / len(CATEGORIES)
    print(f"mean {1e3 * mean:.1f} ms of CPU a trial: {3600 / mean:,.0f} an hour and core")
    first = []
    trials = simulate_grasps(jobs, workers=arguments.workers, progress=lambda *_: first.append(time.perf_counter()))
    # The first call comes before the pool starts, the second with the first trial.
    took = first[-1] - first[1]
    print(
        f"{len(jobs)} trials, {arguments.workers} workers: {took:.1f} s, {3600 * (len(jobs) - 1) / took:,.0f} an hour "
        f"({sum(trial.outcome is Outcome.SUCCESS for trial in trials)} succeeded)"
    )


if __name__ == "__main__":
    main()
