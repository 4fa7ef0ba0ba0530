"""Tests of `~/check_states` and `~/get_distances` against hand-computed results, and against `~/state`."""

from math import cos, inf, isnan, nan, pi, sin

import pytest
from clearance_msgs.msg import BodyPair, CollisionState
from clearance_msgs.srv import CheckMotion, CheckStates, GetDistances

import two_link
from cell import STALE_AFTER, Cell
from motions import Motions
from scene import ball, diff, obstacle, pose, sphere
from scene_client import SceneClient
from states import States, pair_of

ERROR, FREE, COLLIDING, UNKNOWN = (
    CheckStates.Response.ERROR,
    CheckStates.Response.FREE,
    CheckStates.Response.COLLIDING,
    CheckStates.Response.UNKNOWN,
)
ACCURACY = 1e-9  # [m]
MOST = 10_000  # states of a batch
HEARTBEATS = 10
ONTO = (0, pi)


@pytest.fixture(scope="module")
def cell(module_peer):
    """One node answers for the whole module: every question here leaves it as it was."""
    with Cell(module_peer) as cell:
        cell.questions = States(module_peer, cell.node)
        cell.evaluate(joint1=0, joint2=0)
        yield cell


def test_every_state_of_a_batch_gets_the_answer_worked_out_by_hand(cell):
    states = [(response.joint1, response.joint2) for response in two_link.FREE] + two_link.COLLIDING
    distances = [response.distance for response in two_link.FREE] + [0] * len(two_link.COLLIDING)
    response = cell.questions.check(states, with_distance=True)

    assert (response.verdict, response.message, response.reason_code) == (COLLIDING, "", "")
    assert list(response.verdicts) == [FREE] * len(two_link.FREE) + [COLLIDING] * len(two_link.COLLIDING)
    assert list(response.distances) == pytest.approx(distances, abs=ACCURACY)
    assert all(pair_of(response, i) == {"base", "tip"} for i in range(len(states)))
    assert list(response.body_types) == [BodyPair.LINK] * 2
    assert (response.model_revision, response.world_revision) == (1, 0)
    assert 0 < response.compute_time < 1

    without = cell.questions.check(states)
    assert list(without.verdicts) == list(response.verdicts)
    assert len(without.distances) == 0
    reported = [bool(pair_of(without, i)) for i in range(len(states))]
    assert reported == [verdict == COLLIDING for verdict in without.verdicts]


def test_joints_beyond_their_limits_are_reported_and_checked_all_the_same(cell):
    response = cell.questions.check([(0, 0), (90, 0), (0, 4)])
    assert response.verdict in (FREE, COLLIDING) and ERROR not in response.verdicts
    assert "state 1: joint 'joint1' is at 90, outside its limits [-3.14" in response.message
    assert "degrees?" in response.message and "1 more" in response.message


def test_only_free_states_together_are_free(cell):
    assert cell.questions.check([(0, 0), (1, 1)]).verdict == FREE
    assert cell.questions.check([(0, 0), ONTO, (1, 1)]).verdict == COLLIDING


def test_beyond_the_limit_no_distance_is_reported(cell):
    response = cell.questions.check([(0, 0), (0, 5 * pi / 6)], with_distance=True, distance_limit=0.3)

    assert list(response.verdicts) == [FREE, FREE]
    assert list(response.distances) == pytest.approx([inf, 0.2])
    assert (pair_of(response, 0), pair_of(response, 1)) == (set(), {"base", "tip"})


def test_a_timeout_leaves_states_unknown_and_never_free(cell):
    for with_distance in (False, True):
        response = cell.questions.check([(0, 0), ONTO], timeout=1e-9, with_distance=with_distance)
        assert (response.verdict, response.reason_code) == (UNKNOWN, "deadline")
        assert list(response.verdicts) == [UNKNOWN] * 2
        assert all(isnan(distance) for distance in response.distances)
    response = cell.questions.distances((0, 0), timeout=1e-9)
    assert (response.verdict, response.reason_code, response.pairs) == (UNKNOWN, "deadline", [])
    assert cell.questions.check([(0, 0)], timeout=60.0).verdict == FREE


def test_joints_that_are_not_named_stand_where_they_are(cell):
    cell.evaluate(joint1=0, joint2=pi)
    try:
        assert list(cell.questions.check([(0,), (1,)], joints=["joint1"]).verdicts) == [COLLIDING] * 2
        assert cell.questions.distances((1,), joints=["joint1"]).verdict == COLLIDING
    finally:
        cell.evaluate(joint1=0, joint2=0)
    assert list(cell.questions.check([(0,), (1,)], joints=["joint1"]).verdicts) == [FREE] * 2


def test_distances_of_the_current_state_are_those_of_the_state_topic(cell):
    for positions in ((0, 0), (0, 5 * pi / 6), ONTO):
        state = cell.evaluate(joint1=positions[0], joint2=positions[1])
        response = cell.questions.distances()
        assert response.verdict == (COLLIDING if state.status == CollisionState.COLLIDING else FREE)
        assert response.pairs_found == len(response.pairs) == 1
        assert response.pairs[0] == state.nearest
    cell.evaluate(joint1=0, joint2=0)


@pytest.mark.parametrize("expected", two_link.FREE, ids=str)
def test_nearest_points_are_where_they_were_worked_out(cell, expected):
    response = cell.questions.distances((expected.joint1, expected.joint2))

    (pair,) = response.pairs
    points = {
        pair.pair.body_a: pair.witness_points[0],
        pair.pair.body_b: pair.witness_points[1],
    }
    assert pair.distance == pytest.approx(expected.distance, abs=ACCURACY)
    assert (points["base"].x, points["base"].y) == pytest.approx(expected.on_base, abs=1e-6)
    assert (points["tip"].x, points["tip"].y) == pytest.approx(expected.on_tip, abs=1e-6)


@pytest.mark.parametrize(
    ("states", "terms", "named"),
    [
        ([(0, 0)], {"joints": ["joint1", "wrist"]}, "'wrist'"),
        ([(0, 0)], {"joints": ["joint1", "joint1"]}, "'joint1' is given twice"),
        ([(0, 0)], {"joints": []}, "joint_names is empty"),
        ([], {}, "positions has 0"),
        ([(0, 0), (0,)], {}, "positions has 3"),
        ([(0, 0), (0, nan)], {}, "state 1: joint 'joint2' has position NaN"),
        ([(inf, 0)], {}, "state 0: joint 'joint1' has position inf"),
        ([(1e300, 0)], {}, "'joint1' has position 1e300"),
        ([(0, 0)] * 10_001, {}, "10001 states"),
        ([(0, 0)] * 500_000, {}, "500000 states"),
        ([(0, 0)], {"timeout": -1.0}, "timeout is -1"),
        ([(0, 0)], {"distance_limit": nan}, "distance_limit is NaN"),
        ([(0, 0)], {"joints": ["x" * 1_000_000, "joint2"]}, "the name 'xxx"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_bad_batch_is_rejected_by_name(cell, states, terms, named):
    response = cell.questions.check(states, **terms)

    assert (response.verdict, response.reason_code) == (ERROR, "bad_request")
    assert named in response.message
    assert len(response.message) < 500
    assert len(response.verdicts) == 0


@pytest.mark.parametrize(
    ("state", "terms", "named"),
    [
        ((0, 0), {"joints": ["joint1", "wrist"]}, "'wrist'"),
        ((0,), {}, "positions has 1 numbers, but joint_names has 2"),
        ((0, nan), {}, "'joint2' has position NaN"),
        ([0.0] * 500_000, {}, "positions has 500000 numbers"),
        ((0, 0), {"joints": ["x" * 1_000_000, "joint2"]}, "the name 'xxx"),
        ((0, 0), {"bodies": ["base", "x" * 1_000_000]}, "'xxx"),
        ((0, 0), {"bodies": ["base"] * 100_000 + ["table"]}, "'table'"),
        ((0, 0), {"bodies": ["base", "table"]}, "'table'"),
        ((0, 0), {"max_distance": -1.0}, "max_distance is -1"),
        ((0, 0), {"timeout": inf}, "timeout is inf"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_bad_question_for_distances_is_rejected_by_name(cell, state, terms, named):
    response = cell.questions.distances(state, **terms)

    assert (response.verdict, response.reason_code, response.pairs) == (GetDistances.Response.ERROR, "bad_request", [])
    assert named in response.message
    assert len(response.message) < 500


def test_a_batch_of_the_most_states_arrives_whole(cell):
    states = [(0, pi * i / MOST) for i in range(MOST)]
    response = cell.questions.check(states, with_distance=True)

    assert response.compute_time > 0
    assert len(response.verdicts) == len(response.distances) == MOST
    free = [joint2 < two_link.FIRST_TOUCH for _, joint2 in states]
    assert [verdict == FREE for verdict in response.verdicts] == free
    assert [distance > 0 for distance in response.distances] == free
    assert response.distances[0] == pytest.approx(0.7)
    assert set(response.pair_a) | set(response.pair_b) == {0, 1}


def test_without_a_model_there_is_an_error(start):
    cell = start(urdf=None)
    questions = States(cell.peer, cell.node)

    for response in (questions.check([(0, 0)]), questions.distances((0, 0)), questions.distances()):
        assert (response.verdict, response.reason_code, response.model_revision) == (ERROR, "no_model", 0)
        assert response.message


def test_without_a_joint_state_only_what_is_named_is_known(start):
    cell = start(driving=False)
    questions = States(cell.peer, cell.node)
    cell.has_model()

    response = questions.distances()
    assert (response.verdict, response.reason_code) == (ERROR, "no_joint_state")
    response = questions.check([(0,)], joints=["joint1"])
    assert response.verdict == FREE
    assert "'joint2'" in response.message

    cell.driver.resume()
    cell.evaluate(joint1=0, joint2=0)
    assert questions.distances().verdict == FREE
    cell.grows_old()
    cell.driver.pause()
    cell.unknown("stale")
    response = questions.distances()
    assert (response.verdict, response.reason_code) == (ERROR, "no_joint_state")
    assert f"stale_after is {STALE_AFTER:g} s" in response.message


def test_a_world_that_is_not_known_is_an_error(start):
    cell = start(parameters={"point_cloud_topics": ["points"]})
    questions = States(cell.peer, cell.node)
    cell.unknown("stale_world")

    for response in (questions.check([(0, 0)]), questions.distances((0, 0)), questions.distances()):
        assert (response.verdict, response.reason_code) == (ERROR, "stale_world")
        assert "is the sensor running?" in response.message


def test_pairs_come_nearest_first_and_only_those_that_are_wanted(start):
    cell = start()
    questions = States(cell.peer, cell.node)
    cell.evaluate(joint1=0, joint2=0)
    SceneClient(cell).change(ball("ball", 2.5))
    response = questions.distances((0, 0))

    assert (response.verdict, response.message) == (FREE, "")
    distances = [pair.distance for pair in response.pairs]
    assert distances == sorted(distances)
    nearest = response.pairs[0].pair
    assert {(nearest.body_a, nearest.type_a), (nearest.body_b, nearest.type_b)} == {
        ("tip", BodyPair.LINK),
        ("ball", BodyPair.OBSTACLE),
    }
    assert distances[0] == pytest.approx(0.3)

    def bodies(response):
        return [{pair.pair.body_a, pair.pair.body_b} for pair in response.pairs]

    assert bodies(questions.distances((0, 0), max_distance=0.5)) == [{"tip", "ball"}]
    capped = questions.distances((0, 0), max_pairs=1)
    assert (bodies(capped), capped.pairs_found) == ([{"tip", "ball"}], response.pairs_found)
    of_base = bodies(questions.distances((0, 0), bodies=["base"]))
    assert of_base and all("base" in pair for pair in of_base)
    # What is told does not change what is so.
    assert questions.distances(ONTO, bodies=["ball"], max_distance=0.01).verdict == COLLIDING

    batch = questions.check([(0, 0), (0.1, 0)], with_distance=True)
    assert pair_of(batch, 0) == {"tip", "ball"}
    assert batch.distances[0] == pytest.approx(0.3)
    assert batch.world_revision > 0


def longest_silence(cell, act):
    """The longest time [s] between two messages on `~/state` while something is done again and again, as the node made them."""
    start = cell.peer.now()

    def states():
        act()
        found = cell.states.after(start)
        return found if len(found) >= HEARTBEATS else None

    made = [
        message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec + message.age
        for message in cell.peer.wait_for(states, f"{HEARTBEATS} states meanwhile")
    ]
    return max(b - a for a, b in zip(made, made[1:], strict=False))


def test_eight_clients_in_a_loop_all_get_their_answers_while_states_go_on(peer, start):
    cell = start()
    clients = [States(peer, cell.node) for _ in range(8)]
    cell.evaluate(joint1=0, joint2=0)
    angles = [2.6 + 0.05 * i for i in range(8)]
    batches = [[(0, angle)] * 20 + [(0, pi)] for angle in angles]

    def ask():
        for _ in range(10):
            futures = [client.ask(batch) for client, batch in zip(clients, batches, strict=True)]
            others = [client.ask_distances((0, angle)) for client, angle in zip(clients, angles, strict=True)]
            for angle, future, other in zip(angles, futures, others, strict=True):
                expected = FREE if angle < two_link.FIRST_TOUCH else COLLIDING
                response = peer.result(future)
                assert list(response.verdicts) == [expected] * 20 + [COLLIDING]
                assert peer.result(other).verdict == expected

    # ten heartbeats: whoever else works on this machine may hold the node up
    start = cell.state_now()
    assert longest_silence(cell, ask) < 0.5
    assert {state.status for state in cell.states.after(start)} == {CollisionState.FREE}


def test_a_long_motion_holds_no_batch_up(peer, start):
    cell = start()
    questions, motions = States(peer, cell.node), Motions(peer, cell.node)
    cell.evaluate(joint1=0, joint2=0)
    # joint 1 turns round and round, and nothing ever touches
    motion = motions.ask((0, 0), (1e8, 0), timeout=5.0, certificate=True)

    assert questions.check([(0, 0)] * 100).verdict == FREE
    assert questions.distances().verdict == FREE
    assert not motion.done()
    assert peer.result(motion).verdict == CheckMotion.Response.UNDECIDED


def crowd(questions):
    """The answers to more batches and distances than may wait, asked by turns: each takes much longer than it takes to come.

    There are fewer of each kind than the 64 that the middleware holds for a node that has no turn to read them.
    """
    ring = [(2 * pi * i / 1000,) for i in range(1000)]
    asked = [
        (questions.ask(ring, joints=["joint1"], with_distance=True), questions.ask_distances((0, 0), max_pairs=1)) for _ in range(24)
    ]
    return [[questions.response(future) for future in kind] for kind in zip(*asked, strict=True)]


def test_a_request_while_too_many_wait_is_rejected_at_once(peer, start):
    cell = start()
    questions = States(peer, cell.node)
    cell.evaluate(joint1=0, joint2=0)
    ring = [pose(3 * cos(angle), 3 * sin(angle)) for angle in (2 * pi * i / 1000 for i in range(1000))]
    SceneClient(cell).apply(diff(*(obstacle(f"ball {i}", sphere(0.01), at=at) for i, at in enumerate(ring))))
    start = peer.now()

    def both_kinds_are_refused():
        batches, distances = crowd(questions)
        told_batches = {(response.verdict, response.reason_code, len(response.verdicts)) for response in batches}
        told_distances = {(response.verdict, response.reason_code, len(response.pairs)) for response in distances}
        busy = (ERROR, "busy", 0)
        assert told_batches <= {busy, (FREE, "", 1000)}
        assert told_distances <= {busy, (FREE, "", 1)}
        codes = [response.reason_code for response in batches + distances]
        # the sixteen places are for both kinds, and nobody is refused while one is free
        assert "busy" not in codes or codes.count("") >= 16
        return busy in told_batches and busy in told_distances

    # a client that has no turn between its questions finds places that became free: then it asks once more
    peer.wait_for(both_kinds_are_refused, "a refusal of both kinds")
    cell.peer.wait_for(lambda: cell.states.after(start), "a state: the monitor went on")
