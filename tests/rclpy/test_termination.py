"""Tests that the node ends within 2 s of a signal, under every kind of load."""

import fcntl
import os
import signal
import socket
import subprocess
import sys
import time

import pytest
from clearance_msgs.msg import CollisionState
from moveit_msgs.srv import ApplyPlanningScene
from std_msgs.msg import String

import two_link
from motions import Motions
from node_process import BINARY, NodeProcess
from scene import diff, fine_mesh, obstacle, pose
from scene_client import SceneClient

LIMIT = 2.0  # [s] what the interface promises
TIMES = int(os.environ.get("CLEARANCE_SIGNALS", "1"))  # of every load and signal
SUSPENDED = [float(text) for text in os.environ.get("CLEARANCE_SUSPENDED", "1").split()]  # [s]
ENDED, FAILED, FORCED, KILLED = 0, 3, 4, -signal.SIGKILL  # exit codes
MEBIBYTE = 1 << 20
SUBSCRIBER = """
import rclpy
from clearance_msgs.msg import CollisionState
rclpy.init(domain_id={domain})
node = rclpy.create_node("subscriber")
node.create_subscription(CollisionState, "{topic}", lambda _: print("received", flush=True), 10)
rclpy.spin(node)
"""


def chain(links):
    """A chain of boxes, of which almost every pair has to be checked: it takes seconds to build."""
    box = '<collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>'
    text = [f'<robot name="chain"><link name="l0">{box}</link>']
    for number in range(1, links):
        text.append(
            f'<link name="l{number}">{box}</link><joint name="j{number}" type="revolute"><parent link="l{number - 1}"/>'
            f'<child link="l{number}"/><origin xyz="0.2 0 0"/><axis xyz="0 0 1"/>'
            '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        )
    return "".join(text) + "</robot>"


class Load:
    """A node under a load, and what it may end with."""

    codes = (ENDED,)

    def __init__(self, start, tmp_path):
        self.start = start
        self.tmp_path = tmp_path

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def described(self, *arguments, **options):
        """A node that has judged its robot."""
        cell = self.start(*arguments, **options)
        assert cell.evaluate(joint1=0, joint2=0).status == CollisionState.FREE
        return cell


class Idle(Load):
    def __enter__(self):
        self.cell = self.start(urdf=None)
        self.cell.unknown("no_model")
        return self


class BuildingAModel(Load):
    """A large description has arrived and is being read or built."""

    def __enter__(self):
        self.cell = self.start(urdf=None)
        publisher = self.cell.peer.latch(String(data=two_link.description()), self.cell.node.relative("robot_description"))
        self.cell.has_model()
        publisher.publish(String(data=chain(800)))
        self.cell.unknown("model_swap")
        return self


class BuildingAWorld(Load):
    """A large scene has arrived and is being read or built."""

    def __enter__(self):
        self.cell = self.described()
        before = resident_memory(self.cell.node)
        meshes = [obstacle(f"mesh_{i}", fine_mesh(20_000), at=pose(9.0 + i)) for i in range(60)]
        SceneClient(self.cell).request(
            ApplyPlanningScene, "apply_planning_scene", ApplyPlanningScene.Request(scene=diff(*meshes))
        )
        self.cell.peer.wait_for(
            lambda: resident_memory(self.cell.node) > before + 8 * MEBIBYTE, "the scene in the node's memory"
        )
        return self


class Flooded(Load):
    """Joint states as fast as they can be published."""

    def __enter__(self):
        self.cell = self.described()
        for _ in range(2000):
            self.cell.driver.report(joint1=0, joint2=0)
        return self


class Recording(Flooded):
    """A recording whose last steps are still being written."""

    def described(self):
        return super().described(parameters={"record_file": str(self.tmp_path / f"{time.monotonic_ns()}.mcap")})


class Requested(Load):
    """More motions are to be checked than are checked within the time to end."""

    def __enter__(self):
        self.cell = self.described()
        motions = Motions(self.cell.peer, self.cell.node)
        for _ in range(150):
            motions.ask([0, 0], [3, 3])
        return self


class Viewed(Load):
    """Web browsers that read nothing of what they asked for, or that never finish asking."""

    def __enter__(self):
        self.cell = self.described("--view", "0")
        output = self.cell.node.output
        self.cell.peer.wait_for(lambda: "http://127.0.0.1:" in output(), "the address of the view")
        port = int(output().split("http://127.0.0.1:")[1].split("/")[0])
        self.sockets = [socket.create_connection(("127.0.0.1", port)) for _ in range(6)]
        for number, connection in enumerate(self.sockets):
            connection.sendall(b"GET /updates HTTP/1.1\r\nHost: 127.0.0.1\r\n" + (b"\r\n" if number % 2 else b""))
        return self

    def __exit__(self, *_):
        for connection in self.sockets:
            connection.close()


class SuspendedSubscriber(Load):
    """A reliable subscriber that takes nothing any more."""

    def __enter__(self):
        self.cell = self.described()
        code = SUBSCRIBER.format(domain=self.cell.peer.domain_id, topic=self.cell.node.private("state"))
        self.process = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE)
        assert self.process.stdout.readline() == b"received\n"
        os.kill(self.process.pid, signal.SIGSTOP)
        state = self.cell.state_now()
        self.cell.states.more(20, state)
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.wait()
        self.process.stdout.close()


class BlockedPipe(Load):
    """The reader of the node's output has stopped, and the pipe is full."""

    codes = (ENDED, FORCED, KILLED)

    def __enter__(self):
        self.output, pipe = os.pipe()
        self.cell = self.start(output=pipe)
        self.cell.evaluate(joint1=0, joint2=0)
        fcntl.fcntl(pipe, fcntl.F_SETFL, os.O_NONBLOCK)
        try:
            while True:
                os.write(pipe, b"\n" * 512)
        except BlockingIOError:
            pass
        # the other end's flags are shared
        fcntl.fcntl(pipe, fcntl.F_SETFL, 0)
        os.close(pipe)
        # a change of status is logged
        self.cell.driver.report(joint1=0, joint2=3.14)
        return self

    def __exit__(self, *_):
        os.close(self.output)


LOADS = [
    Idle, BuildingAModel, BuildingAWorld, Flooded, Recording, Requested, Viewed, SuspendedSubscriber, BlockedPipe
]


def resident_memory(node):
    """Bytes of the node's process."""
    return resident_memory_of(node.process_id)


def resident_memory_of(process_id):
    with open(f"/proc/{process_id}/statm") as numbers:
        return int(numbers.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


@pytest.mark.parametrize("by", [signal.SIGTERM, signal.SIGINT], ids=lambda by: by.name)
@pytest.mark.parametrize("load", LOADS, ids=lambda load: load.__name__)
def test_the_node_ends_in_time_under_load(start, tmp_path, load, by):
    for _ in range(TIMES):
        with load(start, tmp_path) as loaded:
            begin = time.monotonic()
            code = loaded.cell.node.stop(by)
            duration = time.monotonic() - begin
        assert code in loaded.codes, f"ended with {code}"
        assert duration < LIMIT


def test_a_second_signal_ends_the_node_at_once(start, tmp_path):
    with BuildingAModel(start, tmp_path) as loaded:
        node = loaded.cell.node
        os.kill(node.process_id, signal.SIGTERM)
        assert node.stop(signal.SIGINT) in (ENDED, FORCED)


NOT_STARTED = 143  # exit code
IGNORING = [sys.executable, "-c", "import os, signal, sys; signal.signal(signal.SIGINT, signal.SIG_IGN); os.execv(sys.argv[1], sys.argv[1:])"]
IN_A_CONTAINER = ["unshare", "--pid", "--fork", "--kill-child"]
PREFIXES = {"by default": [], "as a background job of a shell": IGNORING, "as PID 1": IN_A_CONTAINER}


def children(process_id):
    with open(f"/proc/{process_id}/task/{process_id}/children") as numbers:
        return [int(number) for number in numbers.read().split()]


def catches(process_id, number):
    """Whether the process, which runs the node, has a handler of this signal."""
    try:
        with open(f"/proc/{process_id}/status") as status, open(f"/proc/{process_id}/cmdline") as command:
            (caught,) = [int(line.split()[1], 16) for line in status if line.startswith("SigCgt")]
            return command.read().startswith(f"{BINARY}\0node") and bool(caught >> (number - 1) & 1)
    except FileNotFoundError:
        return False


@pytest.mark.parametrize("phase", ["being read", "being built"])
@pytest.mark.parametrize("prefix", PREFIXES)
@pytest.mark.parametrize("by", [signal.SIGTERM, signal.SIGINT], ids=lambda by: by.name)
def test_a_node_that_reads_its_robot_ends_at_once(peer, tmp_path, by, prefix, phase):
    """Signals are not lost where their default action is ignored, and the robot is not built to its end."""
    (tmp_path / "chain.urdf").write_text(chain(2500))
    with NodeProcess("--urdf", tmp_path / "chain.urdf", domain_id=peer.domain_id, prefix=PREFIXES[prefix]) as node:

        def process_id():
            return next(iter(children(node.process_id)), None) if prefix == "as PID 1" else node.process_id

        peer.wait_for(lambda: process_id() and catches(process_id(), by), "a handler of the signal")
        before = resident_memory_of(process_id())
        if phase == "being built":
            # the links take 20 MB at most, the pairs more
            peer.wait_for(lambda: resident_memory_of(process_id()) > before + 30 * MEBIBYTE, "pairs in its memory")
        begin = time.monotonic()
        os.kill(process_id(), by)
        code = node.ended()
        duration = time.monotonic() - begin
        assert "listens to" not in node.output()
    assert code == NOT_STARTED
    assert duration < LIMIT


@pytest.mark.parametrize("seconds", SUSPENDED)
def test_a_suspended_node_goes_on_or_says_why_it_ends(start, tmp_path, seconds):
    """A debugger, Ctrl-Z, a container that is paused."""
    cell = Load(start, tmp_path).described()
    os.kill(cell.node.process_id, signal.SIGSTOP)
    time.sleep(seconds)  # nothing is waited for: this is how long it is suspended
    os.kill(cell.node.process_id, signal.SIGCONT)
    moment = cell.peer.now()

    def goes_on_or_ended():
        return cell.node.exit_code is not None or cell.states.after(moment)

    cell.peer.wait_for(goes_on_or_ended, "a state of the continued node, or its end")
    if cell.node.exit_code is not None:
        assert cell.node.ended() == FAILED
        assert "suspended" in cell.node.output()
