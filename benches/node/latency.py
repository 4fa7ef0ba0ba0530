"""Benchmark of the node at 1 kHz: lost joint states, and latency from receipt to publication of `~/state`."""

import os
import signal
import subprocess
import sys
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import rclpy
from clearance_msgs.msg import CollisionState
from rclpy.context import Context

from joint_state_source import Source
from node_process import NodeProcess
from peer import Peer
from realtime import may_be_realtime
from reports import Reports, came
from rows import Row

RATE = 1000.0  # [Hz]
RATE_AT_LEAST = 0.99 * RATE  # slower, and it is not this that is measured
WARM_UP = 3  # reports
CLIENTS = 8
REALTIME = "use_realtime_priority"
COUNTS = ("joint states passed over", "joint states lost", "messages dropped")


@dataclass(frozen=True)
class Published:
    """What is said about each joint state."""

    words: str
    parameters: dict


# [m] the most it can be
ALL_PAIRS = Published("least distance and all pairs published", {"influence_distance": 10.0})
NEAR_PAIRS = Published("least distance and pairs within 5 cm published", {"influence_distance": 0.05})
TOLERANCES = {"distance_relative_tolerance": 0.1, "distance_absolute_tolerance": 0.001}


def within_a_tenth(exact):
    return Published(f"{exact.words} within a tenth or 1 mm", exact.parameters | TOLERANCES)


PUBLISHED = [ALL_PAIRS, within_a_tenth(ALL_PAIRS), NEAR_PAIRS, within_a_tenth(NEAR_PAIRS)]


class Listener:
    """A participant that takes in all of `~/state`, reliably, and never looks at it: looking would cost more than the node does."""

    def __init__(self, topic, domain_id):
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain_id)
        self._node = rclpy.create_node("listener", context=self._context, enable_rosout=False)
        self._node.create_subscription(CollisionState, topic, lambda _: None, 10)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)


@dataclass(frozen=True)
class Processors:
    """What the system has counted of their time [s / 100]."""

    all: int
    stolen: int

    @classmethod
    def now(cls):
        with open("/proc/stat") as counts:
            times = [int(time) for time in counts.readline().split()[1:9]]
        return cls(sum(times), times[7])

    def taken_since(self):
        now = Processors.now()
        share = (now.stolen - self.stolen) / max(now.all - self.all, 1)
        return f"the host of this virtual machine took {share:.1%} of the processors' time for others"


class Clients:
    """A process of clients that check trajectories in a loop, each the next one as soon as the last is answered."""

    def __init__(self, service, joints, domain_id):
        script = Path(__file__).with_name("trajectory_clients.py")
        command = [sys.executable, "-B", script, service, str(CLIENTS), ",".join(joints)]
        environment = os.environ | {"ROS_DOMAIN_ID": str(domain_id)}
        self._process = subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True)
        assert self._process.stdout.readline() == "ready\n", "the clients did not meet the service"

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.kill()
        self._process.wait()

    def end(self):
        """What they say of what was answered."""
        self._process.send_signal(signal.SIGTERM)
        return self._process.communicate(timeout=60)[0].strip()


def measure(robot, seconds, domain_id, limit, with_clients, published=ALL_PAIRS):
    with ExitStack() as stack:
        enter = stack.enter_context
        peer = enter(Peer(domain_id))
        parameters = published.parameters | {REALTIME: may_be_realtime()}
        node = enter(NodeProcess(*robot.arguments, domain_id=domain_id, parameters=parameters))
        reports = Reports(peer, node)
        enter(Listener(node.private("state"), domain_id))
        reports.wait_for(lambda _: True, "the node")
        enter(Source(node.relative("joint_states"), RATE, robot.joints, domain_id))
        clients = enter(Clients(node.private("check_trajectory"), robot.joints, domain_id)) if with_clients else None
        reports.wait_for(lambda reported: reported["joint states evaluated in this report"] > 0, "a joint state")
        for _ in range(WARM_UP):
            reports.wait_for(lambda _: True, "a report")
        before = Processors.now()
        reported = reports.during(seconds)
        notes = [before.taken_since()] + ([f"clients: {clients.end()}"] if clients else [])
        note = "; ".join(notes)
    return row(robot, reported, limit, with_clients, note, published)


def row(robot, reported, limit, with_clients, note, published=ALL_PAIRS):
    first, last = reported[0], reported[-1]
    dropped = {name: round(last[name] - first[name]) for name in COUNTS}
    rate = came(first, last)
    worst = max(report.numbers.get("latency: p99 (ms)", 0.0) for report in reported[1:])
    p99, median, longest = (last[f"latency since start: {part} (ms)"] for part in ("p99", "median", "max"))
    which = ", ".join(f"{count} {name}" for name, count in dropped.items() if count)
    details = f"{rate:.0f} joint states sent a second for {last.at - first.at:.0f} s, {last['pairs checked']:.0f} pairs, median {median:.3f} ms, "
    details += f"longest {longest:.3f} ms, p99 of the worst second {worst:.3f} ms, mean check {last['mean compute time (ms)']:.3f} ms in the last second"
    return Row(
        f"joint_states at 1 kHz, {robot.name}, {published.words}"
        + (f", {CLIENTS} clients checking trajectories" if with_clients else "")
        + ": drops / p99 from receipt to publish",
        f"0 / {limit:g} ms",
        f"{sum(dropped.values())}{f' ({which})' if which else ''} / {p99:.3f} ms",
        not any(dropped.values()) and p99 <= limit and rate >= RATE_AT_LEAST,
        "; ".join(filter(None, [details, note])),
    )
