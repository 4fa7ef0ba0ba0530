"""`get_planning_scene`, `apply_planning_scene` and `check_state_validity` as MoveIt's clients use them.

With both joints at zero the ball of the tip, of radius 0.1, is around (2, 0, 0).
"""

from math import cos, nan, pi, sin

import pytest
from clearance_msgs.msg import CollisionState
from clearance_msgs.srv import CheckStates
from moveit_msgs.msg import Constraints, ContactInformation, JointConstraint, PlanningScene
from moveit_msgs.srv import ApplyPlanningScene, GetPlanningScene, GetStateValidity
from std_msgs.msg import Bool, String

from scene import (
    attached,
    ball,
    box,
    cube_mesh,
    cylinder,
    detachment,
    diff,
    fine_mesh,
    matrix,
    obstacle,
    plane,
    pose,
    removal,
    sphere,
    xyz,
)
from scene_client import SceneClient, bodies, colliding, distance, distances
from states import States
from two_link import JOINTS, description, description_with_fine_base

ACCURACY = 1e-6  # [m]
NEARBY = {"influence_distance": 0.5, "distance_limit": 3.0}
STRETCHED = {"joint1": 0, "joint2": 0}
FOLDED = {"joint1": 0, "joint2": 5 * pi / 6}
ON_BASE = {"joint1": 0, "joint2": pi}
HELD = attached("tip", ball("part", 1, 0.4, radius=0.05, frame="tip"), ["tip"])

# The group "wrist" moves the tip alone.
SRDF = """
<robot name="two_link">
  <group name="arm"><chain base_link="base" tip_link="tip"/></group>
  <group name="wrist"><joint name="joint2"/></group>
  <disable_collisions link1="base" link2="upper" reason="Adjacent"/>
  <disable_collisions link1="upper" link2="tip" reason="Adjacent"/>
</robot>
"""


@pytest.fixture
def cell(start, tmp_path):
    path = tmp_path / "two_link.srdf"
    path.write_text(SRDF)
    cell = start("--srdf", path, parameters=NEARBY)
    cell.judged(**STRETCHED)
    return cell


# get_planning_scene


def test_default_entries_of_the_srdf_are_reported_and_in_force(start, tmp_path):
    path = tmp_path / "two_link.srdf"
    path.write_text(
        """
<robot name="two_link">
  <disable_default_collisions link="tip"/>
  <enable_collisions link1="tip" link2="base"/>
  <disable_collisions link1="base" link2="upper" reason="Adjacent"/>
</robot>
"""
    )
    cell = start("--srdf", path, parameters=NEARBY)
    cell.judged(**STRETCHED)
    scene = SceneClient(cell)
    told = scene.get("ALLOWED_COLLISION_MATRIX").allowed_collision_matrix
    assert (list(told.default_entry_names), list(told.default_entry_values)) == (["tip"], [True])

    # An obstacle that comes later, and an object that another link holds, may touch the tip.
    state = scene.change(ball("a", 2.0), attached("base", ball("part", 2.0), ["base"]))
    assert state.status == CollisionState.COLLIDING, "the obstacle and the object touch each other"
    assert [{body for _, body in bodies(pair)} for pair in state.colliding_pairs] == [{"a", "part"}]
    state = scene.change(removal("a"))
    assert state.status == CollisionState.FREE
    reasons = {skipped.reason: skipped.count for skipped in state.skipped}
    assert reasons["disabled by the SRDF's disable_default_collisions"] == 2

    # An enabled pair is checked all the same.
    assert colliding(cell.judged(**ON_BASE)) == [{("link", "base"), ("link", "tip")}]



def test_all_that_was_said_of_the_world_is_told(scene):
    thing = obstacle(
        "thing",
        (box(0.1, 0.2, 0.3), pose(0.1)),
        (cylinder(0.2, 0.1), pose(0, 0.2, axis=(1, 1, 0), angle=0.5)),
        (cube_mesh(0.1), pose(0, 0, 0.3)),
        (plane(-1, 0, 0, 9), pose()),
        at=pose(3, 1, 0, axis=(1, 2, 3), angle=1.0),
        subframes={"hook": pose(0, 0.5)},
    )
    thing.type.key = "crate"
    scene.change(thing)
    told = scene.obstacles()["thing"]

    assert told.header.frame_id == "base"
    assert told.operation == thing.operation
    assert told.type == thing.type
    assert [(shape.type, list(shape.dimensions)) for shape in told.primitives] == [
        (shape.type, list(shape.dimensions)) for shape in thing.primitives
    ]
    assert (told.meshes, told.planes) == (thing.meshes, thing.planes)
    assert told.subframe_names == thing.subframe_names
    for field in ("primitive_poses", "mesh_poses", "plane_poses", "subframe_poses"):
        assert_poses(getattr(told, field), getattr(thing, field))
    assert_poses([told.pose], [thing.pose])


def assert_poses(told, said):
    for one, other in zip(told, said, strict=True):
        assert xyz(one.position) == pytest.approx(xyz(other.position), abs=1e-12)
        assert xyz(one.orientation) == pytest.approx(xyz(other.orientation), abs=1e-12)


def test_only_the_components_that_are_asked_for(cell, scene):
    scene.change(diff(ball("a", 2.3), padding={"tip": 0.01}, attached=[HELD]))

    (named,) = scene.get("WORLD_OBJECT_NAMES").world.collision_objects
    assert (named.id, named.primitives) == ("a", [])
    settings = scene.get("SCENE_SETTINGS")
    assert settings.robot_model_name == "two_link"
    assert settings.world.collision_objects == []
    state = scene.get("ROBOT_STATE").robot_state
    assert dict(zip(state.joint_state.name, state.joint_state.position, strict=True)) == STRETCHED
    assert state.attached_collision_objects == []
    (held,) = scene.get("ROBOT_STATE_ATTACHED_OBJECTS").robot_state.attached_collision_objects
    assert (held.link_name, held.object.id, held.touch_links) == ("tip", "part", ["tip"])
    assert held.object.header.frame_id == "tip"
    padding = {entry.link_name: entry.padding for entry in scene.get("LINK_PADDING_AND_SCALING").link_padding}
    assert padding["tip"] == pytest.approx(0.01)
    allowed = scene.get("ALLOWED_COLLISION_MATRIX").allowed_collision_matrix
    rows = dict(zip(allowed.entry_names, allowed.entry_values, strict=True))
    assert rows["upper"].enabled[allowed.entry_names.index("tip")]
    assert not rows["base"].enabled[allowed.entry_names.index("tip")]


def test_without_components_everything_is_told(scene):
    scene.change(diff(ball("a", 2.3), attached=[HELD]))
    told = scene.get()
    assert not told.is_diff
    assert [item.id for item in told.world.collision_objects] == ["a"]
    assert told.world.collision_objects[0].primitives
    assert [held.object.id for held in told.robot_state.attached_collision_objects] == ["part"]
    assert told.allowed_collision_matrix.entry_names
    assert list(told.robot_state.joint_state.name) == list(JOINTS)


def test_what_was_told_can_be_applied_again(cell, scene):
    scene.change(diff(ball("a", 2.3), attached=[HELD], padding={"tip": 0.01}))
    before = cell.judged(**STRETCHED)
    told = scene.get()
    scene.change(diff(ball("b", 2.1)))
    assert scene.apply(told)

    after = cell.judged(**STRETCHED)
    assert after.world_revision > before.world_revision
    assert after.status == CollisionState.FREE
    assert distances(after) == pytest.approx(distances(before), abs=ACCURACY)
    assert after.pairs_checked == before.pairs_checked


@pytest.mark.parametrize("triangles", [3000, 30_000])
def test_a_scene_of_any_size_arrives_whole(scene, triangles):
    scene.change(obstacle("strip", (fine_mesh(triangles), pose(3))))
    for _ in range(2):
        (mesh,) = scene.obstacles()["strip"].meshes
        assert [tuple(triangle.vertex_indices) for triangle in mesh.triangles] == [
            tuple(triangle.vertex_indices) for triangle in fine_mesh(triangles).triangles
        ]
        # a short one comes between the long ones
        (named,) = scene.get("WORLD_OBJECT_NAMES").world.collision_objects
        assert named.id == "strip"


def test_a_fine_mesh_is_told_by_topic(cell, scene):
    monitored = cell.peer.record(PlanningScene, cell.node.relative("monitored_planning_scene"))
    cell.peer.wait_for(
        lambda: cell.peer.node.count_publishers(cell.node.relative("monitored_planning_scene")), "the topic"
    )
    scene.change(obstacle("strip", (fine_mesh(3000), pose(3))))
    monitored.ever(
        lambda told: any(len(mesh.triangles) == 3000 for item in told.world.collision_objects for mesh in item.meshes),
        "the whole strip by topic",
    )


# apply_planning_scene


def test_a_scene_is_in_force_when_the_answer_comes(cell, scene):
    assert scene.apply(diff(ball("a", 2.15)))
    assert list(scene.obstacles()) == ["a"]
    assert not scene.validity(STRETCHED).valid
    assert cell.judged(**STRETCHED).status == CollisionState.COLLIDING


def test_whoever_has_the_answer_asks_about_that_scene_and_hears_nothing_older(cell, scene):
    states, is_free = States(cell.peer, cell.node), cell.peer.record(Bool, cell.node.private("is_free"))
    is_free.ever(lambda _: True, "a first message")
    stretched = [list(STRETCHED.values())]
    for _ in range(20):
        assert scene.apply(diff(ball("a", 2.15)))
        applied = cell.peer.now()
        assert states.check(stretched).verdicts[0] == CheckStates.Response.COLLIDING
        is_free.more(1, after=applied)
        assert not any(message.data for message in is_free.published_since(applied))
        assert scene.apply(diff(removal("a")))
        assert states.check(stretched).verdicts[0] == CheckStates.Response.FREE


def test_a_fine_mesh_of_a_megabyte_is_in_force_when_the_answer_comes(scene):
    assert scene.apply(diff(obstacle("strip", (fine_mesh(30_000), pose(1.5, 0, 0)))))
    assert not scene.validity(STRETCHED).valid
    assert scene.validity(FOLDED).valid


def test_a_scene_with_a_fault_does_not_succeed(scene):
    scene.apply(diff(ball("a", 2.3)))
    scene.complaints.forget()
    assert not scene.apply(diff(ball("thing", 0.3, frame="nowhere")))
    scene.complaints.wait_for("thing", "nowhere")
    assert list(scene.obstacles()) == ["a"]


def test_an_empty_diff_succeeds_and_changes_nothing(scene):
    scene.change(ball("a", 2.3))
    before = scene.get()
    assert scene.apply(PlanningScene(is_diff=True))
    assert scene.get("WORLD_OBJECT_GEOMETRY").world == before.world


def test_whoever_asks_at_once_hears_the_answer_to_what_he_asked(cell):
    clients = [SceneClient(cell) for _ in range(4)]
    for turn in range(8):
        scenes = [diff(ball(f"of_{number}", 5 + turn, number)) for number in range(len(clients))]
        applied = [
            client.request(ApplyPlanningScene, "apply_planning_scene", ApplyPlanningScene.Request(scene=scene))
            for client, scene in zip(clients, scenes, strict=True)
        ]
        assert all(cell.peer.result(answer).success for answer in applied)
        # no state is valid in a world that lags behind its messages: asked once they are in force
        valid = [(turn + number) % 2 == 0 for number in range(len(clients))]
        asked = [
            client.ask_validity(FOLDED if is_valid else ON_BASE)
            for client, is_valid in zip(clients, valid, strict=True)
        ]
        assert [cell.peer.result(answer).valid for answer in asked] == valid
        for client in clients:
            places = {name: xyz(item.pose.position)[:2] for name, item in client.obstacles().items()}
            assert places == {f"of_{number}": pytest.approx([5 + turn, number]) for number in range(len(clients))}


# check_state_validity


def contacts(answer):
    kinds = {
        ContactInformation.ROBOT_LINK: "link",
        ContactInformation.WORLD_OBJECT: "obstacle",
        ContactInformation.ROBOT_ATTACHED: "attached",
    }
    return [
        {(kinds[contact.body_type_1], contact.contact_body_1), (kinds[contact.body_type_2], contact.contact_body_2)}
        for contact in answer.contacts
    ]


def test_a_free_state_is_valid(scene):
    answer = scene.validity(FOLDED)
    assert answer.valid
    assert answer.contacts == []


def test_a_colliding_state_has_a_contact_for_each_pair(scene):
    scene.change(ball("a", 0.2, 0, 0.3, radius=0.15))
    answer = scene.validity(ON_BASE)

    assert not answer.valid
    touching = contacts(answer)
    assert {("link", "base"), ("link", "tip")} in touching
    assert {("link", "base"), ("obstacle", "a")} in touching
    for contact in answer.contacts:
        assert contact.header.frame_id == "base"
        assert contact.depth >= 0
        assert sum(number * number for number in xyz(contact.normal)) == pytest.approx(1)
    of_bodies = {(contact.contact_body_1, contact.contact_body_2): contact for contact in answer.contacts}
    # the ball at the tip is in the middle of the cube
    assert of_bodies["base", "tip"].depth == pytest.approx(0.3)
    assert all(abs(number) <= 0.3 for number in xyz(of_bodies["base", "tip"].position))
    # the other ball is 0.1 m above the edge of the cube
    above = of_bodies["base", "a"]
    assert above.depth == pytest.approx(0.05)
    assert xyz(above.normal) == pytest.approx([0, 0, 1])
    assert xyz(above.position) == pytest.approx([0.2, 0, 0.175])


def test_a_partial_state_overlays_the_current_one(cell, scene):
    cell.judged(**ON_BASE)
    assert not scene.validity({"joint1": 0.3}).valid
    assert scene.validity({"joint2": 0}).valid
    assert not scene.validity().valid
    cell.judged(**STRETCHED)
    assert scene.validity().valid
    assert not scene.validity({"joint2": pi}).valid


def test_a_group_is_judged_by_the_links_that_it_moves(scene):
    # On the bar of the upper link, far from the tip.
    scene.change(ball("a", 0.5, 0, 0.06, radius=0.05))
    assert not scene.validity(STRETCHED).valid
    assert not scene.validity(STRETCHED, group="arm").valid
    assert scene.validity(STRETCHED, group="wrist").valid
    assert not scene.validity(ON_BASE, group="wrist").valid


def test_an_unknown_group_is_an_error(scene):
    assert scene.validity(STRETCHED).valid
    scene.complaints.forget()
    answer = scene.validity(STRETCHED, group="elbow")
    assert not answer.valid
    assert answer.contacts == []
    scene.complaints.wait_for("elbow")


@pytest.mark.parametrize(
    ("joints", "named"),
    [({"joint1": 0, "joint2": nan}, "joint2"), ({"joint1": 0, "gripper": 0}, "gripper")],
    ids=["no number", "unknown joint"],
)
def test_a_state_that_cannot_be_judged_is_not_valid(scene, joints, named):
    scene.complaints.forget()
    answer = scene.validity(joints)
    assert not answer.valid
    assert answer.contacts == []
    scene.complaints.wait_for(named)


@pytest.mark.parametrize(
    ("names", "positions", "complaint"),
    [
        (["joint1", "joint2"], [0.0], "2 names and 1 positions"),
        ([], [0.0, 0.0], "0 names and 2 positions"),
        (["joint1", "joint2", "joint1"], [0.0] * 3, "joint1"),
        (["x" * 1_000_000, "joint2"], [0.0] * 2, "xxx"),
        ([f"stranger{i}" for i in range(100_000)], [0.0] * 100_000, "stranger0"),
        (["joint1", "joint2"], [0.0] * 500_000, "2 names and 500000 positions"),
    ],
    ids=["too few", "no names", "twice", "a long name", "many names", "many positions"],
)
def test_a_state_of_a_wrong_form_is_not_valid(cell, scene, names, positions, complaint):
    assert scene.validity(STRETCHED).valid
    scene.complaints.forget()
    request = GetStateValidity.Request()
    request.robot_state.is_diff = True
    request.robot_state.joint_state.name, request.robot_state.joint_state.position = names, positions
    answer = scene.call(GetStateValidity, "check_state_validity", request)
    assert not answer.valid
    assert answer.contacts == []
    assert len(scene.complaints.wait_for("check_state_validity", complaint)) < 1000
    assert scene.validity(STRETCHED).valid


def test_many_attached_objects_of_a_request_are_all_honoured(scene):
    parts = [attached("tip", ball(f"part{i}", 1, 0.4, radius=0.05, frame="tip"), ["tip"]) for i in range(1000)]
    assert scene.validity(STRETCHED, attached=parts).valid
    answer = scene.validity(FOLDED, attached=parts)
    assert not answer.valid
    assert 0 < len(answer.contacts) < len(parts), "the answer does not grow with the request"


def test_positions_outside_the_limits_are_no_contact(scene):
    """Collisions are asked for, as in MoveIt: limits are the planner's."""
    assert scene.validity({"joint1": 4.0, "joint2": 0}).valid


def test_an_attached_object_of_the_request_is_honoured(cell, scene):
    assert scene.validity(FOLDED).valid
    answer = scene.validity(FOLDED, attached=[HELD])
    assert not answer.valid
    assert contacts(answer) == [{("link", "base"), ("attached", "part")}]
    # It was a question: the robot holds nothing.
    assert scene.validity(FOLDED).valid
    assert scene.get("ROBOT_STATE_ATTACHED_OBJECTS").robot_state.attached_collision_objects == []


def test_a_whole_state_holds_only_what_it_says(cell, scene):
    """As in MoveIt: only a state that is a diff keeps what the robot holds now."""
    scene.change(HELD)
    assert not scene.validity(FOLDED).valid
    assert not scene.validity(FOLDED, is_diff=False, attached=[HELD]).valid
    assert scene.validity(FOLDED, is_diff=False).valid


def test_what_a_request_takes_up_from_the_world_is_taken_up_where_the_robot_is_now(cell, scene):
    """Ahead of the tip; asked about a state in which that is elsewhere, it is elsewhere too."""
    cell.judged(**STRETCHED)
    scene.change(ball("part", 2.3), ball("wall", 0, 2.3))
    upright = {"joint1": pi / 2, "joint2": 0}
    assert scene.validity(upright).valid
    answer = scene.validity(upright, attached=[attached("tip", "part")])
    assert contacts(answer) == [{("obstacle", "wall"), ("attached", "part")}]


def test_what_a_request_lets_go_is_gone(cell, scene):
    """As in MoveIt: it does not come into the world."""
    scene.change(HELD)
    assert not scene.validity(FOLDED).valid
    assert scene.validity(FOLDED, attached=[detachment("part")]).valid
    assert not scene.validity(FOLDED).valid


def test_a_broken_attached_object_makes_the_state_invalid(scene):
    answer = scene.validity(STRETCHED, attached=[attached("hand", ball("part", 1))])
    assert not answer.valid


def test_constraints_are_never_passed_over(scene):
    """What is not checked is not valid; an answer without the result of a constraint is not, either."""
    broken = Constraints(joint_constraints=[JointConstraint(joint_name="joint1", position=1.0, weight=1.0)])
    assert not scene.validity(STRETCHED, constraints=broken).valid


def test_nothing_is_valid_without_a_current_state_to_overlay(start, tmp_path):
    cell = start(driving=False)
    scene = SceneClient(cell)
    cell.unknown("no_joint_state")
    assert not scene.validity({"joint1": 0}).valid
    assert scene.validity(STRETCHED).valid


def test_nothing_is_valid_in_a_world_that_is_not_known(start):
    cell = start(parameters={"point_cloud_topics": ["points"]})
    scene = SceneClient(cell)
    cell.unknown("stale_world")
    scene.complaints.forget()
    assert not scene.validity(STRETCHED).valid
    scene.complaints.wait_for("check_state_validity", "is the sensor running?")


def test_nothing_is_valid_while_the_model_is_swapped(peer, start, tmp_path):
    publisher = peer.latch(String(data=description()), "/swapped/robot_description")
    cell = start("--package-path", tmp_path, urdf=None, namespace="/swapped")
    scene = SceneClient(cell)
    cell.has_model()
    cell.judged(**STRETCHED)
    assert scene.validity(STRETCHED).valid
    publisher.publish(String(data=description_with_fine_base(tmp_path)))
    cell.unknown("model_swap")
    scene.complaints.forget()
    assert not scene.validity(STRETCHED).valid
    scene.complaints.wait_for("check_state_validity", "its model is still being built")
    cell.has_model(2)
    cell.judged(**STRETCHED)
    assert scene.validity(STRETCHED).valid


def test_the_matrix_counts(cell, scene):
    neighbours = ("base", "upper"), ("upper", "tip")
    assert not scene.validity(ON_BASE).valid
    assert scene.apply(diff(allowed=matrix(*neighbours, ("base", "tip"))))
    assert scene.validity(ON_BASE).valid


def test_the_states_go_on_while_many_ask_at_once(cell):
    clients = [SceneClient(cell) for _ in range(8)]
    for client in clients:
        assert client.validity(FOLDED).valid
    start = cell.state_now()
    for turn in range(20):
        asked = [(client.ask_validity(FOLDED if number % 2 else ON_BASE), number % 2) for number, client in enumerate(clients, turn)]
        for answer, valid in asked:
            assert cell.peer.result(answer).valid == valid
    after = cell.peer.wait_for(lambda: cell.states.after(start), "states meanwhile")
    assert {state.status for state in after} == {CollisionState.FREE}
    assert distance(cell.judged(**FOLDED), "base", "tip") == pytest.approx(0.2, abs=ACCURACY)


MOST_WAITING = 64  # requests


def test_who_asks_when_too_many_wait_is_told_that_nothing_is_valid(start):
    """With so many obstacles a request that holds something takes longer than it takes to come."""
    cell = start()
    scene = SceneClient(cell)
    cell.judged(**STRETCHED)
    ring = [pose(3 * cos(angle), 3 * sin(angle)) for angle in (2 * pi * i / 3000 for i in range(3000))]
    assert scene.apply(diff(*(obstacle(f"ball {i}", sphere(0.1), at=at) for i, at in enumerate(ring))))
    assert scene.validity(STRETCHED, attached=[HELD]).valid
    scene.complaints.forget()
    start = cell.state_now()
    asked = []
    rejected = lambda: any(answer.done() and not answer.result().valid for answer in asked)
    # more at a time than may wait, but no more than the network library holds while the node gets no processor
    is_next = lambda: rejected() or sum(not answer.done() for answer in asked) < MOST_WAITING + 4
    while not rejected():
        asked.append(scene.ask_validity(STRETCHED, attached=[HELD]))
        cell.peer.wait_for(is_next, "an answer")
    answers = [cell.peer.result(answer) for answer in asked]

    refused = [answer for answer in answers if not answer.valid]
    assert refused and len(answers) - len(refused) >= MOST_WAITING
    assert all(answer.contacts == [] for answer in refused)
    scene.complaints.wait_for("check_state_validity", "64 requests are waiting already")
    after = cell.peer.wait_for(lambda: cell.states.after(start), "states: the monitor went on")
    assert {state.status for state in after} == {CollisionState.FREE}
    assert scene.validity(STRETCHED, attached=[HELD]).valid
