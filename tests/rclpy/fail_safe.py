"""Test helper: the fail-safe table of the documentation, and functions that cause its conditions."""

import re
from dataclasses import dataclass
from functools import cached_property
from math import isnan, pi

from clearance_msgs.msg import CollisionState
from rclpy.duration import Duration
from rclpy.time import Time
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import String
from std_srvs.srv import SetBool

import two_link
from cell import Companions
from node_process import ROOT

PAGE = "docs/reference/fail_safe.md"
HEADING = "## Conditions"
STATUS = {"UNKNOWN": {CollisionState.UNKNOWN}, "FREE or COLLIDING": {CollisionState.FREE, CollisionState.COLLIDING}}
# What is published beside `~/state` when nothing is known.
NOTHING_KNOWN = {
    "is_free": lambda data: not data,
    "speed_scale": lambda data: data == 0,
    "distance": isnan,
    "self_distance": isnan,
    "world_distance": isnan,
}
SIMULATED = {"use_sim_time": True, "stale_after": 5.0}
HEARTBEATS = 3
OUT_OF_MEMORY = 5  # exit code
LONG = Duration(seconds=7200)  # more than stale_after
ZERO = {"joint1": 0.0, "joint2": 0.0}
ONTO = {"joint1": 0.0, "joint2": pi}


@dataclass(frozen=True)
class Line:
    """One line of the table."""

    condition: str
    status: str
    reason_code: str
    is_free: str
    reports: str

    def holds(self, state):
        said = [state.reason] if self.status == "UNKNOWN" else state.warnings
        return (
            state.status in STATUS[self.status]
            and state.reason_code == self.reason_code
            and any(self.reports in text for text in said)
        )


def table():
    section = (ROOT / PAGE).read_text().split(HEADING)[1].split("\n#")[0]
    rows = re.findall(r"^\|(.*)\|$", section, re.MULTILINE)
    cells = [[cell.strip() for cell in row.split("|")] for row in rows][2:]
    return [Line(condition, status, code.strip("`"), free, reports) for condition, status, code, free, reports in cells]


class Situation:
    """What a scenario needs, and what it left behind."""

    def __init__(self, peer, start, tmp_path, pose=ZERO):
        self.peer = peer
        self.tmp_path = tmp_path
        self.pose = pose
        self._start = start
        self.cell = None
        self.companions = None
        self.ends = None  # waits for the end of a condition that ends by itself: its heartbeats can not be counted

    def start(self, *arguments, **options):
        self.cell = self._start(*arguments, **options)
        self.companions = Companions(self.cell)
        return self.cell

    def is_evaluated(self):
        status = CollisionState.FREE if self.pose is ZERO else CollisionState.COLLIDING
        assert self.cell.evaluate(**self.pose).status == status

    def evaluating(self, **parameters):
        """A node that has judged the robot once, and hears nothing any more."""
        cell = self.start(parameters=parameters)
        self.is_evaluated()
        cell.falls_silent()
        return cell

    def heartbeats(self, after):
        """States that follow that one."""
        return self.cell.states.more(HEARTBEATS, after)

    def until(self, word, again):
        """Does something again and again until a state has this reason or warning, and gives it: a datagram may be lost."""
        start = self.peer.now()

        def has_it(state):
            return state.reason_code == word or any(word in text for text in state.warnings)

        def said():
            return next(filter(has_it, self.cell.states.after(start)), None)

        def reported_after_another():
            # what was done may take longer than it takes to see its effect
            if not (state := said()):
                again()
                state = said()
            return state

        return self.peer.wait_for(reported_after_another, f"the reason or warning '{word}'")

    def enable(self, enabled):
        client = self.peer.node.create_client(SetBool, self.cell.node.private("enable"))
        self.peer.wait_for(client.service_is_ready, "~/enable")
        return self.peer.result(client.call_async(SetBool.Request(data=enabled)))

    def describe(self, text, topic):
        return self.peer.latch(String(data=text), topic)

    @cached_property
    def _stranger(self):
        return self.peer.node.create_publisher(JointState, self.cell.node.relative("joint_states"), 10)

    def send(self, names, positions, stamp=None):
        """A joint state of any form, from another publisher than the driver."""
        message = JointState(name=names, position=positions)
        message.header.stamp = (stamp or self.peer.now()).to_msg()
        self._stranger.publish(message)

    @cached_property
    def clock(self):
        return self.peer.node.create_publisher(Clock, "/clock", 10)

    def simulated(self):
        """A node in simulated time, 100 s after its beginning, that has judged the robot once."""
        cell = self.start(parameters=SIMULATED, driving=False)

        # `no_joint_state` stands before `no_clock`: the clock counts once a joint state is evaluated
        def go_on():
            self.tick(100)
            cell.driver.publish({"joint1": 0.0}, Time(seconds=99))

        self.until("partial", go_on)
        assert cell.evaluated(ZERO, Time(seconds=100)).status == CollisionState.FREE
        return cell

    def set_back(self):
        """Sets the clock back to 10 s."""
        self.until("clock_jump", lambda: self.tick(10))

    def tick(self, seconds):
        self.clock.publish(Clock(clock=Time(seconds=seconds).to_msg()))

def runs_out_of_memory(s):
    """A node that takes more memory than it may from now on, and ends."""

    def ends():
        assert s.cell.node.ended() == OUT_OF_MEMORY

    s.ends = ends
    s.cell.parameters.request(memory_limit=1.0)


def swapping(s, driving):
    """Gives what swaps the model of a node that has one."""
    publisher = s.describe(two_link.description(), "/swap/robot_description")
    cell = s.start("--package-path", s.tmp_path, urdf=None, namespace="/swap", driving=driving)
    cell.has_model()
    heavy = String(data=two_link.description_with_fine_base(s.tmp_path))
    s.ends = lambda: cell.states.ever(lambda state: state.model_revision == 2, "the other model", 100.0)
    return lambda: publisher.publish(heavy)


def drives(s):
    """A robot of which tf has to tell where it is."""
    return s.start(urdf="tests/rclpy/rover.urdf", parameters={"transform_joints": ["drive"]}, driving=False)
