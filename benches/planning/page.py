"""Writes the results page of the planning benchmark: tables of times, ratios and requirements."""

import datetime
import importlib.metadata
import os
import platform
import statistics
import subprocess
import textwrap
from collections import Counter
from math import exp, log

VERSIONS = ["numpy", "pin", "coal", "drake", "roboplan", "vamp-planner"]
OWN = "clearance"

TEXT = """# Benchmarks of planning interfaces

For engineers who compare planning from Python and C++ with other libraries.

Written by `python3 benches/planning/run.py --shared ../shared`; do not edit. `benches/planning/README.md` says how to
run it, and what is compared. Compare ratios, and only within this page.

- Machine: {machine}; load {load}.
- Date: {date}. Versions: {versions}.
- CPU time of the process, pinned to one core; only the batch of `clearance` has two. Load changes wall times, but ratios
  of CPU times little.
- Panda with its collision meshes, 7 joints, between boxes and cylinders of MotionBenchMaker.

## Required

{required}

## States from Python

{count} uniformly random states in one call for `clearance`, {peer_count} in a loop for the others, which have no batch
for arrays of states in one thread. µs of CPU time a state, the fastest of some passes.

{states}

"Differ" compares with `clearance`. Drake has the convex hulls of meshes, VAMP 59 spheres and capsules for cylinders,
in single precision. On two cores, `clearance` needed {wall} µs a state of wall time.

## Python beside Rust

The same 10⁶ states in both languages, on one thread; 10⁶ calls of one state each. Python validates the positions in a
call, and Rust has validated states, except in the second row.

{overhead}

## OMPL in C++

RRT-Connect of OMPL 1.5 with its default settings, without simplification, the same seeds. FCL checks states at most
0.01 rad apart, as MoveIt does: an OBBRSS tree for each mesh, dynamic AABB trees for robot and world. `clearance` proves
motions. Times are the search alone, of {problems} problems with {seeds} seeds.

{races}

{trees}

## RRT-Connect of this library and of VAMP

Searches on the same problems, with the fingers of VAMP's Panda. VAMP samples its motions 32 times a rad and takes
spheres for the robot; the paths of `clearance` are proven for its meshes. Refuted paths have a colliding state: Coal and
Pinocchio find it, or `check_trajectory`.

{searches}

{alone}

## Package

The wheel `{wheel}` has {size} MB. `import clearance`, after NumPy, takes {imported} ms of CPU time (median of 21).
"""


def table(head, rows):
    first, *others = ("| " + " | ".join(map(str, line)) + " |" for line in [head, *rows])
    return "\n".join([first, "|---|" + "---:|" * (len(head) - 1), *others])


def mean(values):
    """Geometric mean."""
    return exp(statistics.fmean(map(log, values)))


def machine():
    info = dict(line.split(":", 1) for line in open("/proc/cpuinfo").read().split("\n\n")[0].splitlines() if ":" in line)
    named = {key.strip(): value.strip() for key, value in info.items()}
    return f"{named.get('model name', platform.machine())}, {os.cpu_count()} cores"


def versions():
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=False).stdout.strip()
    wheels = [f"{name} {importlib.metadata.version(name)}" for name in VERSIONS]
    debian = [f"{name} {debian_version(name)}" for name in ("libompl-dev", "libfcl-dev")]
    return ", ".join([f"clearance {commit}", f"Python {platform.python_version()}", *wheels, *debian])


def debian_version(package):
    shown = subprocess.run(["dpkg-query", "-W", "-f", "${Version}", package], capture_output=True, text=True, check=False)
    return shown.stdout or "unknown"


def state_rows(states):
    rows = []
    for name, scenes in states.items():
        row = [name]
        for scene, times in scenes.items():
            ratio = times["cpu"] / states[OWN][scene]["cpu"]
            row.append(f"{times['cpu']:.2f}" + ("" if name == OWN else f" ({ratio:.1f}x)"))
        differ, compared = (sum(times[key] for times in scenes.values()) for key in ("differ", "compared"))
        rows.append([*row, f"{100 * differ / compared:.2f} %"])
    return rows


def state_ratios(states, name):
    return [times["cpu"] / states[OWN][scene]["cpu"] for scene, times in states[name].items()]


def by_validator(races):
    own = {(row["problem"], row["seed"]): row for row in races if row["validator"] == OWN}
    fcl = {(row["problem"], row["seed"]): row for row in races if row["validator"] == "FCL"}
    return own, fcl


def race_rows(races):
    rows = []
    for name, found in zip(("`clearance`, proven", "FCL, 0.01 rad"), by_validator(races)):
        times = [row["cpu"] for row in found.values()]
        verdicts = Counter(row["verdict"] for row in found.values())
        solved = f"{sum(row['solved'] > 0 for row in found.values())} of {len(found)}"
        rows.append([name, milliseconds(statistics.median(times)), milliseconds(max(times)), solved, int(verdicts[0]), int(verdicts[-1])])
    return rows


def milliseconds(seconds):
    return f"{1e3 * seconds:.3g}"


def search_groups(searches):
    """Searches by planner, on the problems that VAMP has."""
    of_vamp = {row["problem"] for row in searches if row["planner"] == "VAMP"}
    names = dict.fromkeys(row["planner"] for row in searches)
    return {name: [row for row in searches if row["planner"] == name and row["problem"] in of_vamp] for name in names}


def search_rows(groups):
    rows = []
    for name, found in groups.items():
        outcomes = Counter(row["outcome"] for row in found)
        solved = [row for row in found if row["outcome"] != "none"]
        times = statistics.median(row["cpu"] for row in found), max(row["cpu"] for row in found)
        wall, length = statistics.median(row["wall"] for row in found), statistics.median(row["length"] for row in solved)
        rows.append([name, *map(milliseconds, (*times, wall)), f"{length:.2f}", f"{len(solved)} of {len(found)}",
                     outcomes["refuted"], outcomes["undecided"]])
    return rows


def reached(value, least, aim, is_more=True):
    """`aim`, `at least` or **no**."""
    is_at = (lambda limit: value >= limit) if is_more else (lambda limit: value <= limit)
    return "aim" if is_at(aim) else "at least" if is_at(least) else "**no**"


def required_rows(results):
    overhead, states, races = results["overhead"], results["states"], results["races"]
    single = overhead["python"]["single"] - overhead["rust"]["single"]
    batch = 100 * (overhead["python"]["batch"] / overhead["rust"]["batch"] - 1)
    rows = [
        ["Python overhead of one state", "1 µs", "0.3 µs", f"{single:.2f} µs", reached(single, 1, 0.3, False)],
        ["Python overhead of 10⁶ states in one call", "2 %", "0 %", f"{batch:.1f} %", reached(batch, 2, 0, False)],
    ]
    for name, least, aim in (("Pinocchio + Coal", 20, 100), ("Drake", 20, 100), ("roboplan", 10, 30), ("VAMP (spheres)", 0.5, 1)):
        ratios = state_ratios(states, name)
        value = f"{mean(ratios):.1f}x in the mean, {min(ratios):.1f}x at worst"
        rows.append([f"10⁶ states from Python against {name}", f"{least}x", f"{aim}x", value, reached(min(ratios), least, aim)])
    own, fcl = (statistics.median(row["cpu"] for row in found.values()) for found in by_validator(races))
    rows.append(["OMPL RRT-Connect in C++ against FCL, median time", "20x", "100x", f"{fcl / own:.1f}x", reached(fcl / own, 20, 100)])
    groups = search_groups(results["searches"])
    own, vamp = (statistics.median(row["cpu"] for row in groups[name]) for name in (OWN, "VAMP"))
    rows.append(["Own RRT-Connect, time of VAMP's", "10x", "2x", f"{own / vamp:.2f}x", reached(own / vamp, 10, 2, False)])
    mine = [row for row in results["searches"] if row["planner"].startswith(OWN)]
    missed, refuted = (sum(row["outcome"] == outcome for row in mine) for outcome in ("none", "refuted"))
    solved = f"{len(mine) - missed} of {len(mine)} searches, {refuted} refuted"
    rows.append(["Solvable problems solved, plans refuted", "all, 0", "", solved, "at least" if missed + refuted == 0 else "**no**"])
    size, imported = results["package"]["size"] / 1e6, 1e3 * results["package"]["imported"]
    rows.append(["Size of the wheel", "15 MB", "8 MB", f"{size:.1f} MB", reached(size, 15, 8, False)])
    rows.append(["Time of the import", "50 ms", "20 ms", f"{imported:.0f} ms", reached(imported, 50, 20, False)])
    return rows


def overhead_rows(overhead):
    rows = []
    kinds = (
        ("batch", "batch", "10⁶ states in one call"),
        ("rows", "batch", "10⁶ states in one call, Rust validates them, too"),
        ("single", "single", "one state a call"),
    )
    for of_rust, of_python, title in kinds:
        rust, python = overhead["rust"][of_rust], overhead["python"][of_python]
        rows.append([title, f"{rust:.3f}", f"{python:.3f}", f"{1e3 * (python - rust):+.0f} ns", f"{100 * (python / rust - 1):+.1f} %"])
    return rows


def trees(races):
    own, fcl = by_validator(races)
    same = sum(row["edges"] == fcl[key]["edges"] for key, row in own.items())
    ratios = sorted(fcl[key]["cpu"] / row["cpu"] for key, row in own.items())
    return (
        f"In {same} of {len(own)} searches, both checked the same number of edges. The ratio of the times of the same search "
        f"is {statistics.median(ratios):.1f}x in the median, {ratios[0]:.1f}x to {ratios[-1]:.1f}x."
    )


def alone(searches):
    of_vamp = {row["problem"] for row in searches if row["planner"] == "VAMP"}
    others = [row for row in searches if row["problem"] not in of_vamp]
    if not others:
        return ""
    solved = sum(row["outcome"] == "proven" for row in others)
    count = len({row["problem"] for row in others})
    return f"On problems with allowed pairs, which VAMP does not have, `clearance` proved {solved} of {len(others)} paths ({count} problems)."


def wrapped(text):
    """Paragraphs with lines of at most 120 characters; tables and headings stay."""
    blocks = [block if block.startswith(("|", "#")) else "\n".join(map(_filled, _items(block))) for block in text.split("\n\n")]
    return "\n\n".join(blocks).rstrip() + "\n"


def _items(block):
    """The items of a list; other blocks are one."""
    return [item if i == 0 else "- " + item for i, item in enumerate(block.strip("\n").split("\n- "))]


def _filled(item):
    words = " ".join(item.split())
    return textwrap.fill(words, 120, break_on_hyphens=False, break_long_words=False, subsequent_indent="  " if item.startswith("- ") else "")


def write(path, results, load):
    states, own, groups = results["states"], results["states"][OWN], search_groups(results["searches"])
    first = next(iter(own.values()))
    walls = [times["wall"] for times in own.values()]
    peer = next(iter(states["Drake"].values()))
    text = TEXT.format(
        machine=machine(),
        load=f"{load:.1f} before, {os.getloadavg()[0]:.1f} after",
        date=datetime.date.today().isoformat(),
        versions=versions(),
        required=table(["measure", "at least", "aim", "measured", "reached"], required_rows(results)),
        count=f"{first['count']:,}".replace(",", " "),
        peer_count=f"{peer['count']:,}".replace(",", " "),
        states=table(["", *own, "differ"], state_rows(states)),
        wall=f"{min(walls):.2f} to {max(walls):.2f}",
        overhead=table(["", "Rust (s)", "Python (s)", "a state", "share"], overhead_rows(results["overhead"])),
        races=table(["validator", "median (ms)", "longest (ms)", "solved", "paths refuted", "undecided"], race_rows(results["races"])),
        trees=trees(results["races"]),
        problems=len({row["problem"] for row in results["races"]}),
        seeds=len({row["seed"] for row in results["races"]}),
        searches=table(
            ["planner", "median (ms)", "longest (ms)", "median wall (ms)", "median length (rad)", "solved", "refuted", "undecided"],
            search_rows(groups),
        ),
        alone=alone(results["searches"]),
        wheel=results["package"]["name"],
        size=f"{results['package']['size'] / 1e6:.1f}",
        imported=f"{1e3 * results['package']['imported']:.0f}",
    )
    path.write_text(wrapped(text))
