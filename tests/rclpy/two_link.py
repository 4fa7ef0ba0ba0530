"""Test helper: the robot of urdf/two_link, its hand-computed results, and a driver of its joint states."""

import re
import threading
from dataclasses import dataclass
from math import asin, pi, sqrt
from pathlib import Path

import numpy as np
from rclpy.time import Time
from sensor_msgs.msg import JointState

from node_process import ROOT

URDF = Path("urdf/two_link/two_link.urdf")
JOINTS = ("joint1", "joint2")


def description():
    return (ROOT / URDF).read_text()


def description_with_cube(side):
    """The same robot with a base of another size: joint states all zero are then at distance 0.9 - side / 2."""
    changed = description().replace('<box size="0.4 0.4 0.4"/>', f'<box size="{side} {side} {side}"/>')
    assert changed != description()
    return changed


def description_without_geometry():
    """The same robot for those who only look at it."""
    return re.sub(r"(</?)collision\b", r"\1visual", description())


def description_with_fine_base(folder):
    """The same robot with a base of so many triangles that it takes long to read; --package-path of a node is this folder."""
    package = folder / "fine_description"
    package.mkdir()
    (package / "package.xml").write_text("<package/>")
    triangles = np.zeros(30_000, dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    noise = np.random.default_rng(1)
    triangles["corners"] = noise.uniform(-0.2, 0.2, (len(triangles), 1, 3)) + noise.normal(0, 0.002, (len(triangles), 3, 3))
    header = b" " * 80 + np.uint32(len(triangles)).tobytes()
    (package / "base.stl").write_bytes(header + triangles.tobytes())
    return description().replace('<box size="0.4 0.4 0.4"/>', '<mesh filename="package://fine_description/base.stl"/>')


def description_with_follower():
    """The same robot with a flag on the tip, whose joint `follower` mimics joint2."""
    flag = '''
  <link name="flag"/>
  <joint name="follower" type="revolute">
    <parent link="tip"/><child link="flag"/><axis xyz="0 0 1"/><mimic joint="joint2"/>
    <limit lower="-3.2" upper="3.2" effort="1" velocity="1"/>
  </joint>
</robot>'''
    return description().replace("</robot>", flag)


@dataclass(frozen=True)
class Answer:
    """A state and its answer, derived in the comment at the top of the URDF."""

    joint1: float
    joint2: float
    distance: float
    on_base: tuple
    on_tip: tuple

    def __str__(self):
        return f"joint1={self.joint1:.4f},joint2={self.joint2:.4f}"


C = 1 - sqrt(3) / 2
D = sqrt(3) / 2 - 0.7
S = 0.2 + D - 0.1 / sqrt(2)
ELBOW = sqrt(0.5) - 0.1 / sqrt(2)
ROD = 0.5 - 0.01 / sqrt(2)

FREE = [
    Answer(0, 0, 0.7, (0.2, 0), (0.9, 0)),
    Answer(0, pi / 2, 0.7, (0.2, 0), (0.9, 0)),
    Answer(0, 3 * pi / 4, 3 * sqrt(2) / 10 - 0.01, (0.2, 0.2), (ROD, ROD)),
    Answer(0, 5 * pi / 6, 0.2, (C, 0.2), (C, 0.4)),
    Answer(0, -5 * pi / 6, 0.2, (C, -0.2), (C, -0.4)),
    Answer(-pi / 6, 5 * pi / 6, sqrt(2) * D - 0.1, (0.2, 0.2), (S, S)),
    Answer(pi / 4, 0, 0.9 - sqrt(2) / 5, (0.2, 0.2), (ELBOW, ELBOW)),
    Answer(pi / 2, 5 * pi / 6, 0.2, (-0.2, C), (-0.4, C)),
]
COLLIDING = [(0, 11 * pi / 12), (0, pi), (pi, pi)]
FIRST_TOUCH = pi - asin(0.3)  # [rad] joint2 where the ball reaches the cube, with joint1 = 0


class Driver:
    """Publishes joint states 50 times a second, as the driver of a robot does."""

    def __init__(self, peer, topic, driving=True):
        self._peer = peer
        self._lock = threading.Lock()
        self._positions = dict.fromkeys(JOINTS, 0.0)
        self.velocities = ()  # [rad/s] one for each reported joint, or none
        self._publisher = peer.node.create_publisher(JointState, topic, 10)
        self._timer = peer.node.create_timer(0.02, self._tick, autostart=driving)

    def _tick(self):
        with self._lock:
            self.publish(self._positions)

    def publish(self, positions, stamp=None):
        message = JointState()
        message.header.stamp = (stamp or self._peer.now()).to_msg()
        message.name = list(positions)
        message.position = [float(position) for position in positions.values()]
        message.velocity = [float(velocity) for velocity in self.velocities]
        self._publisher.publish(message)

    def report(self, **positions):
        """From now on publishes exactly these joints; a stamp not before the returned time belongs to them."""
        with self._lock:
            self._positions = positions
            return self._peer.now()

    @property
    def positions(self):
        """The reported joints."""
        return self._positions

    def pause(self):
        """Nothing is published by itself any more, not even by a tick that had begun."""
        self._timer.cancel()
        self._peer.between_callbacks(lambda: None)

    def resume(self):
        self._timer.reset()

    def disconnect(self):
        """Leaves the graph for good."""
        self._peer.node.destroy_timer(self._timer)
        self._peer.node.destroy_publisher(self._publisher)


def judged_since(stamp):
    """Accepts what is said about joint states that are not older than `stamp`."""
    return lambda said: Time.from_msg(said.header.stamp) >= stamp


def evaluated_of(stamp):
    """Accepts states evaluated of the joint state with exactly this stamp."""
    return lambda state: Time.from_msg(state.header.stamp).nanoseconds == stamp.nanoseconds
