"""Tests of `get_planning_scene` and `apply_planning_scene` as MoveIt's clients use them."""

import pytest
from clearance_msgs.msg import CollisionState
from clearance_msgs.srv import CheckStates
from moveit_msgs.msg import PlanningScene
from moveit_msgs.srv import ApplyPlanningScene
from std_msgs.msg import Bool

from scene import attached, ball, box, cube_mesh, cylinder, diff, fine_mesh, obstacle, plane, pose, removal, xyz
from scene_client import SceneClient, bodies, colliding, distances
from states import States
from two_link import JOINTS
from two_link_srdf import ACCURACY, FOLDED, HELD, NEARBY, ON_BASE, SRDF, STRETCHED, cell  # noqa: F401 (a fixture)


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
    cell.evaluate(**STRETCHED)
    scene = SceneClient(cell)
    reported = scene.get("ALLOWED_COLLISION_MATRIX").allowed_collision_matrix
    assert (list(reported.default_entry_names), list(reported.default_entry_values)) == (["tip"], [True])

    # An obstacle that comes later, and an object that another link holds, may touch the tip.
    state = scene.change(ball("a", 2.0), attached("base", ball("part", 2.0), ["base"]))
    assert state.status == CollisionState.COLLIDING, "the obstacle and the object touch each other"
    assert [{body for _, body in bodies(pair)} for pair in state.colliding_pairs] == [{"a", "part"}]
    state = scene.change(removal("a"))
    assert state.status == CollisionState.FREE
    reasons = {skipped.reason: skipped.count for skipped in state.skipped}
    assert reasons["disabled by the SRDF's disable_default_collisions"] == 2

    # An enabled pair is checked all the same.
    assert colliding(cell.evaluate(**ON_BASE)) == [{("link", "base"), ("link", "tip")}]



def test_every_remark_about_the_world_is_reported(scene):
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
    reported = scene.obstacles()["thing"]

    assert reported.header.frame_id == "base"
    assert reported.operation == thing.operation
    assert reported.type == thing.type
    assert [(shape.type, list(shape.dimensions)) for shape in reported.primitives] == [
        (shape.type, list(shape.dimensions)) for shape in thing.primitives
    ]
    assert (reported.meshes, reported.planes) == (thing.meshes, thing.planes)
    assert reported.subframe_names == thing.subframe_names
    for field in ("primitive_poses", "mesh_poses", "plane_poses", "subframe_poses"):
        assert_poses(getattr(reported, field), getattr(thing, field))
    assert_poses([reported.pose], [thing.pose])


def assert_poses(reported, said):
    for one, other in zip(reported, said, strict=True):
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


def test_without_components_everything_is_reported(scene):
    scene.change(diff(ball("a", 2.3), attached=[HELD]))
    reported = scene.get()
    assert not reported.is_diff
    assert [item.id for item in reported.world.collision_objects] == ["a"]
    assert reported.world.collision_objects[0].primitives
    assert [held.object.id for held in reported.robot_state.attached_collision_objects] == ["part"]
    assert reported.allowed_collision_matrix.entry_names
    assert list(reported.robot_state.joint_state.name) == list(JOINTS)


def test_a_published_scene_can_be_applied_again(cell, scene):
    scene.change(diff(ball("a", 2.3), attached=[HELD], padding={"tip": 0.01}))
    before = cell.evaluate(**STRETCHED)
    reported = scene.get()
    scene.change(diff(ball("b", 2.1)))
    assert scene.apply(reported)

    after = cell.evaluate(**STRETCHED)
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


def test_a_fine_mesh_is_reported_by_topic(cell, scene):
    monitored = cell.peer.record(PlanningScene, cell.node.relative("monitored_planning_scene"))
    cell.peer.wait_for(
        lambda: cell.peer.node.count_publishers(cell.node.relative("monitored_planning_scene")), "the topic"
    )
    scene.change(obstacle("strip", (fine_mesh(3000), pose(3))))
    monitored.ever(
        lambda reported: any(len(mesh.triangles) == 3000 for item in reported.world.collision_objects for mesh in item.meshes),
        "the whole strip by topic",
    )


# apply_planning_scene


def test_a_scene_is_in_force_when_the_answer_comes(cell, scene):
    assert scene.apply(diff(ball("a", 2.15)))
    assert list(scene.obstacles()) == ["a"]
    assert not scene.validity(STRETCHED).valid
    assert cell.evaluate(**STRETCHED).status == CollisionState.COLLIDING


def test_a_check_after_a_scene_response_uses_that_scene(cell, scene):
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


def test_concurrent_requests_each_get_their_own_response(cell):
    clients = [SceneClient(cell) for _ in range(4)]
    for turn in range(8):
        scenes = [diff(ball(f"of_{number}", 5 + turn, number)) for number in range(len(clients))]
        applied = [
            client.request(ApplyPlanningScene, "apply_planning_scene", ApplyPlanningScene.Request(scene=scene))
            for client, scene in zip(clients, scenes, strict=True)
        ]
        assert all(cell.peer.result(response).success for response in applied)
        # no state is valid in a world that lags behind its messages: asked once they are in force
        valid = [(turn + number) % 2 == 0 for number in range(len(clients))]
        asked = [
            client.ask_validity(FOLDED if is_valid else ON_BASE)
            for client, is_valid in zip(clients, valid, strict=True)
        ]
        assert [cell.peer.result(response).valid for response in asked] == valid
        for client in clients:
            places = {name: xyz(item.pose.position)[:2] for name, item in client.obstacles().items()}
            assert places == {f"of_{number}": pytest.approx([5 + turn, number]) for number in range(len(clients))}
