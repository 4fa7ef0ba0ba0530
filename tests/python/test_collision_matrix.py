"""Tests of collision matrices: decisions, SRDF text, certificates, errors."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import clearance as cl
from conftest import SRDF, URDF

# two plates that turn above each other: `far` never reaches `base`, `near` sometimes does
ROBOT = """<robot name="plates">
  <link name="base"><collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
  <link name="near"><collision><origin xyz="0.2 0 0"/><geometry><box size="0.1 0.1 0.1"/></geometry></collision></link>
  <link name="far"><collision><origin xyz="0 0 1"/><geometry><sphere radius="0.1"/></geometry></collision></link>
  <link name="collar"><collision><geometry><sphere radius="0.06"/></geometry></collision></link>
  <joint name="slide" type="prismatic"><parent link="base"/><child link="near"/><axis xyz="1 0 0"/>
    <limit lower="-0.3" upper="0.3" velocity="1" effort="1"/></joint>
  <joint name="turn" type="continuous"><parent link="base"/><child link="far"/><axis xyz="0 0 1"/></joint>
  <joint name="spin" type="continuous"><parent link="base"/><child link="collar"/><axis xyz="0 0 1"/></joint>
</robot>"""


@pytest.fixture(scope="module")
def plates():
    return cl.Robot.from_urdf(ROBOT)


@pytest.fixture(scope="module")
def matrix(plates):
    return plates.collision_matrix()


@pytest.fixture(scope="module")
def arm_matrix(robot):
    return robot.collision_matrix(num_threads=2)


def pair_of(matrix, a, b):
    return next(pair for pair in matrix.pairs if set(pair.links) == {a, b})


def test_decisions(plates, matrix):
    assert len(matrix.pairs) == 6 and matrix.joint_names == plates.joint_names
    never = pair_of(matrix, "base", "far")
    assert never.decision == "never" and never.least_distance == pytest.approx(0.85, abs=1e-6)
    assert never.colliding is None and never.free is None
    always = pair_of(matrix, "base", "collar")
    assert always.decision == "always" and always.contact_share == 1 and always.adjacent
    sometimes = pair_of(matrix, "base", "near")
    assert sometimes.decision == "sometimes"
    checker = cl.Checker(plates, checked_collisions=[("base", "near")])
    assert ("base", "near") in [tuple(p) for p in checker.check(sometimes.colliding).pairs]
    assert ("base", "near") not in [tuple(p) for p in checker.check(sometimes.free).pairs]
    assert "never" in repr(matrix)


def test_no_proven_pair_collides_in_random_states(robot, arm_matrix):
    matrix = arm_matrix
    never = [pair.links for pair in matrix.pairs if pair.decision == "never"]
    assert never
    # a fixed joint between them: one rigid body, which is never checked against itself
    fixed = [("link7", "hand")]
    with pytest.raises(cl.Error, match="'link7' and 'hand' cannot be checked: fixed joints"):
        cl.Checker(robot, checked_collisions=fixed)
    movable = [pair.links for pair in matrix.pairs if pair.links not in fixed]
    checker = cl.Checker(robot, checked_collisions=movable)
    colliding = {frozenset(p) for q in robot.random(3, 3000) for p in checker.check(q).pairs}
    assert not colliding & {frozenset(links) for links in never}
    assert len(movable) == len(matrix.pairs) - 1
    assert colliding <= {frozenset(p.links) for p in matrix.pairs if p.decision in ("sometimes", "always")}


def test_the_same_for_any_number_of_threads(robot, arm_matrix):
    assert robot.collision_matrix(num_threads=1).certificate() == arm_matrix.certificate()


def test_srdf(plates, matrix):
    text = matrix.srdf(allow=[("near", "base")], allow_adjacent=True)
    again = cl.Robot.from_urdf(ROBOT, srdf=text)
    lines = [line.strip() for line in text.splitlines() if "disable_collisions" in line]
    reasons = {frozenset(line.split('"')[1:4:2]): line.split('"')[5] for line in lines}
    assert reasons[frozenset(("base", "near"))] == "User"
    assert reasons[frozenset(("base", "far"))] == "Never"
    assert reasons[frozenset(("base", "collar"))] == "Adjacent"
    # what is named already gets no second entry
    assert again.collision_matrix().srdf(allow_adjacent=True) == text
    with pytest.raises(cl.Error, match="no link 'nobody'"):
        matrix.srdf(allow=[("base", "nobody")])
    with pytest.raises(cl.Error, match="'base' is given twice"):
        matrix.srdf(allow=[("base", "base")])


def test_the_text_of_the_srdf_stays(arm_matrix):
    original = Path(SRDF).read_text()
    text = arm_matrix.srdf()
    assert all(line in text for line in original.splitlines())


def test_the_command_verifies_the_certificate(tmp_path, arm_matrix):
    file = tmp_path / "matrix.json"
    text = arm_matrix.certificate()
    model = ["--urdf", str(URDF), "--srdf", str(SRDF)]
    command = [str(Path(sys.executable).with_name("clearance")), "verify", *model, str(file)]
    file.write_text(text)
    assert subprocess.run(command, timeout=120, capture_output=True).returncode == 0
    altered = json.loads(text)
    kept = altered["pairs"] if "pairs" in altered else altered["proofs"]
    kept[0]["link1"], kept[0]["link2"] = kept[0]["link2"], kept[0]["link1"] + "x"
    file.write_text(json.dumps(altered))
    assert subprocess.run(command, timeout=120, capture_output=True).returncode != 0


def test_padding_counts(plates):
    padded = plates.collision_matrix(padding=1.0, pad_self=True)
    assert pair_of(padded, "base", "far").decision != "never"


def test_limits(robot):
    for limits in ({"timeout": 0}, {"max_boxes": 0}):
        matrix = robot.collision_matrix(**limits)
        undecided = [pair for pair in matrix.pairs if pair.decision == "undecided"]
        assert undecided
        for pair in undecided:
            assert pair.nearest is None or pair.nearest.shape == (len(robot.joint_names),)
            assert pair.nearest is None or np.isfinite(pair.nearest).all()


@pytest.mark.parametrize(
    "arguments, kind, text",
    [
        ({"allowed_collisions": []}, TypeError, "allowed_collisions"),
        ({"paddin": 1}, TypeError, "paddin"),
        ({"link_padding": {"nobody": 0.1}}, ValueError, "nobody"),
        ({"padding": float("nan")}, ValueError, "padding"),
        ({"max_boxes": -1}, ValueError, "max_boxes"),
        ({"num_threads": 0}, ValueError, "num_threads"),
        ({"timeout": -1}, ValueError, "timeout"),
    ],
)
def test_errors(robot, arguments, kind, text):
    with pytest.raises(kind, match=text):
        robot.collision_matrix(**arguments)


def test_no_pairs():
    with pytest.raises(cl.Error, match="no two links"):
        cl.Robot.from_urdf('<robot name="none"><link name="a"/></robot>').collision_matrix()
