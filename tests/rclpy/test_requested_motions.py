"""Test that `~/check_motion` checks the requested motion, for robots with mimic, continuous and prismatic joints.

Random robots come on `robot_description`, one after another. The kinematics of this file compute where the ball at the
end of each robot is.
"""

import os
import random
from dataclasses import dataclass
from math import cos, dist, sin, sqrt

from clearance_msgs.srv import CheckMotion
from std_msgs.msg import String

import scene
from cell import Cell
from motions import Motions
from scene_client import SceneClient

ROBOTS = int(os.environ.get("CLEARANCE_RANDOM_ROBOTS", 60))
RADIUS = 0.05  # [m] of the ball at the end of a robot, and of the obstacle
SAMPLES = 1000


@dataclass
class Joint:
    kind: str
    axis: tuple
    origin: tuple
    mimic: tuple = ()  # number of the joint, multiplier, offset

    def pose(self, value):
        """Rotation (three rows) and translation of its child link in the frame of its parent."""
        if self.kind == "prismatic":
            return ((1, 0, 0), (0, 1, 0), (0, 0, 1)), tuple(o + value * a for o, a in zip(self.origin, self.axis))
        (x, y, z), c, s = self.axis, cos(value), sin(value)
        v = 1 - c
        rotation = (
            (x * x * v + c, x * y * v - z * s, x * z * v + y * s),
            (x * y * v + z * s, y * y * v + c, y * z * v - x * s),
            (x * z * v - y * s, y * z * v + x * s, z * z * v + c),
        )
        return rotation, self.origin


def random_joints(rng):
    joints = []
    for number in range(rng.randint(2, 5)):
        axis = [rng.uniform(-1, 1) for _ in range(3)]
        length = sqrt(sum(a * a for a in axis))
        mimic = ()
        if number and rng.random() < 0.5:
            multiplier = rng.choice((0.0, 1.0, -0.5, 2.0, rng.uniform(-2, 2)))
            mimic = rng.randrange(number), multiplier, rng.choice((0.0, rng.uniform(-1, 1)))
        joints.append(
            Joint(
                rng.choice(("revolute", "continuous", "prismatic")),
                tuple(a / length for a in axis),
                tuple(rng.uniform(-0.4, 0.4) for _ in range(3)),
                mimic,
            )
        )
    return joints


def description(joints):
    urdf = "<robot name='r'><link name='base'/>"
    for i, joint in enumerate(joints):
        ball = f"<collision><geometry><sphere radius='{RADIUS}'/></geometry></collision>" if i + 1 == len(joints) else ""
        mimic = "<mimic joint='j{}' multiplier='{!r}' offset='{!r}'/>".format(*joint.mimic) if joint.mimic else ""
        urdf += (
            f"<link name='l{i}'>{ball}</link><joint name='j{i}' type='{joint.kind}'>"
            f"<parent link='{f'l{i - 1}' if i else 'base'}'/><child link='l{i}'/>"
            f"<origin xyz='{' '.join(map(repr, joint.origin))}'/><axis xyz='{' '.join(map(repr, joint.axis))}'/>"
            f"<limit lower='-500' upper='500' effort='1' velocity='1'/>{mimic}</joint>"
        )
    return urdf + "</robot>"


def leader(joints, number):
    """The joint that another one follows, and whether it is moved by it."""
    moves = True
    while joints[number].mimic:
        moves = moves and joints[number].mimic[1] != 0
        number = joints[number].mimic[0]
    return number, moves


def all_values(joints, rng):
    values = []
    for joint in joints:
        values.append(joint.mimic[1] * values[joint.mimic[0]] + joint.mimic[2] if joint.mimic else rng.uniform(-3, 3))
    return values


def ball(joints, values):
    point = (0.0, 0.0, 0.0)
    for joint, value in reversed(list(zip(joints, values))):
        rotation, translation = joint.pose(value)
        point = tuple(sum(r * p for r, p in zip(row, point)) + t for row, t in zip(rotation, translation))
    return point


def named_joints(joints, rng):
    """Joints that together determine all others, in a random order, and some more."""
    named = set()
    for number in range(len(joints)):
        if not joints[number].mimic:
            movers = [other for other in range(len(joints)) if leader(joints, other) == (number, True)]
            named.add(rng.choice(movers))
    named.update(rng.sample(range(len(joints)), rng.randrange(len(joints))))
    return rng.sample(sorted(named), len(named))


def test_the_checked_motion_is_the_requested_one(peer, start):
    rng = random.Random(29)
    cell = start(urdf=None, namespace="/random_robots")
    motions, world = Motions(peer, cell.node), SceneClient(cell)
    publisher, verdicts = None, []
    for revision in range(1, ROBOTS + 1):
        joints = random_joints(rng)
        text = String(data=description(joints))
        if publisher:
            publisher.publish(text)
        else:
            publisher = peer.latch(text, "/random_robots/robot_description")
        cell.has_model(revision)

        begin, end = all_values(joints, rng), all_values(joints, rng)

        def at(t):
            return ball(joints, [a + t * (b - a) for a, b in zip(begin, end)])

        obstacle = tuple(p + rng.choice((0, 0, 0.5)) * rng.uniform(-1, 1) for p in at(rng.random()))
        assert world.apply(scene.diff(scene.ball("b", *obstacle, radius=RADIUS)))
        named = named_joints(joints, rng)
        response = motions.check(
            [begin[j] for j in named], [end[j] for j in named], joints=[f"j{j}" for j in named]
        )

        def gap(t):
            return dist(at(t), obstacle) - 2 * RADIUS

        case = (text.data, named, begin, end, obstacle, response)
        assert response.verdict != CheckMotion.Response.ERROR, case
        for k in range(SAMPLES + 1):
            is_proven = k / SAMPLES < response.t_free or response.verdict == CheckMotion.Response.FREE
            assert not is_proven or gap(k / SAMPLES) > -1e-9, case
        if response.verdict == CheckMotion.Response.CONTACT:
            assert gap(response.t_contact) < 1e-6, case
        verdicts.append(response.verdict)
    assert {CheckMotion.Response.FREE, CheckMotion.Response.CONTACT} <= set(verdicts)
