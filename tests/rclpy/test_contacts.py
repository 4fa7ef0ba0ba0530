"""Tests of contacts as MoveIt's clients expect them: several for each pair, with position, normal and depth."""

import pytest
from clearance_msgs.msg import CollisionState
from visualization_msgs.msg import Marker, MarkerArray

from scene import attached, box, cube_mesh, obstacle, pose, sphere, xyz
from two_link_srdf import ACCURACY, STRETCHED, cell  # noqa: F401 (a fixture)

# The legs of a chair on the tip, and the half width of each.
LEGS = [(1.8, -0.2), (2.2, -0.2), (1.8, 0.2), (2.2, 0.2)]
HALF = 0.02


def held(*shapes, at):
    """An object on the tip, which touches only what is not the tip."""
    return attached("tip", obstacle("part", *shapes, at=at, frame="base"), ["tip"])


def of_pair(response, first="part", second="floor"):
    found = [contact for contact in response.contacts if contact.contact_body_1 == first]
    assert all(contact.contact_body_2 == second for contact in found)
    return found


def test_a_box_flat_on_a_table_has_a_contact_at_each_corner(scene):
    scene.change(obstacle("floor", box(3, 3, 0.1), at=pose(2, 0, 0.855)))
    response = scene.validity(STRETCHED, attached=[held(box(0.4, 0.2, 0.1), at=pose(2, 0.1, 0.95))])
    found = of_pair(response)
    assert 4 <= len(found) <= 8
    for contact in found:
        # From the first body, above, to the second.
        assert xyz(contact.normal) == pytest.approx([0, 0, -1], abs=ACCURACY)
        assert contact.depth == pytest.approx(0.005, abs=ACCURACY)
        assert 0.9 - ACCURACY <= contact.position.z <= 0.905 + ACCURACY
    for corner in [(1.8, 0), (2.2, 0), (1.8, 0.2), (2.2, 0.2)]:
        assert any(xyz(contact.position)[:2] == pytest.approx(corner, abs=ACCURACY) for contact in found)


@pytest.mark.parametrize("floor", [box(4, 4, 1), cube_mesh(4)], ids=["box", "mesh"])
def test_every_foot_of_a_chair_has_a_contact(scene, floor):
    """The legs end 1 mm below the floor's top."""
    top = 0.5 if floor == box(4, 4, 1) else 2.0
    scene.change(obstacle("floor", floor, at=pose(2, 0, 0.5 - top)))
    legs = [(box(2 * HALF, 2 * HALF, 0.4), pose(x - 2, y, 0)) for x, y in LEGS]
    chair = held((box(0.5, 0.5, 0.02), pose(z=0.2)), *legs, at=pose(2, 0, 0.699))
    # The tip's ball is in the floor, too; it is another pair.
    found = of_pair(scene.validity(STRETCHED, attached=[chair]))
    for x, y in LEGS:
        foot = [c for c in found if abs(c.position.x - x) < 2 * HALF and abs(c.position.y - y) < 2 * HALF]
        assert foot, (x, y, found)
        assert all(contact.depth == pytest.approx(0.001, abs=ACCURACY) for contact in foot)
        assert all(xyz(contact.normal) == pytest.approx([0, 0, -1], abs=ACCURACY) for contact in foot)


def test_a_round_body_has_one_contact_on_a_flat_one(scene):
    scene.change(obstacle("floor", box(3, 3, 0.1), at=pose(2, 0, 0.855)))
    (contact,) = of_pair(scene.validity(STRETCHED, attached=[held(sphere(0.05), at=pose(2, 0.1, 0.95))]))
    assert xyz(contact.position) == pytest.approx([2, 0.1, 0.9025], abs=ACCURACY)
    assert contact.depth == pytest.approx(0.005, abs=ACCURACY)


def test_contacts_of_many_pairs_are_limited(scene):
    """Each pair has a contact, as far as the answer may have so many."""
    parts = [
        attached("tip", obstacle(f"part{i}", box(0.1, 0.1, 0.1), at=pose(2, 0, 0.95), frame="base"), ["tip"])
        for i in range(50)
    ]
    scene.change(obstacle("floor", box(3, 3, 0.1), at=pose(2, 0, 0.855)))
    response = scene.validity(STRETCHED, attached=parts)
    of_floor = {c.contact_body_1 for c in response.contacts if c.contact_body_2 == "floor"}
    assert len(response.contacts) <= 200
    assert not response.valid and of_floor


def state_with_contacts(scene, cell, contacts):
    """The state of the stretched arm whose tip is 0.02 m deep in a floor, with so many contacts of each pair."""
    cell.parameters.succeed(contacts_per_pair=contacts)
    scene.change(obstacle("floor", box(3, 3, 1), at=pose(2, 0, -0.58)))
    return cell.evaluate(**STRETCHED)


def test_the_state_has_contacts_of_its_colliding_pairs(scene, cell):
    state = state_with_contacts(scene, cell, 4)
    assert state.status == CollisionState.COLLIDING
    pairs = [contact.pair for contact in state.contacts]
    assert [pair for i, pair in enumerate(pairs) if pair not in pairs[:i]] == state.colliding_pairs
    (contact, *_) = [contact for contact in state.contacts if contact.pair.body_a == "tip"]
    assert (contact.pair.body_b, contact.depth_known, contact.reason) == ("floor", True, "")
    assert 0 < contact.depth_lower <= contact.depth_upper
    assert contact.depth_upper == pytest.approx(0.02, abs=ACCURACY)
    assert xyz(contact.normal) == pytest.approx([0, 0, -1], abs=ACCURACY)
    assert -0.1 - ACCURACY <= contact.position.z <= -0.08 + ACCURACY


def test_without_the_parameter_the_state_has_none(scene, cell):
    state = state_with_contacts(scene, cell, 0)
    assert (state.status, state.contacts) == (CollisionState.COLLIDING, [])
    state = state_with_contacts(scene, cell, 1)
    assert len(state.contacts) == len(state.colliding_pairs)
    assert state_with_contacts(scene, cell, 0).contacts == []


def test_a_free_state_has_no_contacts(scene, cell):
    cell.parameters.succeed(contacts_per_pair=4)
    assert cell.evaluate(**STRETCHED).contacts == []


def test_markers_show_contacts(scene, cell):
    recorded = cell.peer.record(MarkerArray, cell.node.private("markers"))
    state = state_with_contacts(scene, cell, 4)

    def shown(array, action=Marker.ADD):
        return [marker for marker in array.markers if (marker.ns, marker.action) == ("contacts", action)]

    array = recorded.ever(shown, "markers of contacts")
    points, *arrows = shown(array)
    assert (points.type, len(points.points)) == (Marker.SPHERE_LIST, len(state.contacts))
    assert [xyz(point) for point in points.points] == [xyz(contact.position) for contact in state.contacts]
    assert len(arrows) == len(state.contacts)
    for arrow, contact in zip(arrows, state.contacts, strict=True):
        start, end = map(xyz, arrow.points)
        length = max(contact.depth_upper, 0.03)
        assert [e - s for s, e in zip(start, end, strict=True)] == pytest.approx(
            [length * n for n in xyz(contact.normal)], abs=ACCURACY
        )
    cell.parameters.succeed(contacts_per_pair=0)
    cell.evaluate(**STRETCHED)
    recorded.ever(lambda array: shown(array, Marker.DELETE), "the markers of contacts are taken away")
