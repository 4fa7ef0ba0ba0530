"""The fail-safe table of the README, line by line: each condition is brought about and has to be said as the table says."""

import re
from dataclasses import dataclass
from itertools import cycle
from math import nan

import numpy as np
import pytest
from clearance_msgs.msg import CollisionState
from rclpy.duration import Duration
from rclpy.time import Time
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, String
from std_srvs.srv import SetBool

import two_link
from localization import Localization
from node_process import ROOT
from scene import ball
from scene_client import SceneClient

HEADING = "### When the answer is UNKNOWN"
STATUS = {"UNKNOWN": {CollisionState.UNKNOWN}, "as found": {CollisionState.FREE, CollisionState.COLLIDING}}
IS_FREE = {"false": {False}, "as found": {True, False}}
HEARTBEATS = 3
ZERO = {"joint1": 0.0, "joint2": 0.0}


@dataclass(frozen=True)
class Line:
    """One line of the table."""

    condition: str
    status: str
    reason_code: str
    is_free: str
    says: str

    def holds(self, state):
        said = [state.reason] if self.status == "UNKNOWN" else state.warnings
        return (
            state.status in STATUS[self.status]
            and state.reason_code == self.reason_code
            and any(self.says in text for text in said)
        )


def table():
    section = (ROOT / "README.md").read_text().split(HEADING)[1].split("\n#")[0]
    rows = re.findall(r"^\|(.*)\|$", section, re.MULTILINE)
    cells = [[cell.strip() for cell in row.split("|")] for row in rows][2:]
    return [Line(condition, status, code.strip("`"), free, says) for condition, status, code, free, says in cells]


class Situation:
    """What a scenario needs, and what it left behind."""

    def __init__(self, peer, start, tmp_path):
        self.peer = peer
        self.tmp_path = tmp_path
        self._start = start
        self.cell = None
        self.after = None  # how a condition ends that ends by itself: its heartbeats can not be counted

    def start(self, **options):
        self.cell = self._start(**options)
        return self.cell

    def judging(self, **parameters):
        """A node that has judged the robot once, and hears nothing any more."""
        cell = self.start(parameters=parameters)
        assert cell.judged(**ZERO).status == CollisionState.FREE
        cell.driver.pause()
        return cell

    def until(self, word, again):
        """Does something again and again until a state has this reason or warning: a datagram may be lost."""

        def said():
            again()
            last = self.cell.states.messages[-1:]
            return any(state.reason_code == word or any(word in text for text in state.warnings) for state in last)

        self.peer.wait_for(said, f"the reason or warning '{word}'")

    def enable(self, enabled):
        client = self.peer.node.create_client(SetBool, self.cell.node.private("enable"))
        self.peer.wait_for(client.service_is_ready, "~/enable")
        return self.peer.result(client.call_async(SetBool.Request(data=enabled)))

    def describe(self, text, topic):
        return self.peer.latch(String(data=text), topic)

    def simulated(self):
        """A node in simulated time, 100 s after its beginning, that has judged the robot once."""
        cell = self.start(parameters={"use_sim_time": True, "stale_after": 5.0}, driving=False)
        self.clock = self.peer.node.create_publisher(Clock, "/clock", 10)

        def go_on():
            self.tick(100)
            cell.driver.publish(ZERO, Time(seconds=100))

        self.until("", go_on)
        return cell

    def set_back(self):
        """Sets the clock back to 10 s; once more, if a joint state of the time before came late."""
        seconds = cycle([10] * 10 + [100] * 10)
        self.until("clock_jump", lambda: self.tick(next(seconds)))

    def tick(self, seconds):
        self.clock.publish(Clock(clock=Time(seconds=seconds).to_msg()))


def disabled(s):
    s.judging()
    answer = s.enable(False)
    assert answer.success
    assert "disabled" in answer.message


def no_model(s):
    s.start(urdf=None)


def model_swap(s):
    """A description of which the mesh takes long to read."""
    folder = s.tmp_path / "heavy_description"
    folder.mkdir()
    (folder / "package.xml").write_text("<package/>")
    triangles = np.zeros(300, dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    noise = np.random.default_rng(1)
    triangles["corners"] = noise.uniform(-0.2, 0.2, (len(triangles), 1, 3)) + noise.normal(0, 0.002, (len(triangles), 3, 3))
    header = b" " * 80 + np.uint32(len(triangles)).tobytes()
    (folder / "heavy.stl").write_bytes(header + triangles.tobytes())
    heavy = two_link.description().replace(
        '<box size="0.4 0.4 0.4"/>', '<mesh filename="package://heavy_description/heavy.stl"/>'
    )
    publisher = s.describe(two_link.description(), "/swap/robot_description")
    cell = s._start("--package-path", s.tmp_path, urdf=None, namespace="/swap")
    s.cell = cell
    cell.has_model()
    assert cell.judged(**ZERO).status == CollisionState.FREE
    publisher.publish(String(data=heavy))
    s.after = lambda: s.peer.wait_for(lambda: cell.states.messages[-1].model_revision == 2, "the other model", 100.0)


def no_joint_state(s):
    s.start(driving=False)


def clock_jump(s):
    s.simulated()
    s.set_back()


def no_clock(s):
    s.start(parameters={"use_sim_time": True})


def stale(s):
    cell = s.start()
    assert cell.judged(**ZERO).status == CollisionState.FREE
    cell.grows_old()
    cell.driver.pause()


def stale_joint(s):
    cell = s.start()
    assert cell.judged(**ZERO).status == CollisionState.FREE
    cell.grows_old()
    cell.driver.report(joint1=0.0)


def clock_leap(s):
    s.simulated()
    s.until("stale", lambda: s.tick(200))


def future_stamp(s):
    cell = s.judging()
    s.until("future_stamp", lambda: cell.driver.publish(ZERO, s.peer.now() + Duration(seconds=7200)))


def out_of_order(s):
    cell = s.judging()
    s.until("out_of_order", lambda: cell.driver.publish(ZERO, s.peer.now() - Duration(seconds=60)))


def malformed(s):
    cell = s.judging()
    publisher = s.peer.node.create_publisher(JointState, cell.node.relative("joint_states"), 10)

    def publish():
        message = JointState(name=["joint1", "joint2", "joint1"], position=[0.0, 0.0, 0.0])
        message.header.stamp = s.peer.now().to_msg()
        publisher.publish(message)

    s.until("malformed", publish)


def non_finite(s):
    s.judging()
    s.until("non_finite", lambda: s.cell.driver.publish({"joint1": 0.0, "joint2": nan}))


def partial(s):
    cell = s.start(driving=False)
    s.until("partial", lambda: cell.driver.publish({"joint1": 0.0}))


def no_transform(s):
    cell = s.start(urdf="tests/rclpy/rover.urdf", parameters={"transform_joints": ["drive"]})
    cell.driver.report(lift=0.0)


def stale_world(s):
    cell = s.start(parameters={"point_cloud_topics": ["points"]})
    cell.driver.report(**ZERO)


def lost_root(s):
    cell = s.start(parameters={"transform_ttl": 1.0})
    cell.driver.report(**ZERO)
    scene = SceneClient(cell)
    localization = Localization(cell)
    s.peer.wait_for(lambda: scene.publish(ball("pillar", 9.0, frame="odom")) or "pillar" in scene.obstacles(), "a pillar")
    # the root stands still, and is told of again and again
    told = localization.told
    s.peer.wait_for(lambda: localization.told > told + 20, "transforms")
    localization.fall_silent()


def deadline(s):
    s.start(parameters={"check_deadline": 1e-9})


def unknown_joint(s):
    s.judging()
    s.until("'gripper'", lambda: s.cell.driver.publish(ZERO | {"gripper": 0.3}))


def outside_limits(s):
    s.judging()
    s.until("limits", lambda: s.cell.driver.publish({"joint1": 4.0, "joint2": 0.0}))


def mimic(s):
    s.describe(two_link.description_with_follower(), "/mimic/robot_description")
    cell = s.start(urdf=None, namespace="/mimic")
    cell.has_model()
    cell.driver.report(**ZERO, follower=0.5)


def contradiction(s):
    cell = s.judging()
    other = s.peer.node.create_publisher(JointState, cell.node.relative("joint_states"), 10)

    def publish():
        stamp = s.peer.now()
        cell.driver.publish(ZERO, stamp)
        message = JointState(name=list(ZERO), position=[0.0, 0.5])
        message.header.stamp = stamp.to_msg()
        other.publish(message)

    s.until("two publishers", publish)


def no_stamp(s):
    s.judging()
    s.until("no stamp", lambda: s.cell.driver.publish(ZERO, Time()))


def refused_description(s):
    publisher = s.describe(two_link.description(), "/refused/robot_description")
    cell = s.start(urdf=None, namespace="/refused")
    cell.has_model()
    assert cell.judged(**ZERO).status == CollisionState.FREE
    publisher.publish(String(data="<robot"))


SCENARIOS = {
    "checking was turned off (`~/enable`)": disabled,
    "no robot description yet, or none that loads": no_model,
    "another robot description came and is being built": model_swap,
    "no joint state yet": no_joint_state,
    "the clock was set back by more than `stale_after`, and nothing came since": clock_jump,
    "`use_sim_time` is set and nothing arrives on `/clock`": no_clock,
    "the last joint state is older than `stale_after`": stale,
    "the last joint state that names some joint is older than `stale_after`": stale_joint,
    "the clock leapt forward by more than `stale_after`": clock_leap,
    "the stamp lies more than `stale_after` in the future": future_stamp,
    "the stamp is older than the last one of its publisher about these joints": out_of_order,
    "names and positions differ in number, or a joint comes twice": malformed,
    "a position is NaN or infinite": non_finite,
    "tf does not tell where a joint of `transform_joints` is, or its transform is older than `transform_ttl`": no_transform,
    "a joint of the robot has never been named": partial,
    "a cloud or octomap is older than its time-to-live, or a cloud has never come": stale_world,
    "tf, which told again and again where the robot's root is in the frame that obstacles stand in, has been silent for `transform_ttl`, or does not connect the two": lost_root,
    "`check_deadline` passed before every pair was decided, and none was found to touch": deadline,
    "a joint comes that the robot has not": unknown_joint,
    "a joint is outside its limits": outside_limits,
    "a joint is reported elsewhere than the joint it mimics takes it": mimic,
    "two publishers report a joint at different places at about the same time": contradiction,
    "the joint state has no stamp": no_stamp,
    "the last robot description was refused, and the one before counts": refused_description,
}


def test_every_line_has_a_scenario():
    assert [line.condition for line in table()] == list(SCENARIOS)


@pytest.mark.parametrize("line", table(), ids=lambda line: SCENARIOS[line.condition].__name__)
def test_the_line_holds(line, peer, start, tmp_path):
    situation = Situation(peer, start, tmp_path)
    SCENARIOS[line.condition](situation)
    states, node = situation.cell.states, situation.cell.node
    is_free = peer.record(Bool, node.private("is_free"))

    states.wait_for(line.holds, f"what the table says of '{line.condition}'")
    if situation.after:
        situation.after()
        return
    seen = len(states.messages)
    peer.wait_for(lambda: len(states.messages) >= seen + HEARTBEATS, "heartbeats")
    # The driver may still report what was asked of it before.
    assert all(line.holds(state) for state in states.messages[-HEARTBEATS:]), states.messages[-HEARTBEATS:]
    assert is_free.next().data in IS_FREE[line.is_free]
    assert not any(state.distance_known for state in states.messages[-HEARTBEATS:] if line.status == "UNKNOWN")


def test_what_is_enabled_again_is_judged_at_once(peer, start, tmp_path):
    situation = Situation(peer, start, tmp_path)
    cell = situation.judging()
    for enabled, status in [(False, CollisionState.UNKNOWN), (True, CollisionState.FREE)] * 2:
        assert situation.enable(enabled).success
        state = cell.states.next()
        assert state.status == status
        # who was told so hears nothing older
        assert state.reason_code == ("" if enabled else "disabled")


def test_joint_states_after_the_clock_was_set_back_are_judged(peer, start, tmp_path):
    situation = Situation(peer, start, tmp_path)
    cell = situation.simulated()
    situation.set_back()
    situation.until("", lambda: cell.driver.publish(ZERO, Time(seconds=10)))
    assert cell.states.messages[-1].status == CollisionState.FREE
