"""Tests of `check_state_validity` as MoveIt's clients use it."""

from math import cos, nan, pi, sin

import pytest
from clearance_msgs.msg import CollisionState
from moveit_msgs.msg import Constraints, ContactInformation, JointConstraint
from moveit_msgs.srv import GetStateValidity
from std_msgs.msg import String

from scene import attached, ball, cube_mesh, detachment, diff, matrix, obstacle, pose, sphere, xyz
from scene_client import SceneClient, distance
from two_link import description, description_with_fine_base
from two_link_srdf import ACCURACY, FOLDED, HELD, ON_BASE, STRETCHED, cell  # noqa: F401 (a fixture)


def contacts(response):
    kinds = {
        ContactInformation.ROBOT_LINK: "link",
        ContactInformation.WORLD_OBJECT: "obstacle",
        ContactInformation.ROBOT_ATTACHED: "attached",
    }
    return [
        {(kinds[contact.body_type_1], contact.contact_body_1), (kinds[contact.body_type_2], contact.contact_body_2)}
        for contact in response.contacts
    ]


def test_a_free_state_is_valid(scene):
    response = scene.validity(FOLDED)
    assert response.valid
    assert response.contacts == []


def test_a_colliding_state_has_a_contact_for_each_pair(scene):
    scene.change(ball("a", 0.2, 0, 0.3, radius=0.15))
    response = scene.validity(ON_BASE)

    assert not response.valid
    touching = contacts(response)
    assert {("link", "base"), ("link", "tip")} in touching
    assert {("link", "base"), ("obstacle", "a")} in touching
    for contact in response.contacts:
        assert contact.header.frame_id == "base"
        assert contact.depth >= 0
        assert sum(number * number for number in xyz(contact.normal)) == pytest.approx(1)
    # of each pair, the deepest contact comes first
    of_bodies = {(contact.contact_body_1, contact.contact_body_2): contact for contact in reversed(response.contacts)}
    # the ball at the tip is in the middle of the cube
    assert of_bodies["base", "tip"].depth == pytest.approx(0.3)
    assert all(abs(number) <= 0.3 for number in xyz(of_bodies["base", "tip"].position))
    # the other ball is 0.1 m above the edge of the cube
    above = of_bodies["base", "a"]
    assert above.depth == pytest.approx(0.05)
    assert xyz(above.normal) == pytest.approx([0, 0, 1])
    assert xyz(above.position) == pytest.approx([0.2, 0, 0.175])


def test_a_mesh_has_a_depth_and_a_normal(scene):
    """After the depth along the normal, the obstacle is apart; a hair before, it is not."""
    at = lambda shift: obstacle("mesh", cube_mesh(0.4), at=pose(2.25 + shift, 0, 0))
    scene.change(at(0))
    (contact,) = scene.validity(STRETCHED).contacts
    assert (contact.contact_body_1, contact.contact_body_2) == ("tip", "mesh")
    assert contact.depth == pytest.approx(0.05, abs=ACCURACY)
    assert xyz(contact.normal) == pytest.approx([1, 0, 0], abs=ACCURACY)
    assert xyz(contact.position) == pytest.approx([2.075, 0, 0], abs=ACCURACY)
    scene.change(at(contact.depth + 1e-8))
    assert scene.validity(STRETCHED).valid
    scene.change(at(contact.depth - 1e-6))
    assert not scene.validity(STRETCHED).valid


def test_a_partial_state_overlays_the_current_one(cell, scene):
    cell.evaluate(**ON_BASE)
    assert not scene.validity({"joint1": 0.3}).valid
    assert scene.validity({"joint2": 0}).valid
    assert not scene.validity().valid
    cell.evaluate(**STRETCHED)
    assert scene.validity().valid
    assert not scene.validity({"joint2": pi}).valid


def test_a_group_is_evaluated_by_the_links_that_it_moves(scene):
    # On the bar of the upper link, far from the tip.
    scene.change(ball("a", 0.5, 0, 0.06, radius=0.05))
    assert not scene.validity(STRETCHED).valid
    assert not scene.validity(STRETCHED, group="arm").valid
    assert scene.validity(STRETCHED, group="wrist").valid
    assert not scene.validity(ON_BASE, group="wrist").valid


def test_an_unknown_group_is_an_error(scene):
    assert scene.validity(STRETCHED).valid
    scene.complaints.forget()
    response = scene.validity(STRETCHED, group="elbow")
    assert not response.valid
    assert response.contacts == []
    scene.complaints.wait_for("elbow")


@pytest.mark.parametrize(
    ("joints", "named"),
    [({"joint1": 0, "joint2": nan}, "joint2"), ({"joint1": 0, "gripper": 0}, "gripper")],
    ids=["no number", "unknown joint"],
)
def test_a_state_that_cannot_be_evaluated_is_not_valid(scene, joints, named):
    scene.complaints.forget()
    response = scene.validity(joints)
    assert not response.valid
    assert response.contacts == []
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
    response = scene.call(GetStateValidity, "check_state_validity", request)
    assert not response.valid
    assert response.contacts == []
    assert len(scene.complaints.wait_for("check_state_validity", complaint)) < 1000
    assert scene.validity(STRETCHED).valid


def test_many_attached_objects_of_a_request_are_all_honoured(scene):
    parts = [attached("tip", ball(f"part{i}", 1, 0.4, radius=0.05, frame="tip"), ["tip"]) for i in range(1000)]
    assert scene.validity(STRETCHED, attached=parts).valid
    response = scene.validity(FOLDED, attached=parts)
    assert not response.valid
    assert 0 < len(response.contacts) < len(parts), "the answer does not grow with the request"


def test_positions_outside_the_limits_are_no_contact(scene):
    """Collisions are asked for, as in MoveIt: limits are the planner's."""
    assert scene.validity({"joint1": 4.0, "joint2": 0}).valid


def test_an_attached_object_of_the_request_is_honoured(cell, scene):
    assert scene.validity(FOLDED).valid
    response = scene.validity(FOLDED, attached=[HELD])
    assert not response.valid
    assert contacts(response) == [{("link", "base"), ("attached", "part")}]
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
    cell.evaluate(**STRETCHED)
    scene.change(ball("part", 2.3), ball("wall", 0, 2.3))
    upright = {"joint1": pi / 2, "joint2": 0}
    assert scene.validity(upright).valid
    response = scene.validity(upright, attached=[attached("tip", "part")])
    assert contacts(response) == [{("obstacle", "wall"), ("attached", "part")}]


def test_what_a_request_lets_go_is_gone(cell, scene):
    """As in MoveIt: it does not come into the world."""
    scene.change(HELD)
    assert not scene.validity(FOLDED).valid
    assert scene.validity(FOLDED, attached=[detachment("part")]).valid
    assert not scene.validity(FOLDED).valid


def test_a_broken_attached_object_makes_the_state_invalid(scene):
    response = scene.validity(STRETCHED, attached=[attached("hand", ball("part", 1))])
    assert not response.valid


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
    cell.evaluate(**STRETCHED)
    assert scene.validity(STRETCHED).valid
    publisher.publish(String(data=description_with_fine_base(tmp_path)))
    cell.unknown("model_swap")
    scene.complaints.forget()
    assert not scene.validity(STRETCHED).valid
    scene.complaints.wait_for("check_state_validity", "its model is still being built")
    cell.has_model(2)
    cell.evaluate(**STRETCHED)
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
        for response, valid in asked:
            assert cell.peer.result(response).valid == valid
    after = cell.peer.wait_for(lambda: cell.states.after(start), "states meanwhile")
    assert {state.status for state in after} == {CollisionState.FREE}
    assert distance(cell.evaluate(**FOLDED), "base", "tip") == pytest.approx(0.2, abs=ACCURACY)


MOST_WAITING = 64  # requests


def test_a_request_while_too_many_wait_is_answered_as_not_valid(start):
    """With so many obstacles a request that holds something takes longer than it takes to come."""
    cell = start()
    scene = SceneClient(cell)
    cell.evaluate(**STRETCHED)
    ring = [pose(3 * cos(angle), 3 * sin(angle)) for angle in (2 * pi * i / 3000 for i in range(3000))]
    assert scene.apply(diff(*(obstacle(f"ball {i}", sphere(0.1), at=at) for i, at in enumerate(ring))))
    assert scene.validity(STRETCHED, attached=[HELD]).valid
    scene.complaints.forget()
    start = cell.state_now()
    asked = []
    rejected = lambda: any(response.done() and not response.result().valid for response in asked)
    # more at a time than may wait, but no more than the network library holds while the node gets no processor
    is_next = lambda: rejected() or sum(not response.done() for response in asked) < MOST_WAITING + 4
    while not rejected():
        asked.append(scene.ask_validity(STRETCHED, attached=[HELD]))
        cell.peer.wait_for(is_next, "an answer")
    responses = [cell.peer.result(response) for response in asked]

    invalid = [response for response in responses if not response.valid]
    assert invalid and len(responses) - len(invalid) >= MOST_WAITING
    assert all(response.contacts == [] for response in invalid)
    scene.complaints.wait_for("check_state_validity", "64 requests are waiting already")
    after = cell.peer.wait_for(lambda: cell.states.after(start), "states: the monitor went on")
    assert {state.status for state in after} == {CollisionState.FREE}
    assert scene.validity(STRETCHED, attached=[HELD]).valid
