"""Main program of the node benchmarks: runs each measurement and writes the results page. Called by run.sh."""

import argparse
import itertools
import os
import platform
import subprocess
import sys
import tempfile
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path.insert(0, str(ROOT / "tests/rclpy"))  # nodes as processes, peers, clouds and scenes, as the tests have them

ROWS = ("latency", "latency-with-clients", "memory", "start", "restart")

# Seconds of a row of latency, and of memory; how many starts, and restarts of each peer.
LENGTHS = {"trial": (2, 4, 1, 1), "short": (60, 20, 3, 5), "long": (120, 3600, 10, 50)}


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, prog="benches/node/run.sh")
    length = parser.add_mutually_exclusive_group()
    length.add_argument("--trial", action="store_true", help="about a minute: whether all rows can be measured, with a robot of this repository")
    length.add_argument("--short", action="store_true", help="about a quarter of an hour (the default)")
    length.add_argument("--long", action="store_true", help="about an hour and three quarters")
    parser.add_argument("--binary", type=Path, default=ROOT / "target/release/clearance", help="the program that is measured")
    parser.add_argument("--robot", help="whose joint states come at 1 kHz (default: g1, which the table is about; demo_arm with --trial)")
    parser.add_argument("--rows", default=",".join(ROWS), help=f"some of {','.join(ROWS)}")
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    options.rows = options.rows.split(",")
    options.robot = options.robot or ("demo_arm" if options.trial else "g1")
    if unknown := [row for row in options.rows if row not in ROWS]:
        parser.error(f"--rows: there is no {', '.join(unknown)}")
    if not os.access(options.binary, os.X_OK):
        parser.error(f"no program at {options.binary}: cargo build --release, or give --binary PATH")
    return options


def measured(options):
    """All rows, one after the other."""
    for name, measures in plan(options).items():
        for measure in measures if name in options.rows else ():
            print(f"measuring: {name}", file=sys.stderr)
            row = attempt(name, measure)
            print(f"  {row.measure}: {row.found} (at least {row.required}): {row.word} {row.note}", file=sys.stderr)
            yield row


def plan(options):
    """What gives each row."""
    import latency
    import memory
    import recovery
    import start
    from robots import robot

    fast, ids = options.robot, itertools.count(1)
    seconds, watched, starts, restarts = LENGTHS[length(options)]
    published = latency.PUBLISHED[:1] if options.trial else latency.PUBLISHED
    started = {fast: 1.0} if options.trial else {"ur5e": 1.0, "g1": 2.0}

    def rate(limit, with_clients, published):
        return latency.measure(robot(fast), seconds, next(ids), limit, with_clients, published)

    return {
        "latency": [partial(rate, 1.0, False, what) for what in published],
        "latency-with-clients": [partial(rate, 2.0, True, what) for what in published],
        "memory": [lambda: memory.measure(robot(fast), watched, next(ids))],
        "start": [lambda name=name, limit=limit: start.measure(robot(name), starts, next(ids), limit) for name, limit in started.items()],
        "restart": [partial(recovery.measure, restart, restarts, ids) for restart in recovery.ALL],
    }


def attempt(name, measure):
    """A robot that is not here is passed over, and says so; whatever else goes wrong is a row that is missed."""
    from robots import NotHere
    from rows import Row

    try:
        return measure()
    except NotHere as missing:
        return Row(name, "", "", None, str(missing))
    except AssertionError as error:
        return Row(name, "", "failed", False, " ".join(str(error).split())[:500], works=False)


def length(options):
    return "long" if options.long else "trial" if options.trial else "short"


def facts(options):
    """What the figures belong to."""
    from latency import REALTIME
    from realtime import may_be_realtime

    output_of = lambda *command: subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False).stdout.strip()
    with open("/proc/cpuinfo") as cpus:
        names = [line.split(":")[1].strip() for line in cpus if line.startswith("model name")]
    changed = " with changes" if output_of("git", "status", "--porcelain", "--untracked-files=no") else ""
    return {
        "date": datetime.now(UTC).strftime("%Y-%m-%d"),
        "machine": f"{names[0] if names else platform.machine()}, {os.cpu_count()} threads, Linux {platform.release()}",
        "program": f"{output_of(options.binary.resolve(), '--version')}; the tree is at {output_of('git', 'rev-parse', '--short', 'HEAD')}{changed}",
        "peers": f"rclpy of {os.environ.get('CLEARANCE_ROS', 'kilted')}, Python {platform.python_version()}, on the same machine",
        "latency": f"with {REALTIME}: {str(may_be_realtime()).lower()}",
        "length": length(options),
    }


def main():
    options = arguments()
    os.environ["CLEARANCE_BIN"] = str(options.binary.resolve())
    from rows import markdown

    reported = facts(options)  # before the tree changes
    with tempfile.TemporaryDirectory(prefix="clearance-bench-") as logs:
        os.environ["ROS_LOG_DIR"] = logs
        rows = list(measured(options))
    options.out.write_text(markdown(rows, reported))
    print(f"wrote {options.out}", file=sys.stderr)
    # how fast a machine is, a trial does not ask
    return int(any(not row.works if options.trial else row.reached is False for row in rows))


if __name__ == "__main__":
    sys.exit(main())
