"""Tests of queries on states: batches against single states, derivatives against differences, contacts, pairs."""

from types import MappingProxyType

import numpy as np
import pytest

import clearance as cl


def test_a_batch_is_its_states(checker, states):
    free = checker.is_free(states)
    assert free.dtype == np.bool_ and free.shape == (400,) and 0 < free.sum() < 400
    assert [checker.is_free(q) for q in states] == free.tolist()
    assert type(checker.is_free(states[0])) is bool
    # by the slow way, of all pairs
    assert [report.free for report in checker.check(states, max_contacts=0)] == free.tolist()
    for threads in (1, 2, 3):
        assert np.array_equal(checker.is_free(states, num_threads=threads), free)


def test_shapes_and_types(checker, states):
    free = checker.is_free(states[:24])
    block = states[:24].reshape(2, 3, 4, 8)
    assert np.array_equal(checker.is_free(block), free.reshape(2, 3, 4))
    assert checker.is_free(np.zeros((0, 8))).shape == (0,) and checker.is_free(np.zeros((3, 0, 8))).shape == (3, 0)
    every_second = np.repeat(states, 2, axis=0)[::2][:24]
    assert not every_second.flags.c_contiguous and np.array_equal(checker.is_free(every_second), free)
    assert np.array_equal(checker.is_free(np.asfortranarray(states[:24])), free)
    assert checker.is_free(states[0].tolist()) == free[0] and checker.is_free(tuple(states[1])) == free[1]
    assert checker.is_free(np.zeros(8, dtype=np.int32)) == checker.is_free(np.zeros(8))
    assert checker.is_free(states[0].astype(">f8")) == free[0]
    assert checker.is_free(states.T[:, 0]) == free[0]
    # not at an address of a float64
    shifted = np.frombuffer(b"." + states[:24].tobytes(), dtype=np.float64, offset=1)
    assert not shifted.flags.aligned
    assert checker.is_free(shifted[:8]) == free[0] and np.array_equal(checker.is_free(shifted.reshape(24, 8)), free)


def test_groups_take_fixed_values(robot, world, arm, states):
    whole = cl.Checker(robot, world)
    positions = states.copy()
    positions[:, 7] = 0.02
    assert np.array_equal(arm.is_free(positions[:, :7]), whole.is_free(positions))
    assert np.array_equal(arm.expand(positions[:, :7]), positions)
    hand = cl.Checker(robot, world, group="hand", fixed=dict(zip(robot.joint_names[:7], states[0])))
    assert hand.joint_names == ["finger_joint1"] and hand.upper == [0.04]
    assert hand.is_free([states[0, 7]]) == whole.is_free(states[0])


def test_distances_are_those_of_reports(checker, states):
    found = checker.distance(states, 0.3)
    for i, report in enumerate(checker.check(states, 0.3, max_contacts=0)):
        for kind in ("self", "world"):
            nearest = getattr(report, f"nearest_{kind}")
            distance, pair = getattr(found, f"{kind}_distance")[i], getattr(found, f"{kind}_pair")[i]
            if nearest is None:
                assert distance == np.inf and list(pair) == ["", ""]
                assert np.isnan(getattr(found, f"{kind}_points")[i]).all()
            else:
                assert distance == nearest.distance == min(d.distance for d in report.distances if (d.pair[1] in checker.world.names) == (kind == "world"))
        single = checker.distance(states[i], 0.3)
        assert (single.self_distance, single.world_distance) == (found.self_distance[i], found.world_distance[i])
        assert (single.self_pair or ("", "")) == tuple(found.self_pair[i])
    free = checker.is_free(states)
    assert np.array_equal(free, (found.self_distance > 0) & (found.world_distance > 0))


def test_witness_points_are_as_far_apart_as_the_distance(arm, home):
    found = arm.distance(home, 1.0)
    for points, distance in ((found.self_points, found.self_distance), (found.world_points, found.world_distance)):
        assert np.linalg.norm(points[1] - points[0]) == pytest.approx(distance, abs=1e-9)


def test_gradients_are_differences(arm, home):
    """Central differences of distances that have a derivative."""
    rng, step, compared = np.random.default_rng(5), 1e-6, 0
    for q in home + rng.normal(scale=0.3, size=(20, 7)):
        near = arm.clearance(q, 0.4)
        assert near.gradients.shape == (len(near.pairs), 7) and near.points.shape == (len(near.pairs), 2, 3)
        moved = q + step * np.concatenate([np.eye(7), -np.eye(7)])
        distances = [dict(zip(c.pairs, c.distances)) for c in arm.clearance(moved, 0.5)]
        for row, pair in enumerate(near.pairs):
            if near.distances[row] < 0.01 or not near.unique[row]:
                continue
            differences = [(distances[k][pair] - distances[7 + k][pair]) / (2 * step) for k in range(7)]
            # where another pair of points becomes nearest, there is no derivative
            if np.abs(near.gradients[row] - differences).max() < 1e-4:
                compared += 1
            else:
                assert near.distances[row] > 0.01
    assert compared > 100
    signed = arm.distance(home, 0.4, gradients=True)
    near = arm.clearance(home, 0.4)
    best = min(range(len(near.pairs)), key=lambda row: (near.pairs[row][1] in arm.world.names, near.distances[row]))
    assert signed.self_distance == near.distances[best] and np.array_equal(signed.self_gradient, near.gradients[best])
    assert signed.self_pair == near.pairs[best]


def test_contacts_separate(checker, states):
    """After the translation along the normal, the overlap is gone."""
    colliding = states[~checker.is_free(states)][:40]
    seen = 0
    for report in checker.check(colliding, max_contacts=3):
        assert not report.free and report.pairs and (report.self_collision or report.world_collision)
        assert {contact.pair for contact in report.contacts} <= set(report.pairs)
        for contact in report.contacts:
            assert contact.point.shape == (3,)
            if contact.is_deepest and contact.depth is not None:
                assert np.linalg.norm(contact.normal) == pytest.approx(1)
                assert 0 <= contact.depth_lower <= contact.depth
                seen += 1
    assert seen > 20
    assert checker.check(colliding[0], max_contacts=0).contacts == []


def test_allowed_and_checked_pairs(robot, world, checker, states):
    colliding = states[~checker.is_free(states)][0]
    pairs = checker.check(colliding).pairs
    assert cl.Checker(robot, world, padding=0.01, allowed_collisions=pairs).is_free(colliding)
    assert set(pairs) <= set(checker.pairs) and len(checker.pairs) == 76
    more = cl.Checker(robot, world, checked_collisions=[("link1", "link3")])
    assert ("link1", "link3") in more.pairs and ("link1", "link3") not in checker.pairs
    assert not [pair for pair in cl.Checker(robot, world, check_self=False).pairs if pair[1] not in world.names]
    assert cl.Checker(robot, world, check_world=False).distance(colliding, 9.0).world_distance == np.inf


def test_pairs_may_be_lists_and_dicts_any_mapping(robot, world, home, arm):
    pair = ("hand", "table")
    assert pair in arm.pairs
    for pairs in ([pair], (pair,), [list(pair)], [list(pair)[::-1]]):
        checker = cl.Checker(robot, world, allowed_collisions=pairs)
        assert checker.settings["allowed_collisions"] == [tuple(pairs[0])] and pair not in checker.pairs
    assert cl.Checker(robot, world, allowed_collisions=[list(pair)], checked_collisions=[list(pair)]).pairs
    padded = cl.Checker(robot, world, group="arm", link_padding=MappingProxyType({"hand": 0.05}), fixed=MappingProxyType({"finger_joint1": 0.02}))
    assert padded.settings["link_padding"] == {"hand": 0.05}
    assert padded.expand(home)[7] == arm.expand(home)[7] == 0.02
    by_name = MappingProxyType({"joint2": 0.3})
    assert arm.configuration(by_name)[1] == robot.configuration(by_name)[1] == 0.3
    without = cl.Checker(robot, world, group="arm", fixed=None)
    assert np.array_equal(without.expand(home), cl.Checker(robot, world, group="arm").expand(home))


MIMICS = """<robot name="mimics"><link name="base"/><link name="one"/><link name="two"/><link name="three"/>
  <joint name="a" type="prismatic"><parent link="base"/><child link="one"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
  <joint name="b" type="prismatic"><parent link="one"/><child link="two"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" velocity="1" effort="1"/>
    <mimic joint="a"/></joint>
  <joint name="d" type="prismatic"><parent link="two"/><child link="three"/><axis xyz="1 0 0"/><limit lower="-1" upper="1" velocity="1" effort="1"/></joint>
</robot>"""


def test_positions_of_a_group_are_in_the_order_of_the_robot_without_mimic_joints():
    groups = "".join(
        f"<group name='{name}'>{''.join(f'<joint name={joint!r}/>' for joint in name)}</group>" for name in ("da", "bd", "b")
    )
    robot = cl.Robot.from_urdf(MIMICS, f"<robot name='mimics'>{groups}</robot>")
    assert robot.groups == {"da": ["a", "d"], "bd": ["d"], "b": []}
    with pytest.warns(cl.InputWarning):
        assert cl.Checker(robot, group="da").joint_names == ["a", "d"]
    with pytest.raises(cl.Error, match="group 'b' has no joint that moves by itself"):
        cl.Checker(robot, group="b")


def test_padding(robot, world, home, arm):
    plain, padded = (cl.Checker(robot, world, group="arm", padding=padding) for padding in (0.0, 0.05))
    near, nearer = plain.distance(home, 1.0), padded.distance(home, 1.0)
    assert nearer.world_distance == pytest.approx(near.world_distance - 0.05)
    assert nearer.self_distance == near.self_distance
    assert padded.settings["padding"] == 0.05


def test_free_states_are_found(checker, states):
    colliding = states[~checker.is_free(states)]
    found = [checker.find_free_state(q, max_checks=2000) for q in colliding[:10]]
    assert any(result.found for result in found)
    for q, result in zip(colliding, found):
        if result.found:
            assert checker.is_free(result.state) and result.reason == "found"
            assert np.linalg.norm(result.state - q) == pytest.approx(result.distance)
            assert checker.check_motion(q + result.exit * (result.state - q), result.state).verdict != cl.Verdict.CONTACT
        else:
            assert result.state is None and result.reason in ("not_movable", "unfinished", "beyond_limits")
    locked = checker.find_free_state(colliding[0], locked=checker.joint_names)
    assert (locked.found, locked.reason) == (False, "not_movable") and locked.pair in checker.pairs
    free = states[checker.is_free(states)][0]
    already = checker.find_free_state(free, clearance=0.0)
    assert already.found and np.array_equal(already.state, free)
