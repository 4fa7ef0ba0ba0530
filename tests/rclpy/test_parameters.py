"""Tests of parameters: by file, by command line, and while the node runs by the standard services."""

from contextlib import ExitStack
from itertools import cycle
from math import inf, pi

import pytest
import yaml
from clearance_msgs.msg import CollisionState
from rcl_interfaces.msg import ParameterEvent, ParameterType
from rclpy.node import Node

import two_link
from cell import QUICK, STALE_AFTER, Companions
from node_process import ROOT, NodeProcess
from parameters import Parameters
from peer import Peer

TYPES = {
    ParameterType.PARAMETER_BOOL,
    ParameterType.PARAMETER_DOUBLE,
    ParameterType.PARAMETER_INTEGER,
    ParameterType.PARAMETER_STRING,
    ParameterType.PARAMETER_DOUBLE_ARRAY,
    ParameterType.PARAMETER_STRING_ARRAY,
}
NAMES = {"heartbeat_rate", "stale_after", "influence_distance", "distance_limit", "padding", "publish_markers"}


def test_every_parameter_is_listed_described_and_of_its_type(cell):
    names = sorted(cell.parameters.names())
    assert NAMES <= set(names)

    for name, descriptor in zip(names, cell.parameters.describe(*names), strict=True):
        assert descriptor.name == name
        assert descriptor.type in TYPES
        assert descriptor.description
    assert cell.parameters.get("heartbeat_rate", "stale_after", "publish_markers") == [20.0, QUICK["stale_after"], True]


def test_the_influence_distance_changes_live(start):
    cell = start(parameters={"influence_distance": 0.1})
    assert cell.evaluate(joint1=0, joint2=5 * pi / 6).pair_distances == []

    cell.parameters.succeed(influence_distance=0.5)
    assert cell.parameters.get("influence_distance") == [0.5]
    state = cell.evaluate(joint1=0, joint2=5 * pi / 6)
    assert [pair.distance for pair in state.pair_distances] == [pytest.approx(0.2)]


def test_the_distance_limit_changes_live(start):
    cell = start(parameters={"distance_limit": 0.5, "influence_distance": 0.1})
    companions = Companions(cell)
    state = cell.evaluate(joint1=0, joint2=0)
    assert state.status == CollisionState.FREE
    assert not state.distance_known
    assert companions.of(state)["distance"] == inf

    cell.parameters.succeed(distance_limit=1.0)
    state = cell.evaluate(joint1=0, joint2=0)
    assert state.distance_known
    assert companions.of(state)["distance"] == pytest.approx(0.7)


def test_a_tolerance_makes_distances_too_small_if_anything(start):
    cell = start(parameters={"distance_limit": 1.0, "distance_relative_tolerance": 0.5})
    for folded in (0, 5 * pi / 6):
        tolerant = cell.evaluate(joint1=0, joint2=folded)
        cell.parameters.succeed(distance_relative_tolerance=0.0)
        exact = cell.evaluate(joint1=0, joint2=folded)
        assert tolerant.status == exact.status == CollisionState.FREE
        assert 0.5 * exact.nearest.distance <= tolerant.nearest.distance < exact.nearest.distance
        cell.parameters.succeed(distance_relative_tolerance=0.5)


def test_staleness_changes_live(cell):
    cell.evaluate(joint1=0, joint2=0)
    last = cell.falls_silent()
    old = cell.states.wait_for(lambda state: state.age > STALE_AFTER + 0.1, "an old joint state", after=last)
    assert old.status == CollisionState.FREE

    cell.grows_old()
    cell.unknown("stale")


def test_a_change_is_reported_on_parameter_events(cell):
    """Nobody can know when the node has met a new listener of this volatile topic: changes are made until one is told."""
    events = cell.peer.record(ParameterEvent, "/parameter_events")
    values = cycle([2.0, 3.0])

    def reported():
        cell.parameters.succeed(stale_after=next(values))
        return [event for event in events.all() if event.node == cell.node.path and event.changed_parameters]

    for event in cell.peer.wait_for(reported, "a change on /parameter_events"):
        assert [parameter.name for parameter in event.changed_parameters] == ["stale_after"]


def test_a_parameter_file_sets_and_the_command_line_wins(start, tmp_path):
    path = tmp_path / "parameters.yaml"
    path.write_text("/**:\n  ros__parameters:\n    distance_limit: 3.0\n    influence_distance: 0.25\n")
    cell = start("--params-file", path, parameters={"influence_distance": 0.75})
    assert cell.parameters.get("distance_limit", "influence_distance") == [3.0, 0.75]


@pytest.mark.parametrize("section", ["/**", "clearance_of_the_file", "/cell/clearance_of_the_file"])
def test_a_parameter_file_among_the_ros_arguments(start, tmp_path, section):
    path = tmp_path / "parameters.yaml"
    path.write_text(f"{section}:\n  ros__parameters:\n    influence_distance: 0.25\n")
    namespace = "/cell" if section.startswith("/cell") else ""
    cell = start(ros_arguments=["--params-file", path], name="clearance_of_the_file", namespace=namespace)
    assert cell.parameters.get("influence_distance") == [0.25]


NAMED, ALL = "/cell/ordered:\n  ros__parameters: {heartbeat_rate: 20.0}\n", "/**:\n  ros__parameters: {heartbeat_rate: 30.0}\n"


@pytest.mark.parametrize(
    "sources",
    [
        [NAMED + ALL],
        [ALL + NAMED],
        [NAMED, ALL],
        [ALL, NAMED],
        ["heartbeat_rate:=40.0", ALL],
        ["heartbeat_rate:=40.0", NAMED],
        [ALL, "heartbeat_rate:=40.0"],
        [NAMED + ALL, "heartbeat_rate:=40.0"],
        ["ordered:heartbeat_rate:=50.0", "heartbeat_rate:=40.0"],
        ["heartbeat_rate:=40.0", "other:heartbeat_rate:=60.0"],
    ],
)
def test_the_last_value_applies_as_in_other_nodes(start, peer, tmp_path, sources):
    words = []
    for number, source in enumerate(sources):
        path = tmp_path / f"{number}.yaml"
        path.write_text(source)
        words += ["-p", source] if ":=" in source else ["--params-file", str(path)]
    arguments = {"cli_args": ["--ros-args", *words], "use_global_arguments": False, "start_parameter_services": False}
    overrides = {"automatically_declare_parameters_from_overrides": True}
    other = Node("ordered", context=peer.node.context, namespace="/cell", **arguments, **overrides)
    expected = other.get_parameter("heartbeat_rate").value
    other.destroy_node()
    cell = start(ros_arguments=words, name="ordered", namespace="/cell")
    assert cell.parameters.get("heartbeat_rate") == [expected]


def test_parameters_of_other_nodes_may_have_any_name(start, tmp_path):
    path = tmp_path / "parameters.yaml"
    path.write_text("/**:\n  ros__parameters: {target: {x: 1.0, y: 2.0, on: 3.0, 7: true}, influence_distance: 0.25}\n")
    assert start(ros_arguments=["--params-file", path]).parameters.get("influence_distance") == [0.25]


def test_a_parameter_file_for_another_node_changes_nothing(start, tmp_path):
    path = tmp_path / "parameters.yaml"
    path.write_text("another_node:\n  ros__parameters:\n    influence_distance: 0.25\n")
    cell = start(ros_arguments=["--params-file", path])
    assert cell.parameters.get("influence_distance") != [0.25]


def test_the_manual_holds_every_parameter_with_its_default(peer):
    (section,) = yaml.safe_load((ROOT / "config/clearance.yaml").read_text()).values()
    manual = section["ros__parameters"]
    with NodeProcess("--urdf", two_link.URDF, domain_id=peer.domain_id) as node:
        parameters = Parameters(peer, node)
        assert parameters.names() == set(manual)
        assert dict(zip(manual, parameters.get(*manual), strict=True)) == manual


def test_requests_sent_as_soon_as_the_services_are_seen_get_responses(cell):
    """As `ros2 param` does: every call comes from a process that met the node a moment ago."""
    with ExitStack() as peers:
        asked = []
        for _ in range(5):
            peer = peers.enter_context(Peer(cell.peer.domain_id))
            asked.append((peer, Parameters(peer, cell.node).ask("stale_after")))
        for peer, future in asked:
            assert peer.result(future).values[0].double_value == QUICK["stale_after"]
