"""Tests of `planning_scene` and `planning_scene_world`: whole scenes and differences, as MoveIt reads them.

With both joints at zero the ball of the tip, of radius 0.1, is around (2, 0, 0).
"""

from math import nan, pi

import pytest
from clearance_msgs.msg import CollisionState
from moveit_msgs.msg import AllowedCollisionEntry, CollisionObject, PlanningScene, PlanningSceneWorld
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import String

import two_link
from scene import attached, ball, diff, full, matrix, move, pose, removal
from scene_client import KEPT, SceneClient, bodies, colliding, distance, distances

ACCURACY = 1e-6  # [m]
NEARBY = {"influence_distance": 0.5, "distance_limit": 3.0}
NEIGHBOURS = ("base", "upper"), ("upper", "tip")
STRETCHED = {"joint1": 0, "joint2": 0}
ON_BASE = {"joint1": 0, "joint2": pi}  # the ball of the tip in the cube of the base

SRDF = """
<robot name="two_link">
  <disable_collisions link1="base" link2="upper" reason="Adjacent"/>
  <disable_collisions link1="upper" link2="tip" reason="Adjacent"/>
  <disable_collisions link1="base" link2="tip" reason="User"/>
</robot>
"""


@pytest.fixture
def cell(start):
    cell = start(parameters=NEARBY)
    cell.evaluate(**STRETCHED)
    return cell


@pytest.fixture
def permissive(start, tmp_path):
    """A node with an SRDF that leaves out the one pair that can touch."""
    path = tmp_path / "two_link.srdf"
    path.write_text(SRDF)
    cell = start("--srdf", path, parameters=NEARBY)
    cell.evaluate(**STRETCHED)
    return cell


def test_where_a_scene_is_required_nothing_is_free_before_one_came(start):
    cell = start(parameters=NEARBY | {"require_planning_scene": True})
    assert "planning_scene" in cell.unknown("stale_world").reason
    scene = SceneClient(cell)
    assert scene.apply(diff(ball("a", 9.0)))
    cell.unknown("stale_world")
    scene.topic(PlanningScene, "planning_scene").publish(full())
    cell.becomes(CollisionState.FREE, "FREE")


def names(state):
    """Of the obstacles and attached objects near the tip."""
    return {name for pair in distances(state) for name in pair} - {"base", "upper", "tip"}


@pytest.mark.parametrize("durability", [DurabilityPolicy.VOLATILE, DurabilityPolicy.TRANSIENT_LOCAL])
def test_a_diff_adds_moves_and_removes(cell, scene, durability):
    scene.topic(PlanningScene, "planning_scene", QoSProfile(depth=10, durability=durability))
    state = scene.change(diff(ball("a", 2.3), ball("b", 2.3, 0.3)))
    assert names(state) == {"a", "b"}

    state = scene.change(diff(removal("b"), move("a", pose(2.4)), ball("c", 2.3, -0.3)))
    assert names(state) == {"a", "c"}
    assert distance(state, "tip", "a") == pytest.approx(0.2, abs=ACCURACY)


def test_a_diff_comes_into_force_as_a_whole(cell, scene):
    """No state is judged of a world in which the obstacle has left one side and not yet come to the other."""
    first = scene.change(ball("left", 2.3, 0.3))
    for _ in range(5):
        scene.change(diff(removal("left"), ball("right", 2.3, -0.3)))
        scene.change(diff(removal("right"), ball("left", 2.3, 0.3)))
    assert all(len(names(state)) == 1 for state in cell.states.after(first))


def test_a_full_scene_replaces_the_one_before(cell, scene):
    scene.change(ball("a", 2.3), attached("tip", ball("part", 1, 0.4, frame="tip"), ["tip"]))
    message = full(ball("b", 2.3, 0.3), allowed=matrix(*NEIGHBOURS))
    # Where the robot is, the joint states say and no scene.
    message.robot_state.joint_state.name = list(two_link.JOINTS)
    message.robot_state.joint_state.position = [0.0, pi]
    state = scene.change(message)

    assert state.status == CollisionState.FREE
    assert names(state) == {"b"}
    assert scene.get("ROBOT_STATE_ATTACHED_OBJECTS").robot_state.attached_collision_objects == []


def test_the_robot_state_of_a_scene_places_the_frames_of_links(cell, scene):
    """As in MoveIt: an object in the frame of the tip is where the message's joint positions put the tip, not the robot's."""
    message = diff(ball("a", 1.3, frame="tip"))
    message.robot_state.joint_state.name = ["joint1"]
    message.robot_state.joint_state.position = [pi / 2]
    assert distance(scene.change(message), "tip", "a") is None
    state = cell.evaluate(joint1=pi / 2, joint2=0)
    assert distance(state, "tip", "a") == pytest.approx(0.1, abs=ACCURACY)
    cell.evaluate(**STRETCHED)
    for name, positions in (("joint", [0.0]), ("joint1", [nan]), ("joint1", [])):
        message.robot_state.joint_state.name = [name]
        message.robot_state.joint_state.position = positions
        assert not scene.apply(message)


def test_a_full_scene_keeps_what_is_held_if_its_robot_state_is_a_diff(scene):
    scene.change(attached("tip", ball("part", 1, 0.4, frame="tip"), ["tip"]))
    message = full(ball("b", 2.3, 0.3), allowed=matrix(*NEIGHBOURS))
    message.robot_state.is_diff = True
    scene.change(message)
    (held,) = scene.get("ROBOT_STATE_ATTACHED_OBJECTS").robot_state.attached_collision_objects
    assert held.object.id == "part"


def test_a_world_replaces_all_obstacles_and_nothing_else(scene):
    scene.change(ball("a", 2.3), attached("tip", ball("part", 1, 0.4, radius=0.05, frame="tip"), ["tip"]))
    state = scene.change(PlanningSceneWorld(collision_objects=[ball("b", 2, 0.6, radius=0.05)]))
    assert distance(state, "tip", "a") is None
    assert distance(state, "part", "b") == pytest.approx(0.1, abs=ACCURACY)


def test_a_scene_attaches_and_detaches(cell, scene):
    scene.change(diff(attached=[attached("tip", ball("part", 1, 0.4, radius=0.05, frame="tip"), ["tip"])]))
    state = cell.evaluate(joint1=0, joint2=5 * pi / 6)
    assert colliding(state) == [{("link", "base"), ("attached", "part")}]

    let_go = attached("", CollisionObject(id="part", operation=CollisionObject.REMOVE))
    cell.evaluate(**STRETCHED)
    # Detached into the world and in the same scene taken out of it.
    state = scene.change(diff(removal("part"), attached=[let_go]))
    assert names(state) == set()


def test_what_is_right_in_a_diff_comes_into_force_and_the_rest_is_complained_about(cell, scene):
    cell.parameters.succeed(rejected_obstacle="warn")
    scene.complaints.forget()
    state = scene.change(diff(ball("a", 2.3), ball("thing", 0.3, frame="nowhere"), ball("b", 2.3, 0.3)))
    assert names(state) == {"a", "b"}
    scene.complaints.wait_for("thing", "nowhere")


def test_padding_and_scale_of_a_link(scene):
    scene.change(ball("a", 2.3))
    state = scene.change(diff(padding={"tip": 0.04}))
    assert distance(state, "tip", "a") == pytest.approx(0.06, abs=ACCURACY)
    state = scene.change(diff(padding={"tip": 0.11}))
    assert colliding(state) == [{("link", "tip"), ("obstacle", "a")}]
    # Every shape is scaled about its own middle: the rod, from 0 to 1 in the tip's frame, reaches 0.25 farther, to x = 2.25.
    state = scene.change(diff(move("a", pose(2.45)), padding={"tip": 0.0}, scale={"tip": 1.5}))
    assert distance(state, "tip", "a") == pytest.approx(0.1, abs=ACCURACY)


def test_a_scene_that_pads_less_takes_nothing_off_the_parameter(start):
    """MoveIt's scenes have an entry for every link, most of them zero."""
    cell = start(parameters=NEARBY | {"padding": 0.05})
    cell.evaluate(joint1=0, joint2=0)
    scene = SceneClient(cell)
    assert distance(scene.change(ball("a", 2.3)), "tip", "a") == pytest.approx(0.05, abs=ACCURACY)
    state = scene.change(diff(padding={"tip": 0.0}))
    assert distance(state, "tip", "a") == pytest.approx(0.05, abs=ACCURACY)
    state = scene.change(diff(padding={"tip": 0.07}))
    assert distance(state, "tip", "a") == pytest.approx(0.03, abs=ACCURACY)


def test_what_a_link_holds_grows_with_it(scene):
    scene.change(attached("tip", ball("part", 1.3, frame="tip")), ball("a", 2.7))
    state = scene.change(diff(scale={"tip": 1.5}))
    assert distance(state, "part", "a") == pytest.approx(0.15, abs=ACCURACY)


@pytest.mark.parametrize(
    "message",
    [diff(padding={"tip": nan}), diff(padding={"tip": -0.01}), diff(scale={"tip": 0.0}), diff(padding={"hand": 0.1})],
    ids=["no number", "negative", "scaled to nothing", "unknown link"],
)
def test_a_bad_padding_is_rejected_by_its_link(scene, message):
    (entry,) = message.link_padding or message.link_scale
    scene.rejected(message, entry.link_name)


def test_colours_disturb_nothing(scene):
    scene.complaints.forget()
    state = scene.change(diff(ball("a", 2.3), colors=["a", "not_there"]))
    assert names(state) == {"a"}
    scene.complaints.none_about("olour")
    scene.complaints.none_about("not_there")


def test_a_diff_without_a_matrix_leaves_the_matrix_alone(permissive):
    scene = SceneClient(permissive)
    state = scene.change(ball("a", 2.15))
    assert colliding(state) == [{("link", "tip"), ("obstacle", "a")}]

    state = scene.change(diff(allowed=matrix(*NEIGHBOURS, ("base", "tip"), ("tip", "a"))))
    assert state.status == CollisionState.FREE
    state = scene.change(diff(ball("b", 2.3, 0.3)), diff(move("a", pose(2.1))))
    assert state.status == CollisionState.FREE
    assert permissive.evaluate(**ON_BASE).status == CollisionState.FREE


def test_a_diff_with_a_matrix_replaces_the_whole_matrix(permissive):
    """As in MoveIt: pairs that the SRDF leaves out are checked again if the new matrix does not allow them."""
    scene = SceneClient(permissive)
    assert permissive.evaluate(**ON_BASE).status == CollisionState.FREE
    state = scene.change(diff(allowed=matrix(*NEIGHBOURS)))
    assert colliding(state) == [{("link", "base"), ("link", "tip")}]


def test_an_allowed_pair_is_skipped_and_counted(permissive):
    scene = SceneClient(permissive)
    state = scene.change(ball("a", 2.15))
    before = state.pairs_checked
    state = scene.change(diff(allowed=matrix(*NEIGHBOURS, ("base", "tip"), ("tip", "a"))))
    assert state.pairs_checked == before - 1
    assert state.pairs_skipped == sum(skipped.count for skipped in state.skipped)


def test_defaults_of_a_matrix(permissive):
    scene = SceneClient(permissive)
    part = attached("tip", ball("part", 1, 0.4, radius=0.05, frame="tip"), ["tip"])
    scene.change(part, ball("a", 2, 0.45))
    known = *NEIGHBOURS, ("base", "tip")
    state = scene.change(diff(allowed=matrix(*known, defaults={"a": True})))
    assert state.status == CollisionState.FREE
    # Between two defaults the one that forbids wins.
    state = scene.change(diff(allowed=matrix(*known, defaults={"a": True, "part": False})))
    assert colliding(state) == [{("attached", "part"), ("obstacle", "a")}]


def test_removing_an_object_forgets_what_it_was_allowed(permissive):
    scene = SceneClient(permissive)
    allowed = matrix(*NEIGHBOURS, ("base", "tip"), ("tip", "a"))
    assert scene.change(diff(ball("a", 2.15), allowed=allowed)).status == CollisionState.FREE
    state = scene.change(removal("a"), ball("a", 2.15))
    assert colliding(state) == [{("link", "tip"), ("obstacle", "a")}]


def test_a_matrix_that_is_rejected_leaves_nothing_allowed_that_it_may_have_taken_back(permissive):
    scene = SceneClient(permissive)
    scene.change(diff(ball("a", 2.15), allowed=matrix(*NEIGHBOURS, ("base", "tip"), ("tip", "a"))))
    cut = matrix(*NEIGHBOURS)
    cut.entry_values[0] = AllowedCollisionEntry(enabled=[True])
    seen = permissive.peer.now()
    scene.rejected(diff(allowed=cut), "allowed_collision_matrix")
    assert "allowed_collision_matrix" in permissive.unknown("rejected_obstacle", after=seen).reason
    scene.change(diff(allowed=matrix(*NEIGHBOURS)))
    permissive.states.wait_for(
        lambda state: state.status == CollisionState.COLLIDING, "a judgement", after=permissive.peer.now()
    )


def test_a_matrix_that_is_not_square_is_rejected(permissive):
    scene = SceneClient(permissive)
    for cut in (matrix(*NEIGHBOURS), matrix(*NEIGHBOURS, defaults={"tip": True})):
        if cut.default_entry_names:
            cut.default_entry_values = []
        else:
            cut.entry_values[0] = AllowedCollisionEntry(enabled=[True])
        scene.rejected(diff(allowed=cut), "allowed_collision_matrix")
    assert permissive.evaluate(**ON_BASE).status == CollisionState.FREE


def test_a_new_model_keeps_the_world(peer, start):
    namespace = "/swapped"
    publisher = peer.latch(String(data=two_link.description()), f"{namespace}/robot_description")
    cell = start(urdf=None, namespace=namespace, parameters=NEARBY)
    cell.has_model()
    cell.evaluate(**STRETCHED)
    scene = SceneClient(cell)
    scene.change(ball("a", 2.3), attached("tip", ball("part", 1, 0.4, radius=0.05, frame="tip"), ["tip"]))

    publisher.publish(String(data=two_link.description_with_cube(0.3)))
    cell.has_model(2)
    state = cell.evaluate(**STRETCHED)
    assert distance(state, "tip", "a") == pytest.approx(0.1, abs=ACCURACY)
    assert state.pairs_checked > 4
    assert bodies(state.nearest.pair) == {("link", "tip"), ("obstacle", "a")}


class Mirror:
    """The names of the obstacles of a monitored scene, kept as RViz does: whole scenes replace, others change."""

    def __init__(self):
        self.names = set()
        self._folded = 0

    def fold(self, messages):
        for message in messages[self._folded :]:
            if not message.is_diff:
                self.names.clear()
            for item in message.world.collision_objects:
                (self.names.discard if item.operation == CollisionObject.REMOVE else self.names.add)(item.id)
        self._folded = len(messages)
        return self.names


def test_the_monitored_scene_follows(cell, scene):
    reported = cell.peer.record(PlanningScene, cell.node.relative("monitored_planning_scene"))
    cell.peer.wait_for(
        lambda: cell.peer.node.count_publishers(cell.node.relative("monitored_planning_scene")), "the topic"
    )
    mirror = Mirror()
    for message, expected in (
        (ball("a", 2.3), {"a"}),
        (diff(ball("b", 2.3, 0.3), ball("c", 2.3, -0.3)), {"a", "b", "c"}),
        (removal("b"), {"a", "c"}),
        (full(ball("d", 2.3), allowed=matrix(*NEIGHBOURS)), {"d"}),
    ):
        scene.change(message)
        cell.peer.wait_for(
            lambda expected=expected: mirror.fold(reported.all()) == expected, f"{expected} in the monitored scene"
        )
    moved = ball("d", 2.4)
    moved.operation = CollisionObject.MOVE
    moved.primitives = []
    scene.change(diff(moved))
    moves = lambda: [  # noqa: E731
        (item.id, len(item.primitives), item.pose.position.x)
        for message in reported.all()
        for item in message.world.collision_objects
        if item.operation == CollisionObject.MOVE
    ]
    cell.peer.wait_for(lambda: moves() == [("d", 0, 2.4)], "the new pose without the shapes")


def test_a_burst_of_changes_ends_as_the_last_one_says(cell, scene):
    """As many as a queue holds, as fast as they can be sent."""
    publisher = scene.topic(CollisionObject, "collision_object", KEPT)
    for i in range(10):
        publisher.publish(ball(f"thing_{i}", 2.3, i))
    cell.peer.wait_for(lambda: len(scene.obstacles()) == 10, "ten obstacles")


def warned(cell, *words):
    """Waits until a state warns of this."""
    return cell.states.ever(
        lambda state: any(all(word in text for word in words) for text in state.warnings), f"a warning of {words}"
    )


def test_a_robot_without_checked_pairs_is_reported(permissive):
    """Whatever it does counts as free."""
    warned(permissive, "there is no pair to check: every state counts as free")
    scene = SceneClient(permissive)
    state = scene.change(ball("a", 9))
    assert not any("no pair" in text for text in state.warnings)


def test_touch_links_and_entries_that_name_nothing_are_warnings(cell, scene):
    part = ball("part", 1, 0.4, radius=0.05, frame="tip")
    scene.change(attached("tip", part, ["tip", "finger"]))
    warned(cell, "'part'", "touch_links", "'finger'")
    scene.change(diff(allowed=matrix(*NEIGHBOURS, ("tip", "gone"), defaults={"away": True})))
    warned(cell, "allowed_collision_matrix", "'away' and 'gone'")
    scene.publish(diff(allowed=matrix(defaults={"part": True})))
    warned(cell, "default entries alone")
    # a name that comes to stand for something is warned of no more
    scene.change(diff(ball("gone", 9), ball("away", 9), allowed=matrix(*NEIGHBOURS, ("tip", "gone"), defaults={"away": True})))
    scene.change(attached("tip", part, ["tip"]))
    cell.states.wait_for(lambda state: state.warnings == [], "no warning", after=cell.peer.now())
