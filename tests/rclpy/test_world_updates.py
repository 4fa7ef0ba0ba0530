"""Tests of updates of the world that are not in force yet: nothing is free, and services prove nothing."""

from clearance_msgs.msg import CollisionState
from clearance_msgs.srv import CheckStates
from moveit_msgs.srv import ApplyPlanningScene
from sensor_msgs.msg import PointCloud2

from cell import Companions
from clouds import cloud
from fail_safe import NOTHING_KNOWN, ZERO
from motions import Motions
from scene import diff, fine_mesh, obstacle, pose, removal, sphere
from scene_client import SceneClient
from states import States

FINE = 200_000  # triangles that take much longer than 0.1 s to build
PATIENCE = 100.0  # [s]
ATTEMPTS = 10


def is_late(state):
    return state.status == CollisionState.UNKNOWN and state.reason_code == "world_update"


def waits_for_both(state):
    """Both messages were received: a slow machine may deliver the second one when the first is in force already."""
    return is_late(state) and "2 messages" in state.reason


def test_nothing_is_free_until_what_was_received_is_in_force(start):
    cell = start(parameters={"heartbeat_rate": 50.0})
    assert cell.evaluate(**ZERO).status == CollisionState.FREE
    companions = Companions(cell)
    scene = SceneClient(cell)
    for _ in range(ATTEMPTS):
        begin = cell.peer.now()
        scene.publish(obstacle("fine", fine_mesh(FINE), at=pose(9.0)))
        scene.publish(obstacle("onto the tip", sphere(0.2), at=pose(2.0)))
        late = cell.states.wait_for(is_late, "UNKNOWN for a world that is being built", begin, PATIENCE)
        said = companions.of(late)
        assert all(is_nothing(said[name]) for name, is_nothing in NOTHING_KNOWN.items()), said
        assert "the world is being built" in late.reason
        colliding = cell.states.wait_for(
            lambda state: state.status == CollisionState.COLLIDING, "COLLIDING with the ball", late, PATIENCE
        )
        states = cell.states.after(late)
        both = [waits_for_both(state) for state in [late, *states]]
        if any(both):
            last = states[both.index(True) : states.index(colliding)]
            assert all(state.status != CollisionState.FREE for state in last)
            return
        scene.change(removal("fine"), removal("onto the tip"))
    raise AssertionError(f"the node never waited for both messages in {ATTEMPTS} attempts")


def test_services_prove_nothing_about_a_world_that_is_being_built(start):
    cell = start()
    assert cell.evaluate(**ZERO).status == CollisionState.FREE
    scene, states, motions = SceneClient(cell), States(cell.peer, cell.node), Motions(cell.peer, cell.node)
    fine = [obstacle(f"fine {i}", fine_mesh(FINE), at=pose(9.0 + i)) for i in range(3)]
    begin = cell.peer.now()
    applied = scene.request(ApplyPlanningScene, "apply_planning_scene", ApplyPlanningScene.Request(scene=diff(*fine)))
    cell.states.wait_for(is_late, "UNKNOWN for a world that is being built", begin, PATIENCE)
    responses = [states.check([(0, 0)]), motions.check([], [0.1], joints=("joint1",))]
    # an answer that came while it was being built
    assert not applied.done()
    assert [response.reason_code for response in responses] == ["world_update"] * 2
    assert responses[0].verdict == CheckStates.Response.ERROR
    cell.peer.wait_for(applied.done, "the scene in force", PATIENCE)
    assert applied.result().success
    # what follows the response is of the new world
    assert states.check([(0, 0)]).reason_code == ""
    assert cell.state_now().status == CollisionState.FREE


def test_clouds_are_no_updates_that_are_waited_for(start):
    """They have a time-to-live, and an old one counts until the new one is in force."""
    cell = start(parameters={"point_cloud_topics": ["points"], "point_cloud_ttl": 3600.0})
    cell.driver.report(**ZERO)
    scene = SceneClient(cell)
    scene.topic(PointCloud2, "points")
    for i in range(20):
        scene.change(cloud([(2.3, 0.01 * i, 0)], stamp=cell.peer.now()), topic="points")
    assert not any(is_late(state) for state in cell.states.all())
