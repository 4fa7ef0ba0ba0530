"""Tests of octomaps, binary and full, from the topics of octomap_server and inside scenes.

With both joints at zero the ball of the tip, of radius 0.1, is around (2, 0, 0). A voxel of 0.1 around (2.25, 0.05, 0.05)
begins at x = 2.2, with an edge on the x axis.
"""

from math import pi, sqrt

import pytest
from clearance_msgs.msg import CollisionState
from moveit_msgs.msg import PlanningSceneWorld
from octomap_msgs.msg import Octomap
from rclpy.duration import Duration

from octree import DEPTH, FREE, OCCUPIED, Octree
from scene import ball, diff, full, matrix, pose
from scene_client import KEPT, SceneClient, bodies, colliding, distance

ACCURACY = 1e-6  # [m]
NAME = "<octomap>"
STRETCHED = {"joint1": 0, "joint2": 0}
NEARBY = {"influence_distance": 0.5, "distance_limit": 3.0}
TOPICS = {True: "octomap_binary", False: "octomap_full"}


@pytest.fixture
def cell(start):
    cell = start(parameters=NEARBY)
    cell.evaluate(**STRETCHED)
    return cell


def octree(*centres, resolution=0.1, state=OCCUPIED):
    tree = Octree(resolution)
    for centre in centres:
        tree.set(state, *centre)
    return tree


NEAR = octree((2.25, 0.05, 0.05))
FAR = octree((3, 3, 3))


def both(test):
    return pytest.mark.parametrize("binary", [True, False], ids=["binary", "full"])(test)


def near(state):
    return distance(state, "tip", NAME)


@both
def test_occupied_voxels_are_obstacles(scene, binary):
    state = scene.change(NEAR.message(binary), topic=TOPICS[binary])
    assert state.status == CollisionState.FREE
    assert near(state) == pytest.approx(0.1, abs=ACCURACY)
    assert bodies(state.nearest.pair) == {("link", "tip"), ("obstacle", NAME)}

    state = scene.change(octree((2.15, 0.05, 0.05), (3, 3, 3)).message(binary), topic=TOPICS[binary])
    assert near(state) == pytest.approx(0, abs=ACCURACY)
    state = scene.change(octree((2.05, 0.05, 0.05)).message(binary), topic=TOPICS[binary])
    assert colliding(state) == [{("link", "tip"), ("obstacle", NAME)}]


@both
def test_every_octant_is_where_it_belongs(cell, scene, binary):
    """A voxel on each side of each axis, around where the ball of the tip can be taken."""
    for x, y, joint1 in ((2.25, 0.05, 0), (-2.25, -0.05, pi), (-0.05, 2.25, pi / 2), (0.05, -2.25, -pi / 2)):
        for z in (0.05, -0.05):
            scene.change(octree((x, y, z)).message(binary), topic=TOPICS[binary])
            state = cell.evaluate(joint1=joint1, joint2=0)
            assert near(state) == pytest.approx(0.1, abs=ACCURACY), (x, y, z)


@both
def test_free_voxels_are_none(scene, binary):
    tree = octree((2.05, 0.05, 0.05), (1.05, 0.05, 0.05), state=FREE).set(OCCUPIED, 2.25, 0.05, 0.05)
    state = scene.change(tree.message(binary), topic=TOPICS[binary])
    assert state.status == CollisionState.FREE
    assert near(state) == pytest.approx(0.1, abs=ACCURACY)


@both
def test_a_large_leaf_fills_all_that_it_covers(scene, binary):
    # Two levels up a voxel is 0.4 wide: this one from (2.4, 0, 0) to (2.8, 0.4, 0.4).
    tree = Octree(0.1).set(OCCUPIED, 2.5, 0.1, 0.1, depth=DEPTH - 2)
    state = scene.change(tree.message(binary), topic=TOPICS[binary])
    assert near(state) == pytest.approx(0.3, abs=ACCURACY)


def test_the_two_streams_of_a_tree_say_the_same(scene):
    centres = [(2.25 + i % 3 / 10, (i // 3 % 5 - 2) / 10 + 0.05, (i // 15 - 2) / 10 + 0.05) for i in range(0, 75, 2)]
    tree = octree(*centres).set(FREE, 2.05, 0.05, 0.05)
    one = near(scene.change(tree.message(True), topic="octomap_binary"))
    other = near(scene.change(tree.message(False), topic="octomap_full"))
    assert one == other == pytest.approx(0.1, abs=ACCURACY)


@both
def test_a_new_map_replaces_the_old_one(scene, binary):
    scene.change(NEAR.message(binary), topic=TOPICS[binary])
    state = scene.change(octree((2.45, 0.05, 0.05)).message(binary), topic=TOPICS[binary])
    assert near(state) == pytest.approx(0.3, abs=ACCURACY)


def test_a_map_in_the_frame_of_a_link(cell, scene):
    state = scene.change(octree((1.25, 0.05, 0.05)).message(frame="tip"), topic="octomap_binary")
    assert near(state) == pytest.approx(0.1, abs=ACCURACY)
    cell.evaluate(joint1=0, joint2=pi / 2)
    assert near(cell.evaluate(**STRETCHED)) == pytest.approx(0.1, abs=ACCURACY)


def test_a_map_in_a_scene_has_a_pose(scene):
    message = diff(ball("a", 2.3, -0.3))
    # Turned by 45 degrees about the corner that touches the x axis, so that an edge points to the ball.
    message.world.octomap = octree((0.05, 0.05, 0.05)).message_with_pose(pose(2.2, 0, 0, angle=-pi / 4))
    state = scene.change(message)
    assert near(state) == pytest.approx(0.1, abs=ACCURACY)

    # The other way about, so that the opposite edge does.
    far = pose(2.2 + 0.1 * sqrt(2), 0, 0, angle=3 * pi / 4)
    message.world.octomap = octree((0.05, 0.05, 0.05)).message_with_pose(far)
    state = scene.change(message)
    assert near(state) == pytest.approx(0.1, abs=ACCURACY)


def test_a_diff_without_a_map_keeps_it_and_a_world_without_one_does_not(scene):
    scene.change(NEAR.message(), topic="octomap_binary")
    state = scene.change(diff(ball("a", 2.3, -0.3)))
    assert near(state) == pytest.approx(0.1, abs=ACCURACY)

    state = scene.change(PlanningSceneWorld(collision_objects=[ball("a", 2.3, -0.3)]))
    assert near(state) is None


def test_a_whole_scene_without_a_map_keeps_that_of_a_sensor_unless_a_client_applies_it(cell, scene):
    """The scene of another node comes without the map of this node's sensor."""
    whole = full(ball("a", 2.3, -0.3), allowed=matrix(("base", "upper"), ("upper", "tip")))
    scene.change(NEAR.message(), topic="octomap_binary")
    assert near(scene.change(whole)) == pytest.approx(0.1, abs=ACCURACY)
    assert scene.apply(whole)
    assert near(cell.evaluate(**STRETCHED)) is None

    # a map of a scene is a part of that scene
    message = diff()
    message.world.octomap = NEAR.message_with_pose(pose())
    assert near(scene.change(message)) == pytest.approx(0.1, abs=ACCURACY)
    assert near(scene.change(whole)) is None


def test_a_diff_with_an_empty_map_takes_it_away(scene):
    scene.change(NEAR.message(), topic="octomap_binary")
    message = diff()
    message.world.octomap.octomap.id = "OcTree"
    assert near(scene.change(message)) is None


def test_clear_octomap(cell, scene):
    scene.change(octree((2.05, 0.05, 0.05)).message(), topic="octomap_binary")
    scene.change(ball("a", 2.3, 0.3))
    assert cell.evaluate(**STRETCHED).status == CollisionState.COLLIDING

    scene.clear_octomap()
    state = cell.evaluate(**STRETCHED)
    assert state.status == CollisionState.FREE
    assert near(state) is None
    assert distance(state, "tip", "a") is not None
    # Twice does no harm.
    scene.clear_octomap()
    assert cell.evaluate(**STRETCHED).status == CollisionState.FREE


def test_the_map_is_reported_with_the_scene(scene):
    scene.change(NEAR.message(), topic="octomap_binary")
    reported = scene.get("OCTOMAP").world.octomap
    assert reported.octomap.id == "OcTree"
    assert reported.octomap.resolution == pytest.approx(0.1)
    scene.clear_octomap()
    assert len(scene.get("OCTOMAP").world.octomap.octomap.data) == 0

    message = diff()
    message.world.octomap = reported
    assert near(scene.change(message)) == pytest.approx(0.1, abs=ACCURACY)


def test_the_matrix_may_allow_the_map(scene):
    scene.change(octree((2.05, 0.05, 0.05)).message(), topic="octomap_binary")
    state = scene.change(diff(allowed=matrix(("base", "upper"), ("upper", "tip"), ("tip", NAME))))
    assert state.status == CollisionState.FREE


@both
@pytest.mark.parametrize("unknown", ["free", "occupied"])
def test_unknown_space_is_what_the_parameter_says(start, unknown, binary):
    cell = start(parameters=NEARBY | {"unknown_space": unknown})
    cell.evaluate(**STRETCHED)
    scene = SceneClient(cell)

    known = Octree(0.1).fill(FREE)
    assert scene.change(known.message(binary), topic=TOPICS[binary]).status == CollisionState.FREE

    # Nothing is known of one octant: what lies in it depends on the parameter.
    hole = Octree(0.1).fill(FREE, octants=range(7))
    state = scene.change(hole.message(binary), topic=TOPICS[binary])
    if unknown == "free":
        assert state.status == CollisionState.FREE
    else:
        assert state.status == CollisionState.COLLIDING
        assert all(("obstacle", NAME) in pair for pair in colliding(state))


def test_unknown_space_without_any_map_is_no_obstacle(start):
    """The parameter is about the gaps in a map."""
    cell = start(parameters=NEARBY | {"unknown_space": "occupied"})
    assert cell.evaluate(**STRETCHED).status == CollisionState.FREE


def test_a_map_does_not_grow_old_by_itself(start):
    cell = start(parameters=NEARBY)
    cell.evaluate(**STRETCHED)
    assert cell.parameters.get("octomap_ttl") == [0.0]


def test_a_map_that_went_stale_makes_the_state_unknown(start):
    cell = start(parameters=NEARBY)
    cell.evaluate(**STRETCHED)
    scene = SceneClient(cell)
    assert scene.change(NEAR.message(), topic="octomap_binary").status == CollisionState.FREE

    cell.parameters.succeed(octomap_ttl=1.0)
    state = cell.states.wait_for(
        lambda state: "octomap" in state.reason, "UNKNOWN for a stale map", after=cell.peer.now()
    )
    assert state.status == CollisionState.UNKNOWN
    cell.parameters.succeed(octomap_ttl=3600.0)
    assert scene.change(NEAR.message(), topic="octomap_binary").status == CollisionState.FREE


def test_a_latched_map_from_before_the_start_is_received(peer, start):
    peer.latch(NEAR.message(), "/early/octomap_binary")
    cell = start(parameters=NEARBY, namespace="/early")
    cell.driver.report(**STRETCHED)
    cell.states.ever(lambda state: near(state) == pytest.approx(0.1, abs=ACCURACY), "the map")


def altered(**fields):
    message = NEAR.message()
    for name, value in fields.items():
        setattr(message, name, value)
    return message


def with_data(data, binary=True):
    message = NEAR.message(binary)
    message.data = data
    return message


BROKEN = {
    "another kind of tree": altered(id="ColorOcTree"),
    "no kind": altered(id=""),
    "no resolution": altered(resolution=0.0),
    "a resolution that is no number": altered(resolution=float("nan")),
    "cut short": with_data(NEAR.message().data[:-1]),
    "deeper than a tree": with_data([-1] * 200),
    "full but cut short": with_data(NEAR.message(False).data[:-1], False),
    "full but deeper than a tree": with_data([0, 0, 0, 64, -1] * 40, False),
}


@pytest.mark.parametrize("fault", BROKEN)
def test_a_broken_map_makes_the_state_unknown_until_one_is_right(cell, scene, fault):
    scene.change(NEAR.message(), topic="octomap_binary")
    message = BROKEN[fault]
    seen = cell.peer.now()
    scene.rejected(message, "octomap", topic=TOPICS[message.binary])
    assert "octomap" in cell.unknown("rejected_obstacle", after=seen).reason
    # the last one is kept
    cell.parameters.succeed(rejected_obstacle="warn")
    state = scene.change(ball("a", 2.3, 0.3))
    assert near(state) == pytest.approx(0.1, abs=ACCURACY)
    cell.parameters.succeed(rejected_obstacle="unknown")
    scene.change(NEAR.message(), topic="octomap_binary")
    cell.states.wait_for(lambda state: state.status == CollisionState.FREE, "FREE", after=cell.peer.now())


def test_an_older_map_does_not_replace_a_newer_one(cell, scene):
    now = cell.peer.now()
    scene.change(NEAR.message(stamp=now), topic="octomap_binary")
    seen = cell.peer.now()
    scene.rejected(FAR.message(stamp=now - Duration(seconds=30)), "older than that of the last octomap", topic="octomap_binary")
    assert "octomap_binary" in cell.unknown("rejected_obstacle", after=seen).reason
    state = scene.change(NEAR.message(stamp=now + Duration(seconds=0.1)), topic="octomap_binary")
    assert (state.status, near(state)) == (CollisionState.FREE, pytest.approx(0.1, abs=ACCURACY))


def test_two_publishers_of_maps_are_not_taken_for_one(cell):
    topic = cell.node.relative("octomap_binary")
    one, other = (cell.peer.node.create_publisher(Octomap, topic, KEPT) for _ in range(2))
    cell.peer.wait_for(lambda: one.get_subscription_count() and other.get_subscription_count(), "the subscriptions")

    def seen_in(status, maps, reason=""):
        since = cell.peer.now()

        def sent_and_seen():
            for publisher, tree in maps:
                publisher.publish(tree.message(stamp=cell.peer.now()))
            return any(state.status == status and reason in state.reason for state in cell.states.after(since))

        return sent_and_seen

    cell.peer.wait_for(seen_in(CollisionState.FREE, [(one, NEAR)]), "FREE with one publisher")
    in_turn = seen_in(CollisionState.UNKNOWN, [(one, NEAR), (other, FAR)], "several publishers send on this topic")
    cell.peer.wait_for(in_turn, "UNKNOWN with two publishers")
    # one of them ends
    cell.peer.wait_for(seen_in(CollisionState.FREE, [(other, FAR)]), "FREE with one publisher again")


def blank():
    return Octomap(binary=True, id="OcTree", resolution=0.1)


def test_the_first_map_may_be_one_of_nothing(scene):
    """MoveIt publishes an empty one at its start."""
    assert scene.change(blank(), topic="octomap_binary").status == CollisionState.FREE


def test_a_map_of_nothing_after_one_of_something_is_blind(cell, scene):
    scene.change(NEAR.message(), topic="octomap_binary")
    seen = cell.peer.now()
    scene.publish(blank(), topic="octomap_binary")
    assert "no leaf" in cell.unknown("blind_cloud", after=seen).reason
    # the map before is in force beside that
    cell.parameters.succeed(blind_cloud="warn")
    cell.states.wait_for(lambda state: near(state) == pytest.approx(0.1, abs=ACCURACY), "the map", after=cell.peer.now())
    cell.parameters.succeed(blind_cloud="unknown")
    scene.clear_octomap()
    state = cell.states.wait_for(lambda state: state.status == CollisionState.FREE, "FREE", after=cell.peer.now())
    assert near(state) is None


def test_the_octree_of_a_file_stays_beside_a_map_of_nothing_and_is_reported(start, tmp_path):
    path = tmp_path / "map.bt"
    path.write_bytes(NEAR.file())
    cell = start("--world", path, parameters=NEARBY)
    assert near(cell.evaluate(**STRETCHED)) == pytest.approx(0.1, abs=ACCURACY)
    scene = SceneClient(cell)
    seen = cell.peer.now()
    scene.publish(blank(), topic="octomap_binary")
    assert "no leaf" in cell.unknown("blind_cloud", after=seen).reason

    reported = scene.get("OCTOMAP").world.octomap
    scene.clear_octomap()
    assert near(cell.becomes(CollisionState.FREE, "FREE without the octree")) is None
    assert cell.node.output().count("removes the octree of the world files") == 1
    message = diff()
    message.world.octomap = reported
    assert near(scene.change(message)) == pytest.approx(0.1, abs=ACCURACY)


def test_a_map_of_nothing_is_an_empty_one_if_that_is_wanted(start):
    cell = start(parameters=NEARBY | {"blind_cloud": "warn"})
    cell.evaluate(**STRETCHED)
    scene = SceneClient(cell)
    scene.change(NEAR.message(), topic="octomap_binary")
    state = scene.change(blank(), topic="octomap_binary")
    assert (state.status, near(state)) == (CollisionState.FREE, None)
    cell.states.ever(lambda state: any("no leaf" in text for text in state.warnings), "a warning")
