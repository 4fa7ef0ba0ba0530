"""Tests of `benches/node` with made-up figures: when a row of the results is missed."""

import sys

import pytest

from node_process import ROOT

sys.path.insert(0, str(ROOT / "benches/node"))
import latency
import measure
import memory
import robots
from reports import Told
from rows import Row, markdown

ROBOT = robots.Robot("arm", "base", (), {})
QUICK = {"latency: p99 (ms)": 0.2} | {f"latency since start: {part} (ms)": 0.2 for part in ("median", "p99", "max")}
NOTHING = dict.fromkeys(latency.COUNTS, 0.0) | {"joint states received": 0.0}


def reported(at, **changed):
    numbers = NOTHING | QUICK | {"pairs checked": 10.0, "mean compute time (ms)": 0.1}
    return Told(at, numbers | {key.replace("_", " "): value for key, value in changed.items()})


def latency_row(limit=1.0, p99=0.2, **changed):
    last = reported(10.0, **({"joint_states_received": 10_000.0} | changed))
    last.numbers["latency since start: p99 (ms)"] = p99
    return latency.row(ROBOT, [reported(0.0), last], limit, False, "")


def test_a_row_of_latency_is_reached_without_drops_and_in_time():
    assert latency_row().reached


@pytest.mark.parametrize(
    "changed",
    [
        {"messages_dropped": 1.0},
        {"joint_states_lost": 1.0},
        {"joint_states_passed_over": 1.0},
        {"p99": 1.01},
        {"joint_states_received": 9_000.0},
    ],
    ids=lambda changed: next(iter(changed)),
)
def test_a_row_of_latency_is_missed(changed):
    assert latency_row(**changed).reached is False


@pytest.mark.parametrize(("growth", "reached"), [(0.0, True), (0.01, True), (0.1, False)])
def test_memory_that_grows_is_missed(growth, reached):
    samples = memory.np.array([(5.0 * number, 100.0 + growth * number) for number in range(200)])
    before, after = reported(0.0, world_revision=1.0), reported(100.0, world_revision=900.0, joint_states_received=100_000.0)
    assert memory.row(ROBOT, samples, before, after).reached == reached


def test_a_robot_that_is_not_here_is_passed_over_in_clear_words(monkeypatch, tmp_path):
    monkeypatch.setattr(robots, "SHARED", tmp_path)
    row = measure.attempt("start", lambda: robots.robot("g1"))
    assert row.reached is None
    assert "g1" in row.note and str(tmp_path) in row.note
    assert "not measured" in markdown([row], {})


def test_what_fails_is_missed():
    def fail():
        raise AssertionError("waited in vain")

    row = measure.attempt("start", fail)
    assert row.reached is False
    assert "waited in vain" in markdown([row, Row("a", "1", "2", True)], {"date": "today"})
