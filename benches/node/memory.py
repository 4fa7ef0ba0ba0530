"""Benchmark of the node: resident memory over time, with joint states at 1 kHz, scene edits and point clouds."""

import time
from contextlib import ExitStack
from itertools import cycle
from statistics import median

import numpy as np
from moveit_msgs.msg import CollisionObject
from sensor_msgs.msg import PointCloud2

from clouds import cloud
from joint_state_source import Source
from node_process import NodeProcess
from peer import Peer
from reports import Reports, came
from rows import Row
from scene import ball, move, pose, removal

RATE = 1000.0  # [Hz]
RATE_AT_LEAST = 0.99 * RATE  # slower, and it is not this that is measured
PERIOD = 0.1  # [s] between two edits, and between two clouds
POINTS = 5000
SAMPLE = 0.5  # [s]
MOST_GROWTH_MB, MOST_GROWTH = 4.0, 0.02  # beyond what an allocator does: absolute, and part of the whole
WARM_UP = 600.0  # [s]
MOST_WHILE_WARM_MB = 16.0  # what caches and the allocator take in a run that is shorter: only a coarse leak shows


def resident(process_id):
    """[MB]"""
    with open(f"/proc/{process_id}/status") as status:
        return next(int(line.split()[1]) / 1024 for line in status if line.startswith("VmRSS:"))


def edits(frame):
    """For ever: three obstacles come, move and go."""
    names = ("a", "b", "c")
    place = lambda number: dict(x=3.0, y=0.5 * number, z=1.0)
    come = [ball(name, radius=0.1, frame=frame, **place(number)) for number, name in enumerate(names)]
    stir = [move(name, pose(**place(number + 0.5)), frame) for number, name in enumerate(names)]
    return cycle(come + stir + [removal(name) for name in names])


def measure(robot, seconds, domain_id):
    parameters = {"point_cloud_topics": "[points]", "point_cloud_ttl": 5.0}
    with ExitStack() as stack:
        peer = stack.enter_context(Peer(domain_id))
        node = stack.enter_context(NodeProcess(*robot.arguments, domain_id=domain_id, parameters=parameters))
        reports = Reports(peer, node)
        disturb(peer, node, robot.root_link)
        stack.enter_context(Source(node.relative("joint_states"), RATE, robot.joints, domain_id))
        reports.wait_for(lambda reported: reported["joint states evaluated in this report"] > 0, "a joint state")
        before = reports.wait_for(lambda reported: reported.numbers.get("world revision", 0) > 0, "an edit")
        samples = sampled(peer, node.process_id, seconds)
        after = reports.wait_for(lambda _: True, "a report")
    return row(robot, samples, before, after)


def disturb(peer, node, frame):
    scene, points = edits(frame), np.random.default_rng(1).uniform((2, -1, 0), (3, 1, 2), (POINTS, 3))
    objects = peer.node.create_publisher(CollisionObject, node.relative("collision_object"), 10)
    clouds = peer.node.create_publisher(PointCloud2, node.relative("points"), 1)
    message = cloud(points, frame)

    def publish():
        objects.publish(next(scene))
        message.header.stamp = peer.now().to_msg()
        clouds.publish(message)

    peer.node.create_timer(PERIOD, publish)


def sampled(peer, process_id, seconds):
    """Times [s] and resident memory [MB]."""
    start, samples = time.monotonic(), []
    while (now := time.monotonic() - start) < seconds:
        samples.append((now, resident(process_id)))
        peer.wait_for(lambda: time.monotonic() - start > now + SAMPLE, "the next look", seconds + 60)
    return np.array(samples)


def row(robot, samples, before, after):
    times, memory = samples[samples[:, 0] >= min(samples[-1, 0] / 4, WARM_UP)].T
    quarter = max(len(memory) // 4, 1)
    early, late = median(memory[:quarter]), median(memory[-quarter:])
    course = ", ".join(f"{memory[at]:.0f}" for at in np.linspace(0, len(memory) - 1, 9).astype(int))
    slope = np.polyfit(times, memory, 1)[0] * 3600 if len(times) > 1 else 0.0
    is_short = samples[-1, 0] < WARM_UP
    allowed = max(MOST_WHILE_WARM_MB if is_short else MOST_GROWTH_MB, MOST_GROWTH * early)
    edits = after["world revision"] - before["world revision"]
    rate = came(before, after)
    return Row(
        f"memory at 1 kHz with scene edits and a cloud of {POINTS} points at 10 Hz, {robot.name}",
        f"flat: at most {allowed:.1f} MB more at the end",
        f"{late - early:+.1f} MB ({early:.0f} to {late:.0f} MB) in {times[-1] - times[0]:.0f} s",
        late - early <= allowed and edits > 0 and rate >= RATE_AT_LEAST,
        f"{course} MB at even times; a line through all of it rises by {slope:+.1f} MB an hour; {rate:.0f} joint states sent a second, {edits:.0f} changes of the world; "
        "the first quarter (ten minutes at most) is warm-up",
    )
