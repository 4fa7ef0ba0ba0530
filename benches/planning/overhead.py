"""CPU time of states from Python, for the comparison with Rust: overhead.py FOLDER SHARED make|measure.

`make` writes the problem and the states for `states.rs`. `measure` prints three numbers (s): a batch on one thread, on two threads, and
one call a state; the fastest of some passes.
"""

import json
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "plans")]

import numpy as np

from problems import problems

PASSES = 5
SCENE = "bookshelf_small"


def make(folder, problem, states):
    """The world as a MoveIt planning scene, the states with all joints."""
    objects = []
    for obstacle in problem.obstacles:
        shape, pose = obstacle["shape"], obstacle["pose"]
        sizes = shape["size"] if shape["type"] == "box" else [shape["length"], shape["radius"]]
        primitive = {"type": shape["type"], "dimensions": sizes}
        placed = {"position": pose["xyz"], "orientation": pose["quat_xyzw"]}
        header = {"frame_id": problem.checker.robot.root_link}
        objects.append({"id": obstacle["name"], "header": header, "primitives": [primitive], "primitive_poses": [placed]})
    scene = {"name": "world", "robot_model_name": "panda", "world": {"collision_objects": objects}}
    (folder / "world.yaml").write_text(json.dumps(scene))
    problem.checker.expand(states).tofile(folder / "states.f64")
    print(problem.urdf, problem.srdf, problem.packages, folder / "world.yaml", folder / "states.f64", sep="\n")


def fastest(run):
    times = []
    for _ in range(PASSES):
        begin = time.process_time()
        run()
        times.append(time.process_time() - begin)
    return min(times)


def measure(checker, states):
    rows, is_free = list(states), checker.is_free

    def one_by_one():
        for q in rows:
            is_free(q)

    print(int(is_free(states).sum()))
    print(fastest(lambda: is_free(states, num_threads=1)), fastest(lambda: is_free(states, num_threads=2)), fastest(one_by_one))


def main():
    folder, shared, what = Path(sys.argv[1]), Path(sys.argv[2]), sys.argv[3]
    problem = next(problem for problem in problems(shared, 1) if problem.scene == SCENE)
    lower, upper = problem.checker.lower, problem.checker.upper
    states = np.random.default_rng(1).uniform(lower, upper, (1_000_000, len(lower)))
    if what == "make":
        make(folder, problem, states)
    else:
        measure(problem.checker, states)


if __name__ == "__main__":
    main()
