"""Time of state checks with one contestant: states.py SHARED CONTESTANT COUNT PASSES. Prints JSON, scene by scene."""

import json
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "plans")]

import numpy as np

from contestants import CONTESTANTS
from problems import problems

SCENES = ["bookshelf_small", "box", "cage", "table_pick"]


def states_of(checker, count):
    return np.random.default_rng(1).uniform(checker.lower, checker.upper, (count, len(checker.lower)))


def main():
    shared, name, count, passes = Path(sys.argv[1]), sys.argv[2], int(sys.argv[3]), int(sys.argv[4])
    found = {}
    for problem in problems(shared, 1):
        if problem.scene not in SCENES:
            continue
        contestant, states = CONTESTANTS[name](problem), states_of(problem.checker, count)
        contestant.check(states[:100])
        cpu, wall = [], []
        for _ in range(passes):
            begins = time.process_time(), time.perf_counter()
            free = contestant.check(states)
            cpu.append(time.process_time() - begins[0])
            wall.append(time.perf_counter() - begins[1])
        compared = slice(0, min(count, 20_000))
        expected = problem.checker.is_free(states[compared])
        differ = int((np.asarray(free)[compared] != expected).sum())
        found[problem.scene] = dict(
            count=count, cpu=1e6 * min(cpu) / count, cpu_median=1e6 * float(np.median(cpu)) / count, wall=1e6 * min(wall) / count,
            differ=differ, compared=len(expected), free=float(np.mean(free)),
        )
    print(json.dumps(found))


if __name__ == "__main__":
    main()
