"""The fail-safe table of the README, line by line: each condition is brought about and has to be said as the table says."""

import re
from dataclasses import dataclass
from functools import cached_property
from itertools import cycle
from math import isnan, nan, pi

import pytest
from clearance_msgs.msg import CollisionState
from rclpy.duration import Duration
from rclpy.time import Time
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState, PointCloud2
from std_msgs.msg import Bool, Float64, String
from std_srvs.srv import SetBool

import two_link
from clouds import cloud
from localization import Localization
from node_process import ROOT
from scene import ball
from scene_client import SceneClient

HEADING = "### When the answer is UNKNOWN"
STATUS = {"UNKNOWN": {CollisionState.UNKNOWN}, "as found": {CollisionState.FREE, CollisionState.COLLIDING}}
# What is said beside `~/state`, and what of it is said when nothing is known.
BESIDE = {"is_free": Bool, "speed_scale": Float64, "distance": Float64}
NOTHING_KNOWN = {"is_free": lambda data: not data, "speed_scale": lambda data: data == 0, "distance": isnan}
SIMULATED = {"use_sim_time": True, "stale_after": 5.0}
HEARTBEATS = 3
LONG = Duration(seconds=7200)  # more than stale_after
ZERO = {"joint1": 0.0, "joint2": 0.0}
ONTO = {"joint1": 0.0, "joint2": pi}
PLANAR = """
<robot name="two_link">
  <virtual_joint name="drive" type="planar" parent_frame="odom" child_link="base"/>
  <disable_collisions link1="base" link2="upper" reason="Adjacent"/>
  <disable_collisions link1="upper" link2="tip" reason="Adjacent"/>
</robot>
"""


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

    def __init__(self, peer, start, tmp_path, pose=ZERO):
        self.peer = peer
        self.tmp_path = tmp_path
        self.pose = pose
        self._start = start
        self.cell = None
        self.beside = {}  # recorders by topic
        self.ends = None  # waits for the end of a condition that ends by itself: its heartbeats can not be counted

    def start(self, *arguments, **options):
        self.cell = self._start(*arguments, **options)
        self.beside = {name: self.peer.record(kind, self.cell.node.private(name)) for name, kind in BESIDE.items()}
        return self.cell

    def is_judged(self):
        status = CollisionState.FREE if self.pose is ZERO else CollisionState.COLLIDING
        assert self.cell.judged(**self.pose).status == status

    def judging(self, **parameters):
        """A node that has judged the robot once, and hears nothing any more."""
        cell = self.start(parameters=parameters)
        self.is_judged()
        cell.driver.pause()
        return cell

    def heartbeats(self):
        """Those that come next."""
        seen = len(self.cell.states.messages)
        self.peer.wait_for(lambda: len(self.cell.states.messages) >= seen + HEARTBEATS, "heartbeats")
        return self.cell.states.messages[-HEARTBEATS:]

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

    @cached_property
    def _stranger(self):
        return self.peer.node.create_publisher(JointState, self.cell.node.relative("joint_states"), 10)

    def tell(self, names, positions, stamp=None):
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


def swapping(s, driving):
    """Gives what swaps the model of a node that has one."""
    publisher = s.describe(two_link.description(), "/swap/robot_description")
    cell = s.start("--package-path", s.tmp_path, urdf=None, namespace="/swap", driving=driving)
    cell.has_model()
    heavy = String(data=two_link.description_with_fine_base(s.tmp_path))
    s.ends = lambda: s.peer.wait_for(lambda: cell.states.messages[-1].model_revision == 2, "the other model", 100.0)
    return lambda: publisher.publish(heavy)


def model_swap(s):
    swap = swapping(s, driving=True)
    s.is_judged()
    s.beside["is_free"].wait_for(lambda said: said.data, "free")
    heard = {name: len(topic.messages) for name, topic in s.beside.items()}
    swap()
    for name, is_nothing in NOTHING_KNOWN.items():
        s.beside[name].wait_for(lambda said, is_nothing=is_nothing: is_nothing(said.data), "nothing known", heard[name])


def no_geometry(s):
    s.describe(two_link.description_without_geometry(), "/bare/robot_description")
    s.start(urdf=None, namespace="/bare")


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
    s.until("future_stamp", lambda: cell.driver.publish(ZERO, s.peer.now() + LONG))


def out_of_order(s):
    cell = s.judging()
    s.until("out_of_order", lambda: cell.driver.publish(ZERO, s.peer.now() - Duration(seconds=60)))


def malformed(s):
    s.judging()
    s.until("malformed", lambda: s.tell(["joint1", "joint2", "joint1"], [0.0, 0.0, 0.0]))


def non_finite(s):
    s.judging()
    s.until("non_finite", lambda: s.cell.driver.publish({"joint1": 0.0, "joint2": nan}))


def partial(s):
    cell = s.start(driving=False)
    s.until("partial", lambda: cell.driver.publish({"joint1": 0.0}))


def drives(s):
    """A robot of which tf has to tell where it is."""
    return s.start(urdf="tests/rclpy/rover.urdf", parameters={"transform_joints": ["drive"]}, driving=False)


def no_transform(s):
    driver = drives(s).driver
    s.until("no_transform", lambda: driver.publish({"lift": 0.0}))


def stale_world(s):
    cell = s.start(parameters={"point_cloud_topics": ["points"]})
    cell.driver.report(**ZERO)


def untold_scene(s):
    cell = s.start(parameters={"require_planning_scene": True})
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
    s.until("'gripper'", lambda: s.cell.driver.publish(s.pose | {"gripper": 0.3}))


def outside_limits(s):
    s.judging()
    s.until("limits", lambda: s.cell.driver.publish(s.pose | {"joint1": 4.0}))


def mimic(s):
    s.describe(two_link.description_with_follower(), "/mimic/robot_description")
    cell = s.start(urdf=None, namespace="/mimic")
    cell.has_model()
    cell.driver.report(**s.pose, follower=0.5)


def contradiction(s):
    cell = s.judging(stale_after=10.0)

    def publish():
        stamp = s.peer.now()
        cell.driver.publish(s.pose, stamp)
        s.tell(list(s.pose), [s.pose["joint1"], s.pose["joint2"] - 0.1], stamp)

    s.until("contradiction", publish)


def unlocated_root(s):
    srdf = s.tmp_path / "planar.srdf"
    srdf.write_text(PLANAR)
    cell = s.start("--srdf", srdf)
    scene = SceneClient(cell)
    cell.driver.report(**s.pose)
    s.peer.wait_for(lambda: scene.publish(ball("pillar", 9.0, frame="odom")) or "pillar" in scene.obstacles(), "a pillar")


def no_stamp(s):
    s.judging()
    s.until("no stamp", lambda: s.cell.driver.publish(s.pose, Time()))


def refused_description(s):
    publisher = s.describe(two_link.description(), "/refused/robot_description")
    cell = s.start(urdf=None, namespace="/refused")
    cell.has_model()
    s.is_judged()
    publisher.publish(String(data="<robot"))


SCENARIOS = {
    "checking was turned off (`~/enable`)": disabled,
    "no robot description yet, or none that loads": no_model,
    "another robot description came and is being built": model_swap,
    "no link of the robot has collision geometry": no_geometry,
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
    "two publishers report a joint at different places (0.05 rad or m, and what it goes in 0.2 s) at about the same time (0.1 s)": contradiction,
    "a cloud or octomap is older than its time-to-live, or a cloud has never come": stale_world,
    "`require_planning_scene` or `planning_scene_service` is set, and no whole scene has come": untold_scene,
    "tf, which told again and again where the robot's root is in the frame that obstacles stand in, has been silent for `transform_ttl`, or does not connect the two": lost_root,
    "`check_deadline` passed before every pair was decided, and none was found to touch": deadline,
    "a joint comes that the robot has not": unknown_joint,
    "a joint is outside its limits": outside_limits,
    "a joint is reported elsewhere than the joint it mimics takes it": mimic,
    "obstacles stand in the frame of the SRDF's planar or floating virtual joint, and tf has told nothing about the root": unlocated_root,
    "the joint state has no stamp": no_stamp,
    "the last robot description was refused, and the one before counts": refused_description,
}


def test_every_line_has_a_scenario():
    assert [line.condition for line in table()] == list(SCENARIOS)


# What does not prevent a judgement is brought about in a free pose, and in one that collides.
POSES = {"UNKNOWN": {"": ZERO}, "as found": {"": ZERO, "_colliding": ONTO}}
CASES = {
    SCENARIOS[line.condition].__name__ + suffix: (line, pose)
    for line in table()
    for suffix, pose in POSES[line.status].items()
}


@pytest.mark.parametrize(("line", "pose"), CASES.values(), ids=CASES)
def test_the_line_holds(line, pose, peer, start, tmp_path):
    situation = Situation(peer, start, tmp_path, pose)
    SCENARIOS[line.condition](situation)
    situation.cell.states.wait_for(line.holds, f"what the table says of '{line.condition}'")
    if situation.ends:
        situation.ends()
        return
    # The driver may still report what was asked of it before.
    heartbeats = situation.heartbeats()
    assert all(line.holds(state) for state in heartbeats), heartbeats
    # The status stays: what comes next without a stamp is of such a judgement too.
    (status,) = {state.status for state in heartbeats}
    said = {name: topic.next().data for name, topic in situation.beside.items()}
    assert said["is_free"] == (status == CollisionState.FREE)
    assert line.is_free in ("as found", str(said["is_free"]).lower())
    if status == CollisionState.UNKNOWN:
        assert all(is_nothing(said[name]) for name, is_nothing in NOTHING_KNOWN.items()), said
        assert not any(state.distance_known for state in heartbeats)


# Two faults at once, by the codes of neighbouring lines: brings both about, and after the `yield` takes the first one away.


def disabled_and_no_model(s):
    s.start(urdf=None)
    assert s.enable(False).success
    yield
    assert s.enable(True).success


def no_model_and_no_joint_state(s):
    s.start(urdf=None, namespace="/undescribed", driving=False)
    yield
    s.describe(two_link.description(), "/undescribed/robot_description")


def model_swap_and_no_joint_state(s):
    swap = swapping(s, driving=False)
    swap()
    yield
    s.ends()


def no_geometry_and_no_joint_state(s):
    topic = "/bare/robot_description"
    s.describe(two_link.description_without_geometry(), topic)
    s.start(urdf=None, namespace="/bare", driving=False)
    yield
    s.describe(two_link.description(), topic)


def no_joint_state_and_no_clock(s):
    s.start(parameters=SIMULATED, driving=False)
    yield
    s.cell.driver.resume()


def no_clock_and_stale(s):
    s.start(parameters=SIMULATED, driving=False)
    s.until("no_clock", lambda: s.cell.driver.publish(ZERO, Time(seconds=100)))
    yield
    s.until("stale", lambda: s.tick(200))


def stale_and_future_stamp(s):
    driver = s.judging().driver
    s.until("future_stamp", lambda: driver.publish({"joint1": 0.0}, s.peer.now() + LONG))
    s.until("stale", lambda: driver.publish({"joint2": 0.0}, s.peer.now() - LONG))
    yield
    s.until("future_stamp", lambda: driver.publish({"joint2": 0.0}))


def future_stamp_and_out_of_order(s):
    driver = s.judging().driver
    s.until("out_of_order", lambda: driver.publish(ZERO, s.peer.now() - Duration(seconds=60)))
    s.until("future_stamp", lambda: driver.publish({"joint1": 0.0}, s.peer.now() + LONG))
    yield
    s.until("out_of_order", lambda: driver.publish({"joint1": 0.0}))


def out_of_order_and_malformed(s):
    s.start(driving=False)
    s.until("", lambda: s.tell(list(ZERO), [0.0, 0.0]))
    s.until("out_of_order", lambda: s.tell(list(ZERO), [0.0], s.peer.now() - Duration(seconds=60)))
    yield
    s.until("malformed", lambda: s.tell(list(ZERO), [0.0]))


def malformed_and_non_finite(s):
    s.judging()
    s.until("malformed", lambda: s.tell(["joint2", "joint1", "joint1"], [nan, 0.0, 0.0]))
    yield
    s.until("non_finite", lambda: s.tell(["joint2", "joint1"], [nan, 0.0]))


def malformed_and_later_non_finite(s):
    """In messages of two publishers."""
    driver = s.judging().driver

    def publish(of_joint1):
        s.tell(of_joint1, [0.0] * len(of_joint1))
        driver.publish({"joint2": nan})

    s.until("malformed", lambda: publish(["joint1", "joint1"]))
    yield
    s.until("non_finite", lambda: publish(["joint1"]))


def non_finite_and_no_transform(s):
    driver = drives(s).driver
    s.until("non_finite", lambda: driver.publish({"lift": nan}))
    yield
    s.until("no_transform", lambda: driver.publish({"lift": 0.0}))


def no_transform_and_partial(s):
    driver = drives(s).driver
    s.until("no_transform", lambda: driver.publish({"gripper": 0.0}))
    yield
    Localization(s.cell)


def partial_and_contradiction(s):
    cell = s.start(parameters={"stale_after": 10.0}, driving=False)

    def contradict():
        stamp = s.peer.now()
        cell.driver.publish({"joint1": 0.0}, stamp)
        s.tell(["joint1"], [0.5], stamp)

    s.until("partial", contradict)
    yield
    s.until("contradiction", lambda: (contradict(), s.tell(["joint2"], [0.0])))


def contradiction_and_stale_world(s):
    cell = s.start(parameters={"point_cloud_topics": ["points"], "stale_after": 10.0}, driving=False)

    def publish(joint2):
        stamp = s.peer.now()
        cell.driver.publish(ZERO, stamp)
        s.tell(list(ZERO), [0.0, joint2], stamp)

    s.until("contradiction", lambda: publish(0.5))
    yield
    s.until("stale_world", lambda: publish(0.0))


def partial_and_stale_world(s):
    driver = s.start(parameters={"point_cloud_topics": ["points"]}, driving=False).driver
    s.until("partial", lambda: driver.publish({"joint1": 0.0}))
    yield
    s.until("stale_world", lambda: driver.publish(ZERO))


def stale_world_and_deadline(s):
    s.start(parameters={"point_cloud_topics": ["points"], "check_deadline": 1e-9})
    yield
    sensor = s.peer.node.create_publisher(PointCloud2, s.cell.node.relative("points"), 10)
    s.until("deadline", lambda: sensor.publish(cloud([[5.0, 5.0, 5.0]], stamp=s.peer.now())))


TWO_FAULTS = [
    ("disabled", "no_model", disabled_and_no_model),
    ("no_model", "no_joint_state", no_model_and_no_joint_state),
    ("model_swap", "no_joint_state", model_swap_and_no_joint_state),
    ("no_geometry", "no_joint_state", no_geometry_and_no_joint_state),
    ("no_joint_state", "no_clock", no_joint_state_and_no_clock),
    ("no_clock", "stale", no_clock_and_stale),
    ("stale", "future_stamp", stale_and_future_stamp),
    ("future_stamp", "out_of_order", future_stamp_and_out_of_order),
    ("out_of_order", "malformed", out_of_order_and_malformed),
    ("malformed", "non_finite", malformed_and_non_finite),
    ("malformed", "non_finite", malformed_and_later_non_finite),
    ("non_finite", "no_transform", non_finite_and_no_transform),
    ("no_transform", "partial", no_transform_and_partial),
    ("partial", "contradiction", partial_and_contradiction),
    ("contradiction", "stale_world", contradiction_and_stale_world),
    ("partial", "stale_world", partial_and_stale_world),
    ("stale_world", "deadline", stale_world_and_deadline),
]


@pytest.mark.parametrize(("first", "second", "scenario"), TWO_FAULTS, ids=[case[2].__name__ for case in TWO_FAULTS])
def test_of_two_faults_the_line_that_stands_first_decides(first, second, scenario, peer, start, tmp_path):
    codes = [line.reason_code for line in table()]
    assert codes.index(first) < codes.index(second)
    situation = Situation(peer, start, tmp_path)
    steps = scenario(situation)
    next(steps)
    cell = situation.cell
    cell.unknown(first)
    if not situation.ends:
        assert {state.reason_code for state in situation.heartbeats()} == {first}
    seen = len(cell.states.messages)
    next(steps, None)
    cell.unknown(second, after=seen)


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
