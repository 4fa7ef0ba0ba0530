"""Tests of rejected parameter changes, with their reasons, and of atomic changes."""

import pytest

from cell import QUICK, Cell


@pytest.fixture(scope="module")
def cell(module_peer):
    """One node for the whole module: what is refused changes nothing."""
    with Cell(module_peer) as cell:
        yield cell


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("heartbeat_rate", 0.0),
        ("heartbeat_rate", -1.0),
        ("stale_after", -0.5),
        ("stale_after", float("nan")),
        ("influence_distance", float("inf")),
        ("padding", float("nan")),
        ("heartbeat_rate", "fast"),
        ("publish_markers", 1),
        ("contacts_per_pair", -1),
        ("contacts_per_pair", 101),
    ],
)
def test_a_bad_value_is_rejected_with_a_reason(cell, name, value):
    before = cell.parameters.get(name)

    (result,) = cell.parameters.set(**{name: value})

    assert not result.successful
    assert name in result.reason
    assert cell.parameters.get(name) == before


def test_an_unknown_parameter_is_rejected_by_name(cell):
    (result,) = cell.parameters.set(hartbeat_rate=10.0)
    assert not result.successful
    assert "hartbeat_rate" in result.reason
    assert "hartbeat_rate" not in cell.parameters.names()


def test_an_atomic_change_is_made_whole_or_not_at_all(cell):
    result = cell.parameters.set_atomically(stale_after=2.0, heartbeat_rate=-1.0)
    assert not result.successful
    assert "heartbeat_rate" in result.reason
    assert cell.parameters.get("stale_after", "heartbeat_rate") == [QUICK["stale_after"], 20.0]
