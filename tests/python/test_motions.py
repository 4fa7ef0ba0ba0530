"""Tests of motion checks: edges and trajectories against sampled states, least distances, certificates."""

import json

import numpy as np
import pytest

import clearance as cl


@pytest.fixture(scope="module")
def edges(arm, states):
    return states[:60, :7], states[60:120, :7] * 0.3 + states[:60, :7] * 0.7


def test_edges_against_samples(arm, edges):
    reports = arm.check_edges(*edges)
    free = arm.are_edges_free(*edges)
    assert reports.verdicts.dtype == np.int8 and reports.verdicts.shape == (60,) and reports.t.shape == (60, 2)
    assert np.array_equal(free, reports.verdicts == cl.Verdict.FREE) and 0 < free.sum() < 60
    q0, q1 = edges
    steps = np.linspace(0, 1, 201)[:, None, None]
    sampled = arm.is_free(q0 + steps * (q1 - q0))
    assert sampled[:, free].all()
    touching = np.flatnonzero(reports.verdicts == cl.Verdict.CONTACT)
    first, last = reports.t[touching].T
    assert not arm.is_free(q0[touching] + last[:, None] * (q1 - q0)[touching]).any()
    for edge, begin in zip(touching, first):
        assert sampled[steps[:, 0, 0] < begin, edge].all()
    assert ((reports.reasons != 0) == (reports.verdicts == cl.Verdict.UNDECIDED)).all()


def test_edges_broadcast(arm, edges, home):
    q0, q1 = edges
    fan = arm.are_edges_free(home, q1.reshape(6, 10, 7))
    assert fan.shape == (6, 10)
    assert fan.ravel().tolist() == [arm.are_edges_free(home, q) for q in q1]
    assert type(arm.are_edges_free(home, home)) is bool
    assert arm.are_edges_free(q0[:0], q1[:0]).shape == (0,)
    with pytest.raises(ValueError, match="can not be broadcast"):
        arm.are_edges_free(q0[:3], q1[:2])
    for threads in (1, 2):
        assert np.array_equal(arm.are_edges_free(q0, q1, num_threads=threads), arm.are_edges_free(q0, q1))


def test_edges_broadcast_as_arrays_of_numpy(arm, home):
    """Shapes of ones and missing dimensions, against the arrays that NumPy broadcasts."""
    rng = np.random.default_rng(3)
    shapes = [((), (3,)), ((2, 1), (3,)), ((2, 3), (2, 1)), ((1,), (2, 3)), ((4, 1, 2), (1, 3, 1)), ((0,), (2, 1)), ((1, 1), (1,))]
    for one, other in shapes:
        q0, q1 = (home + rng.normal(scale=0.5, size=(*shape, 7)) for shape in (one, other))
        found = arm.check_edges(q0, q1)
        expected = arm.check_edges(*(np.array(q) for q in np.broadcast_arrays(q0, q1)))
        assert found.verdicts.shape == np.broadcast_shapes(one, other)
        assert np.array_equal(found.verdicts, expected.verdicts) and np.array_equal(found.t, expected.t, equal_nan=True)
        assert np.array_equal(arm.are_edges_free(q0, q1), found.verdicts == cl.Verdict.FREE)


def test_edges_that_are_not_checked_in_time(arm, edges):
    q0, q1 = edges
    late = arm.check_edges(q0, q1, timeout=0)
    assert (late.verdicts == cl.Verdict.UNDECIDED).all() and (late.reasons == cl.Reason.UNCHECKED).all()
    assert np.array_equal(late.t, np.broadcast_to([0.0, 1.0], (60, 2)))
    assert not arm.are_edges_free(q0, q1, timeout=0).any() and arm.are_edges_free(q0[0], q0[0], timeout=0) is False
    assert np.array_equal(arm.are_edges_free(q0, q1, timeout=np.inf), arm.are_edges_free(q0, q1))
    # rows are validated all the same
    with pytest.raises(cl.Error, match=r"q1 in row \[59\]"):
        arm.are_edges_free(q0, np.where(np.arange(60)[:, None] == 59, np.nan, q1), timeout=0)


def test_a_motion_is_its_edge(arm, edges):
    reports = arm.check_edges(*edges)
    for i, (q0, q1) in enumerate(zip(*edges)):
        report = arm.check_motion(q0, q1, certificate=True)
        assert report.verdict == reports.verdicts[i] and report.free == (report.verdict is cl.Verdict.FREE)
        assert (report.certificate is not None) == report.free
        assert (report.t is None) == report.free and (report.pair is None) <= report.free
        if report.t is not None:
            assert arm.check_motion(q0, q1).t == tuple(reports.t[i])
        assert (report.reason is not None) == (report.verdict == cl.Verdict.UNDECIDED)


def test_certificates_are_verified(robot, world, arm, home, tmp_path):
    goal = home + 0.1
    certificate = arm.check_motion(home, goal, certificate=True).certificate
    edge = tuple(arm.expand(q) for q in (home, goal))
    verified = cl.verify(certificate, robot, world, edge=edge, tolerance=5e-4)
    assert verified and verified.valid and verified.reason is None and verified.pairs == len(certificate.pairs) == 76
    assert cl.verify(certificate, robot, world, trajectory=(None, np.stack(edge)))
    # of another motion, robot, world or settings
    for rejected in (
        cl.verify(certificate, robot, world, edge=edge[::-1]),
        cl.verify(certificate, robot, world, edge=edge, tube=0.01),
        cl.verify(certificate, robot, world, edge=edge, tolerance=1e-3),
        cl.verify(certificate, robot, edge=edge),
        cl.verify(certificate, robot, world, edge=edge, padding=0.01),
    ):
        assert not rejected and not rejected.valid and rejected.reason
    path = tmp_path / "proof.json"
    certificate.save(path)
    assert cl.Certificate.load(path) == certificate == cl.Certificate(certificate.to_json())
    text = json.loads(certificate.to_json())
    text["segments"][0]["proofs"][0][3] += 1.0
    with pytest.raises(cl.Error, match="digest"):
        cl.Certificate(json.dumps(text))
    with pytest.raises(cl.Error, match="no certificate"):
        cl.Certificate("{}")
    with pytest.raises(TypeError, match="not both"):
        cl.verify(certificate, robot, world, edge=edge, trajectory=(None, np.stack(edge)))


def test_trajectories(robot, world, arm, home):
    points = home + np.array([0, 0.05, 0.1])[:, None]
    report = arm.check_trajectory([0.0, 1.0, 2.0], points, np.full((3, 7), 0.05), certificate=True)
    assert report.free and report.segment == 1 and report.time is None
    arguments = (np.arange(3.0), arm.expand(points), np.pad(np.full((3, 7), 0.05), ((0, 0), (0, 1))))
    assert cl.verify(report.certificate, robot, world, trajectory=arguments)
    assert not cl.verify(report.certificate, robot, world, trajectory=arguments[:2])
    far = arm.check_trajectory([0, 1, 2, 3], np.concatenate([points, home[None] + [0, 1.5, 0, 0, 0, 0, 0]]))
    assert far.verdict == cl.Verdict.CONTACT and far.segment == 2 and 2 <= far.time[0] <= far.time[1] <= 3
    assert far.pair[1] in world.names and not far.free
    assert arm.check_trajectory(None, points).free
    for times, words in (([0, 0, 0], "does not come after"), ([0, 1], r"must be \(3,\)"), ([0, 1, np.nan], r"times\[2\] is NaN"),
        ([-1, 0, 1], r"times\[0\] is -1 s, but times are from the start"), ([0, 2, 1], r"times\[2\] is 1 s, which does not come after times\[1\], 2 s"),
        ([np.nan, 1, 2], r"times\[0\] is NaN"), ([0, 1, np.inf], r"times\[2\] is inf")):
        with pytest.raises(ValueError, match=words):
            arm.check_trajectory(times, points)
    with pytest.raises(ValueError, match="shape of positions"):
        arm.check_trajectory([0, 1, 2], points, np.zeros((2, 7)))
    with pytest.raises(ValueError, match="accelerations need velocities"):
        arm.check_trajectory([0, 1, 2], points, accelerations=np.zeros((3, 7)))


def test_options(arm, home):
    touching = home + [0, 1.5, 0, 0, 0, 0, 0]
    stopped = arm.check_motion(home, touching, budget=1)
    assert stopped.verdict == cl.Verdict.UNDECIDED and stopped.reason == cl.Reason.BUDGET
    late = arm.check_motion(home, touching, timeout=0.0)
    assert (late.verdict, late.reason) == (cl.Verdict.UNDECIDED, cl.Reason.DEADLINE)
    # also where a proof takes no time
    for late in (arm.check_motion(home, home, timeout=0), arm.check_trajectory(None, [home, home], timeout=0)):
        assert (late.verdict, late.reason, late.certificate) == (cl.Verdict.UNDECIDED, cl.Reason.DEADLINE, None)
        assert isinstance(late, cl.MotionReport) and not late.free
    assert arm.check_motion(home, home, timeout=np.inf).free and arm.check_motion(home, home, timeout=1e300).free
    assert arm.check_motion(home, touching, any_contact=True).verdict == cl.Verdict.CONTACT
    tube = arm.check_motion(home, home, tube=1.5)
    assert (tube.verdict, tube.reason) == (cl.Verdict.UNDECIDED, cl.Reason.TUBE)
    assert arm.check_motion(home, home, tube=np.full(7, 1e-3)).free
    with pytest.raises(cl.Error, match="tolerance"):
        arm.check_motion(home, home, tolerance=0.0)
    with pytest.raises(TypeError, match="no option 'tolerence'"):
        arm.are_edges_free(home, home, tolerence=1e-3)


def least_at(arm, states):
    found = [arm.distance(q, max_distance=np.inf) for q in states]
    return min(near.self_distance for near in found), min(near.world_distance for near in found)


def test_least_distances_along_motions(arm, edges):
    """Against sampled distances: bounds hold, and the upper one is that of the named pair at its t."""
    finite = 0
    for q0, q1 in zip(edges[0][:12], edges[1][:12]):
        found = arm.clearance_along(q0, q1)
        assert isinstance(found, cl.MotionClearance) and found.reason is None and found.evaluations > 0
        sampled = least_at(arm, q0 + np.linspace(0, 1, 101)[:, None] * (q1 - q0))
        for least, at_samples, name in zip((found.nearest_self, found.nearest_world), sampled, ("self", "world")):
            assert least.lower <= at_samples + 1e-9 and least.lower <= least.upper
            assert least.upper - least.lower <= max(1e-3, 0.01 * least.upper) + 1e-12
            assert least.upper <= at_samples + max(1e-3, 0.01 * least.upper)
            there = arm.distance(q0 + least.t * (q1 - q0), max_distance=np.inf)
            assert getattr(there, f"{name}_distance") <= least.upper + 1e-9
            assert least.points.shape == (2, 3) and least.segment == 0 and least.time is None
            if least.upper > 0:
                assert np.linalg.norm(least.points[0] - least.points[1]) == pytest.approx(least.upper)
        assert found.lower == min(found.nearest_self.lower, found.nearest_world.lower)
        assert found.upper == min(found.nearest_self.upper, found.nearest_world.upper)
        assert found.free == arm.are_edges_free(q0, q1)
        finite += found.free
    assert 0 < finite < 12


def test_least_distances_along_trajectories(arm, home):
    points = home + np.array([0, 0.05, 0.1])[:, None]
    found = arm.clearance_along_trajectory([0.0, 1.0, 3.0], points)
    nearest = found.nearest_world
    assert nearest.segment in (0, 1) and nearest.time == pytest.approx(nearest.t if nearest.segment == 0 else 1 + 2 * nearest.t)
    loose = arm.clearance_along_trajectory(None, points, deviation=0.01)
    assert loose.lower < found.lower and loose.nearest_world.time is None and loose.reason == cl.Reason.TUBE
    assert arm.clearance_along_trajectory(None, points, tube=0.004, deviation=np.full(7, 0.006)).lower == pytest.approx(loose.lower)
    assert arm.clearance_along(home, points[2], timeout=0.0).reason == cl.Reason.DEADLINE
    alone = cl.Checker(arm.robot, group="arm").clearance_along(home, points[2])
    assert alone.nearest_world is None and alone.lower == alone.nearest_self.lower


def test_the_first_time_within_a_distance(arm, home):
    goal = home + 0.1
    along = arm.clearance_along(home, goal)
    assert arm.event_distance(home, goal, 0.9 * along.lower).free
    found = arm.event_distance(home, goal, along.upper + 1e-3)
    assert found.verdict == cl.Verdict.CONTACT and found.t[0] <= found.t[1]
    near = arm.distance(home + found.t[1] * (goal - home), max_distance=1.0)
    assert min(near.self_distance, near.world_distance) <= along.upper + 1e-3 + 1e-9
    same = arm.check_motion(home, goal, margin=along.upper + 1e-3)
    assert (same.verdict, same.t, same.pair) == (found.verdict, found.t, found.pair)
    assert not arm.are_edges_free(home, goal, margin=along.upper + 1e-3) and arm.are_edges_free(home, goal)
    assert arm.check_trajectory(None, [home, goal], margin=along.upper + 1e-3).verdict == cl.Verdict.CONTACT
    with pytest.raises(TypeError, match="event_distance has no option 'margin'"):
        arm.event_distance(home, goal, 0.1, margin=0.1)


def test_certificates_prove_a_margin(robot, world, arm, home):
    goal = home + 0.1
    margin = 0.9 * arm.clearance_along(home, goal).lower
    edge = tuple(arm.expand(q) for q in (home, goal))
    certificate = arm.check_motion(home, goal, certificate=True, margin=margin).certificate
    assert certificate.margin == margin
    assert cl.verify(certificate, robot, world, edge=edge, margin=margin)
    assert "margin" in cl.verify(certificate, robot, world, edge=edge, margin=1.01 * margin).reason
    plain = arm.check_motion(home, goal, certificate=True).certificate
    assert plain.margin == 0 and not cl.verify(plain, robot, world, edge=edge, margin=margin)
    with pytest.raises(cl.Error, match="margin is -1"):
        cl.verify(plain, robot, world, edge=edge, margin=-1)


def test_one_tolerance_in_an_array_is_that_of_the_one_joint():
    """Not one for every joint: those that mimic it would need more."""
    link = '<link name="{}"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>'
    joint = (
        '<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{2}"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" effort="1" velocity="1"/>{3}</joint>'
    )
    urdf = "".join([link.format(name) for name in "abc"]) + joint.format("lead", "a", "b", "")
    follow = joint.format("follow", "b", "c", '<mimic joint="lead" multiplier="0.5"/>')
    robot = cl.Robot.from_urdf(f'<robot name="r">{urdf}{follow}</robot>')
    checker = cl.Checker(robot)
    tube = lambda given: checker.check_motion([0.0], [0.1], tube=given, certificate=True).certificate  # noqa: E731
    assert cl.verify(tube([0.01]), robot, tube=[0.01])
    assert cl.verify(tube(0.01), robot, tube=[0.02]) and not cl.verify(tube(0.01), robot, tube=[0.01])
    free = cl.Checker(cl.Robot.from_urdf(f'<robot name="r">{urdf}{joint.format("follow", "b", "c", "")}</robot>'))
    with pytest.raises(ValueError, match=r"tube has shape \(1,\)"):
        free.check_motion([0.0, 0.0], [0.1, 0.0], tube=[0.01])


def test_a_deviation_between_samples_is_part_of_the_proof(robot, world, arm, home):
    points = home + np.array([0, 0.05, 0.1])[:, None]
    report = arm.check_trajectory(None, points, deviation=1e-3, certificate=True)
    assert report.free
    whole = (None, arm.expand(points))
    # the tracking tolerance of the certificate is of all positions of the robot: those of the arm
    deviation = np.array([1e-3 if name in arm.joint_names else 0.0 for name in robot.joint_names])
    assert cl.verify(report.certificate, robot, world, trajectory=whole, tube=deviation)
    assert not cl.verify(report.certificate, robot, world, trajectory=whole)
    assert arm.check_trajectory(None, points, deviation=1.5).reason == cl.Reason.TUBE
    for bad, words in ((-1.0, "deviation has -1"), (np.nan, "deviation has NaN"), ([1.0, 2.0], "deviation has shape")):
        with pytest.raises(ValueError, match=words):
            arm.check_trajectory(None, points, deviation=bad)


MIMIC = """<robot name="r"><link name="a"/>
  <link name="b"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="c"><collision><origin xyz="1 0 0"/><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="j" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="1 0 0"/>
    <limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
  <joint name="k" type="continuous"><parent link="a"/><child link="c"/><axis xyz="0 0 1"/><origin xyz="0 5 0"/>
    <mimic joint="j" multiplier="0.5"/></joint></robot>"""


def test_one_tolerance_is_for_every_joint(checker, arm, robot, world, home):
    """As `--tube N` of the program: also for mimic joints, and for those that are not in the group."""
    mimicking = cl.Robot.from_urdf(MIMIC)
    one = cl.Checker(mimicking)
    certificate = one.check_motion([0.0], [0.1], tube=0.01, certificate=True).certificate
    assert cl.verify(certificate, mimicking, edge=([0.0], [0.1]), tube=0.01)
    assert '"tube":[0.02' in certificate.to_json().replace(" ", "")
    q1 = home + 1e-3
    of_group = arm.check_motion(home, q1, tube=0.003, certificate=True)
    assert of_group.verdict == cl.Verdict.FREE
    edge = (arm.expand(home), arm.expand(q1))
    assert cl.verify(of_group.certificate, robot, world, edge=edge, tube=0.003)


def test_truth_values(checker, home):
    q = checker.robot.configuration(checker.robot.group_states["home"])
    assert checker.check_motion(q, q) and checker.check(q)
    assert [bool(verdict) for verdict in (cl.Verdict.FREE, cl.Verdict.CONTACT, cl.Verdict.UNDECIDED)] == [True, False, False]


def test_a_trajectory_the_short_way_is_verified():
    urdf = MIMIC.replace('type="prismatic"', 'type="continuous"').replace('<mimic joint="j" multiplier="0.5"/>', "")
    robot = cl.Robot.from_urdf(urdf)
    positions = np.zeros((3, 2))
    positions[:, 0] = [3.0, -3.0, -2.5]
    report = cl.Checker(robot).check_trajectory(None, positions, shortest=True, certificate=True)
    assert report.free
    assert cl.verify(report.certificate, robot, trajectory=(None, positions), shortest=True)
    assert not cl.verify(report.certificate, robot, trajectory=(None, positions))
    with pytest.raises(TypeError, match="shortest belongs to trajectory"):
        cl.verify(report.certificate, robot, shortest=True)


def test_pairs_that_cannot_be_checked_are_named(robot):
    with pytest.raises(cl.Error, match="checked_collisions: 'hand' and 'hand' cannot be checked: they are one body"):
        cl.Checker(robot, checked_collisions=[("hand", "hand")])
    with pytest.raises(cl.Error, match="check_self or check_world is off"):
        cl.Checker(robot, checked_collisions=[("link1", "hand")], check_self=False)
