"""Tests of recordings: other programs read them, a replay gives the same results, and what remains after a kill."""

import shutil
from math import pi

import pytest
from clearance_msgs.msg import CollisionState
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TransformStamped
from std_msgs.msg import Float64, String
from std_srvs.srv import SetBool
from tf2_msgs.msg import TFMessage

import scene as scenes
import two_link
from clouds import cloud
from node_process import NodeProcess
from recordings import messages, outcome, replay, steps, tampered
from scene_client import SceneClient
from test_transforms import Localization
from sensor_msgs.msg import PointCloud2

FOLDED = {"joint1": 0, "joint2": 5 * pi / 6}
COLLIDING = {"joint1": 0, "joint2": pi}
WORLD = """
world:
  collision_objects:
    - id: wall
      header: {frame_id: base}
      meshes: [{resource: wall.obj}]
      mesh_poses: [{position: {x: 1.2, y: 0.5, z: 0.0}}]
"""
SPHERE = '<sphere radius="0.1"/>'
NEAR = {"influence_distance": 0.5, "distance_limit": 2.0}
INCOMPLETE = 4  # exit code


@pytest.fixture
def file(tmp_path):
    return tmp_path / "run.mcap"


def recorded(file, **parameters):
    return NEAR | {"record_file": str(file)} | parameters


def ended(cell):
    """The node ends, and its file is complete."""
    assert cell.node.stop() == 0
    assert "is complete" in cell.node.output()


def same(file):
    """That many answers are the same; none is another."""
    result = outcome(file)
    assert result["difference"] is None and result["lost"] is None, result
    return result["same"]


def test_a_run_with_everything_in_it_is_the_same_again(start, peer, file):
    cell = start(parameters=recorded(file, point_cloud_topics=["points"], point_cloud_ttl=3600.0, point_radius=0.02))
    scene = SceneClient(cell)
    cell.unknown("stale_world")
    camera = TransformStamped(child_frame_id="camera")
    camera.header.frame_id = "base"
    camera.transform.translation.z = 0.1
    scene.topic(TFMessage, "tf_static").publish(TFMessage(transforms=[camera]))
    cell.evaluate(**FOLDED)
    # until the transform has come, clouds in its frame are refused
    scene.change(cloud([(2.3, 0, 0), (2.4, 0.1, 0.3)], frame="camera", stamp=peer.now()), topic="points")
    cell.evaluate(joint1=0, joint2=0)
    scene.change(scenes.ball("ball", x=1.5, y=0.5), scenes.move("ball", scenes.pose(1.5, 0.4, 0.1, angle=0.3)))
    assert scene.apply(scenes.diff(scenes.ball("other", x=1.0, y=-0.7)))
    scene.change(scenes.attached("tip", scenes.ball("part", x=1.2, radius=0.05, frame="tip"), ["tip"]))
    cell.evaluate(**FOLDED)
    cell.parameters.succeed(padding=0.01, look_ahead_horizon=0.5)
    cell.moving(COLLIDING, [0.1, -0.2])
    cell.grows_old()
    cell.driver.report(joint1=0)
    assert "'joint2'" in cell.unknown("stale").reason
    cell.evaluate(**FOLDED)
    cell.driver.pause()
    cell.unknown("stale")
    ended(cell)

    assert same(file) >= len(cell.states.all()) / 2
    assert replay(file).returncode == 0
    clouds = [cloud for step in steps(file, cell.node) if "pass" in step for cloud in step["pass"]["clouds"]]
    assert {cloud["topic"] for cloud in clouds} == {"points"}


def test_robots_that_come_by_topic_are_the_same_again(start, peer, file):
    topic = "/by_topic/robot_description"
    publisher = peer.latch(String(data=two_link.description()), topic)
    cell = start(urdf=None, namespace="/by_topic", parameters=recorded(file))
    cell.has_model(1)
    cell.evaluate(**FOLDED)
    publisher.publish(String(data=two_link.description_with_cube(0.8)))
    cell.has_model(2)
    cell.evaluate(**FOLDED)
    # a fault that names folders of this machine
    publisher.publish(String(data=two_link.description().replace(SPHERE, '<mesh filename="package://a/b.stl"/>')))
    SceneClient(cell).complaints.wait_for("b.stl")
    cell.evaluate(joint1=0, joint2=0)
    ended(cell)

    assert same(file) > 2
    assert ["b.stl" in message.data for message in messages(file, topic)] == [False, False, True]


def test_a_run_of_several_drivers_that_is_slowed_turned_off_and_late_is_the_same_again(start, peer, file):
    slow = {"slowdown_distance_self": 0.8, "slowdown_release_count": 2}
    cell = start(parameters=recorded(file, **slow))
    scales = peer.record(Float64, cell.node.private("speed_scale"))
    elbow = two_link.Driver(peer, cell.node.relative("joint_states"))
    elbow.report(joint2=5 * pi / 6)
    cell.driver.report(joint1=0.0)
    scales.ever(lambda scale: 0.0 < scale.data < 1.0, "a slower robot")
    enable = peer.node.create_client(SetBool, cell.node.private("enable"))
    peer.wait_for(enable.service_is_ready, "the service enable")
    peer.result(enable.call_async(SetBool.Request(data=False)))
    cell.unknown("disabled")
    peer.result(enable.call_async(SetBool.Request(data=True)))
    cell.parameters.succeed(check_deadline=1e-9)
    cell.unknown("deadline")
    cell.parameters.succeed(check_deadline=0.0, joint_prefix="other_")
    cell.unknown("partial")
    cell.parameters.succeed(joint_prefix="", link_volume_level=1)
    scales.wait_for(lambda scale: 0.0 < scale.data < 1.0, "a slower robot", after=peer.now())
    cell.grows_old()
    elbow.pause()
    assert "'joint2'" in cell.unknown("stale").reason
    ended(cell)

    result = outcome(file)
    assert result["difference"] is None and result["late"] > 0, result
    assert len(messages(file, cell.node.private("speed_scale"))) == result["same"]


def test_a_base_that_tf_places_is_placed_again(start, peer, file):
    parameters = recorded(file, transform_joints=["drive"], transform_ttl=1.0, distance_limit=20.0)
    cell = start(urdf="tests/rclpy/rover.urdf", parameters=parameters)
    cell.driver.report(lift=0.5)
    cell.unknown("no_transform")
    localization = Localization(cell)
    for x in (2.0, 3.0):
        localization.send(x)
        distance = pytest.approx(x + 1.4, abs=1e-9)
        cell.states.ever(lambda state: state.nearest.distance == distance, "the distance to the wall")
    localization.fall_silent()
    cell.unknown("no_transform")
    ended(cell)

    assert same(file) > 3
    assert any("looked" in step for step in steps(file, cell.node))


def several_answers(cell):
    """Waits for more of them, whatever came before."""
    cell.states.more(5, after=cell.peer.now())


def test_meshes_are_in_the_recording(start, peer, file, tmp_path):
    folder = tmp_path / "robot"
    folder.mkdir()
    corners = "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    (folder / "tip.obj").write_text(corners)
    description = two_link.description().replace(SPHERE, '<mesh filename="tip.obj"/>')
    assert "tip.obj" in description
    (folder / "robot.urdf").write_text(description)
    (folder / "wall.obj").write_text(corners)
    (folder / "world.yaml").write_text(WORLD)
    cell = start("--world", folder / "world.yaml", urdf=folder / "robot.urdf", parameters=recorded(file))
    cell.evaluate(**FOLDED)
    several_answers(cell)
    ended(cell)
    shutil.rmtree(folder)

    assert same(file) > 1


def test_other_readers_see_what_subscribers_saw(start, peer, file):
    cell = start(parameters=recorded(file))
    cell.evaluate(**FOLDED)
    hit = cell.evaluate(**COLLIDING)
    ended(cell)

    states = messages(file, cell.node.private("state"))
    read = next(state for state in states if state.header.stamp.nanosec == hit.header.stamp.nanosec)
    assert read.status == CollisionState.COLLIDING
    assert [(pair.body_a, pair.body_b) for pair in read.colliding_pairs] == [("base", "tip")]
    assert read.nearest.distance == 0.0 and read.pairs_checked == hit.pairs_checked
    joints = messages(file, cell.node.relative("joint_states"))
    assert list(joints[0].name) == ["joint1", "joint2"]
    assert len(messages(file, cell.node.private("is_free"))) == len(states)
    # what the wheels decode is what the node meant
    assert steps(file, cell.node)[-1] == {"ended": {"why": "the node ended"}}


def test_a_tampered_result_is_reported_and_becomes_a_test(start, peer, file, tmp_path):
    cell = start(parameters=recorded(file))
    cell.evaluate(**FOLDED)
    cell.evaluate(joint1=0, joint2=0)
    several_answers(cell)
    ended(cell)
    responses = len(messages(file, cell.node.private("is_free")))
    number = responses - 1

    copy, topic = tmp_path / "tampered.mcap", cell.node.private("is_free")
    tampered(file, copy, topic, number, lambda data: data[:-1] + bytes([1 - data[-1]]))
    case = tmp_path / "case"
    done = replay(copy, "--save-test", case)

    assert done.returncode == 1
    assert f"answer {number + 1} " in done.stdout and "is_free" in done.stdout
    assert "recorded: false\n  replayed: true" in done.stdout
    part = outcome(case / "recording.mcap")
    assert part["difference"]["field"] == "is_free"
    assert part["same"] <= number
    assert replay(copy, "--save-test", case).returncode == 2
    assert replay(file, "--save-test", tmp_path / "none").returncode == 0
    assert not (tmp_path / "none").exists()


def test_a_node_that_is_killed_leaves_what_it_recorded(start, peer, file):
    cell = start(parameters=recorded(file))
    cell.evaluate(**FOLDED)
    # what is older than a second or so is on the disk
    peer.wait_for(lambda: file.stat().st_size > 5000, "something on the disk")
    cell.node.kill()

    result = outcome(file)
    assert result["same"] > 0 and result["difference"] is None and result["cut_off"], result


@pytest.mark.parametrize("content", [b"", b"no recording at all", b"\x89MCAP0\r\n" + b"\xff" * 100])
def test_what_is_no_recording_is_rejected_with_its_name(file, content):
    file.write_bytes(content)
    done = replay(file)
    assert done.returncode == 2
    assert str(file) in done.stderr and done.stdout == ""


def test_a_recording_of_someone_else_is_rejected(start, peer, file, tmp_path):
    cell = start(parameters=recorded(file))
    cell.evaluate(**FOLDED)
    ended(cell)
    copy, topic = tmp_path / "other.mcap", cell.node.private("recording")
    tampered(file, copy, topic, 0, lambda data: data.replace(b"started", b"stopped"))
    done = replay(copy)
    assert done.returncode == 2
    assert "no step of this version" in done.stderr


def test_a_file_that_can_not_be_made_ends_the_node_at_once(domain_id, tmp_path):
    node = NodeProcess("--urdf", two_link.URDF, "--record", tmp_path / "no" / "run.mcap", domain_id=domain_id)
    with node:
        assert node._process.wait(20) == 2
        node._asked_to_end = True
        assert "record_file" in node.output() and "run.mcap" in node.output()


def test_recordings_begin_at_the_start_and_never_replace_one_another(start, peer, file):
    file.write_bytes(b"precious")
    cell = start(parameters=recorded(file))
    cell.evaluate(**FOLDED)
    (result,) = cell.parameters.set(record_file="elsewhere.mcap")
    assert not result.successful and "at the start only" in result.reason
    (descriptor,) = cell.parameters.describe("record_file")
    assert descriptor.read_only
    ended(cell)
    assert file.read_bytes() == b"precious"
    assert same(file.with_name("run_1.mcap")) > 0


def test_a_recording_ends_at_its_limit_and_the_node_goes_on(start, peer, file):
    cell = start(parameters=recorded(file, record_max_size=0.02))
    cell.evaluate(**FOLDED)
    peer.wait_for(lambda: "record_max_size" in cell.node.output(), "the end of the recording")
    cell.evaluate(joint1=0, joint2=0)
    assert same(file) > 0


def test_a_limit_of_file_sizes_ends_the_recording_and_not_the_node(start, peer, file):
    limited = ["sh", "-c", 'ulimit -f 40; exec "$@"', "sh"]
    cell = start(parameters=recorded(file), prefix=limited)
    cell.evaluate(**FOLDED)
    peer.wait_for(lambda: "run.mcap ended: " in cell.node.output(), "the end of the recording")
    assert "File too large" in cell.node.output()
    state = cell.states.ever(lambda state: any("File too large" in text for text in state.warnings), "a warning")
    assert state.status == CollisionState.FREE
    assert cell.node.stop() == INCOMPLETE
    assert "is complete" not in cell.node.output()
    result = outcome(file)
    assert result["difference"] is None and result["cut_off"], result


def test_a_robot_that_was_rejected_is_rejected_again(start, peer, file):
    topic = "/refused/robot_description"
    mesh = '<mesh filename="package://nowhere/tip.stl"/>'
    peer.latch(String(data=two_link.description().replace(SPHERE, mesh)), topic)
    cell = start(urdf=None, namespace="/refused", parameters=recorded(file))
    cell.states.ever(lambda state: "nowhere/tip.stl" in state.reason, "the fault")
    ended(cell)

    assert same(file) > 0


def test_a_recording_that_can_not_be_written_is_a_warning_while_it_lasts(start, peer, tmp_path):
    folder = tmp_path / "disk"
    folder.mkdir()
    diagnostics = peer.record(DiagnosticArray, "/diagnostics")
    cell = start(parameters=recorded(folder / "run.mcap"))
    assert cell.evaluate(**FOLDED).warnings == []

    def warns(state):
        return any("run.mcap was moved or removed" in text for text in state.warnings)

    folder.rename(tmp_path / "gone")
    state = cell.states.ever(warns, "a warning of the recording")
    assert state.status == CollisionState.FREE
    diagnostics.ever(
        lambda array: any("moved or removed" in item.value for status in array.status for item in status.values), "the same"
    )
    (tmp_path / "gone").rename(folder)
    cell.states.wait_for(lambda state: not warns(state), "no warning", after=cell.peer.now())
    ended(cell)
    # warnings of the recording are no part of it
    assert same(folder / "run.mcap") > 0
