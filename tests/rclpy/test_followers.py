"""Tests of a node that follows another node's scene: by its service, then by its `monitored_planning_scene`.

With both joints at zero the ball of the tip, of radius 0.1, is around (2, 0, 0).
"""

import pytest
from clearance_msgs.msg import CollisionState

from octree import OCCUPIED, Octree
from scene import ball, fine_mesh, move, obstacle, plane, pose
from scene_client import SceneClient, colliding, distance

STRETCHED = {"joint1": 0, "joint2": 0}
NEARBY = {"influence_distance": 0.5}
# more than the differences between two publications of all of the scene
CHANGES = 90


@pytest.fixture
def leader(start):
    cell = start(parameters=NEARBY)
    cell.evaluate(**STRETCHED)
    return cell


@pytest.fixture
def follower(start, leader):
    cell = start(
        parameters=NEARBY | {"planning_scene_service": leader.node.relative("get_planning_scene")},
        ros_arguments=["-r", f"planning_scene:={leader.node.relative('monitored_planning_scene')}"],
    )
    cell.driver.report(**STRETCHED)
    cell.states.ever(lambda state: state.status == CollisionState.FREE, "FREE with the scene of the leader")
    return cell


def shift_often(leader, follower, name):
    """Moves an object until all of the scene has been published again, and the follower has received it."""
    scene, of_follower = SceneClient(leader), SceneClient(follower)
    for number in range(CHANGES):
        scene.change(move(name, pose(30 + 0.01 * number)))
    last = pytest.approx(30 + 0.01 * (CHANGES - 1))

    def is_there():
        known = of_follower.obstacles().get(name)
        return known and known.pose.position.x == last

    leader.peer.wait_for(is_there, "the last place at the follower")


def free(states):
    return [state for state in states if state.status == CollisionState.FREE]


def test_a_follower_of_a_large_scene_always_has_all_of_it(leader, follower):
    scene = SceneClient(leader)
    for number in range(8):
        scene.change(obstacle(f"strip{number}", fine_mesh(2500), at=pose(20 + number)))
    hit = follower.peer.now()
    scene.change(ball("a", 2.0))
    hit = follower.becomes(CollisionState.COLLIDING, "contact at the follower", after=hit)
    shift_often(leader, follower, "strip0")
    assert not free(follower.states.after(hit))


def test_a_follower_keeps_the_octomap_of_its_own_sensor(leader, follower):
    SceneClient(leader).change(ball("far", 20))
    near = Octree(0.1).set(OCCUPIED, 2.25, 0.05, 0.05)
    state = SceneClient(follower).change(near.message(), topic="octomap_binary")
    shift_often(leader, follower, "far")
    assert all(distance(state, "tip", "<octomap>") for state in free([state, *follower.states.after(state)]))


def test_an_object_that_is_too_large_for_the_topic_is_requested(leader, follower):
    before = follower.peer.now()
    SceneClient(leader).change(obstacle("cell", (fine_mesh(6000), pose(1.5)), (plane(0, 0, 1, 5), pose())))
    hit = follower.becomes(CollisionState.COLLIDING, "contact with the mesh", after=before)
    assert colliding(hit) == [{("link", "tip"), ("obstacle", "cell")}]
    known = SceneClient(follower).obstacles()["cell"]
    assert (len(known.meshes[0].triangles), len(known.planes)) == (6000, 1)
