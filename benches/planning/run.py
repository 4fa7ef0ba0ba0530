#!/usr/bin/env python3
"""Times of planning interfaces beside other libraries:  run.py --shared FOLDER [--output docs/planning_benchmarks.md] [--short]

FOLDER has robots/ and scenes/. Needs clearance from a wheel in target/wheels, requirements.txt, cargo, g++, libfcl-dev and libompl-dev.
See README.md beside this file.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
CORE = max(os.sched_getaffinity(0))
STEP = 0.01  # rad, between states of FCL
LIBRARIES = ["-lompl", "-lfcl", "-lccd", "-loctomap", "-loctomath", "-ldl", "-lpthread", "-lm"]


def run(command, cores=None):
    """The output of a program; errors end this one."""
    pin = None if cores is None else (lambda: os.sched_setaffinity(0, cores))
    done = subprocess.run([str(word) for word in command], cwd=ROOT, stdout=subprocess.PIPE, text=True, check=False, preexec_fn=pin)
    if done.returncode != 0:
        sys.exit(f"failed: {' '.join(map(str, command))}")
    return done.stdout


def python(script, *arguments, cores=(CORE,)):
    print(f"{script} {' '.join(map(str, arguments))}", file=sys.stderr)
    return run([sys.executable, HERE / script, *arguments], set(cores))


def built_bench():
    """The program `planning_states`."""
    options = ["--workspace", "--no-run", "--bench", "planning_states", "--message-format=json-render-diagnostics"]
    for line in run(["cargo", "bench", *options]).splitlines():
        message = json.loads(line)
        if message.get("executable") and message["target"]["name"] == "planning_states":
            return message["executable"]
    sys.exit("cargo built no program planning_states")


def built_race(folder):
    """The program `ompl_race`. No -march: Debian's libraries have fixed the alignment of Eigen's types."""
    run(["cargo", "build", "--release", "--workspace", "--lib"])
    headers = ["-isystem", "/usr/include/eigen3", "-isystem", "/usr/include/ompl-1.5", "-I", ROOT / "crates/c/include"]
    program, library = folder / "ompl_race", ROOT / "target/release/libclearance_c.a"
    run(["g++", "-std=c++17", "-O3", "-DNDEBUG", *headers, HERE / "ompl_race.cpp", library, *LIBRARIES, "-o", program])
    return program


def states(shared, is_short):
    """For each contestant, its times by scene."""
    from contestants import CONTESTANTS

    found, every = {}, sorted(os.sched_getaffinity(0))[:2]
    for name in CONTESTANTS:
        count = 1_000_000 if name == "clearance" else 2_000 if is_short else 20_000
        passes = 3 if is_short else 7
        found[name] = json.loads(python("states.py", shared, name, count, passes, cores=every if name == "clearance" else (CORE,)))
    return found


def overhead(shared, folder, bench, is_short):
    """Seconds of 10⁶ states, in Rust and from Python: the fastest of some rounds, in turn."""
    files = python("overhead.py", folder, shared, "make").splitlines()
    best = {}
    for _ in range(1 if is_short else 3):
        of_rust = run([bench, *files], {CORE}).split()
        count, *of_python = python("overhead.py", folder, shared, "measure").split()
        if of_rust[0] != count:
            sys.exit(f"Rust finds {of_rust[0]} states free, Python {count}")
        for name, values in {"rust": of_rust[1:], "python": of_python}.items():
            new = dict(zip(["batch", "threads", "single", "rows"], map(float, values)))
            best[name] = {key: min(value, best.get(name, new)[key]) for key, value in new.items()}
    return best


def races(shared, folder, program, problems_per_scene, seeds):
    """One row for each search of OMPL in C++."""
    import problem_file
    from problems import problems

    files = {}
    for problem in problems(shared, problems_per_scene):
        file = folder / f"problem_{len(files)}.txt"
        problem_file.write(problem, file)
        files[str(file)] = problem.name
    print(f"ompl_race on {len(files)} problems", file=sys.stderr)
    found = []
    for line in run([program, seeds, 60, STEP, *files], {CORE}).splitlines():
        file, validator, *values = line.split()
        seed, is_solved, seconds, edges, count, verdict = map(float, values)
        found.append(dict(problem=files[file], validator=validator, seed=seed, solved=is_solved, cpu=seconds, edges=edges,
                          states=count, verdict=verdict))
    return found


def package():
    """Size of the wheel (bytes) and times of the import (s)."""
    wheels = sorted((ROOT / "target/wheels").glob("clearance-*.whl"), key=lambda file: file.stat().st_mtime)
    if not wheels:
        sys.exit("no wheel: pip wheel --no-deps --wheel-dir target/wheels .")
    code = "import numpy, time; t = time.process_time(); import clearance; print(time.process_time() - t)"
    times = sorted(float(run([sys.executable, "-c", code], {CORE})) for _ in range(21))
    return dict(name=wheels[-1].name, size=wheels[-1].stat().st_size, imported=times[10])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--shared", type=Path, required=True, help="folder with robots/ and scenes/")
    parser.add_argument("--output", type=Path, default=ROOT / "docs/planning_benchmarks.md", help="page that is written")
    parser.add_argument("--problems", type=int, default=100, help="most problems of each scene")
    parser.add_argument("--seeds", type=int, default=5, help="searches of each problem")
    parser.add_argument("--short", action="store_true", help="few problems, to try it out")
    arguments = parser.parse_args()
    sys.path[:0] = [str(HERE), str(HERE.parent / "plans")]
    from page import write

    shared, load = arguments.shared.resolve(), os.getloadavg()[0]
    problems_per_scene, seeds = (1, 1) if arguments.short else (arguments.problems, arguments.seeds)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        bench, program = built_bench(), built_race(folder)
        results = dict(
            package=package(),
            overhead=overhead(shared, folder, bench, arguments.short),
            states=states(shared, arguments.short),
            searches=json.loads(python("searches.py", shared, problems_per_scene, seeds)),
            races=races(shared, folder, program, problems_per_scene, seeds),
        )
    write(arguments.output, results, load)


if __name__ == "__main__":
    main()
