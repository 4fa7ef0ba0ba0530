"""Test fixtures: robot, world and checkers that the tests share."""

from pathlib import Path

import numpy as np
import pytest

import clearance as cl

ROOT = Path(__file__).resolve().parents[2]
URDF = ROOT / "urdf/demo_arm/demo_arm.urdf"
SRDF = ROOT / "urdf/demo_arm/demo_arm.srdf"
WORLD = ROOT / "config/demo_world.yaml"

# a link of each kind of joint, and one that mimics another
ALL_KINDS = """<robot name="kinds">
  <link name="root"/><link name="turn"/><link name="slide"/><link name="finger"/><link name="fly"/><link name="roam"/>
  <joint name="t" type="continuous"><parent link="root"/><child link="turn"/><axis xyz="0 0 1"/></joint>
  <joint name="s" type="prismatic"><parent link="root"/><child link="slide"/><axis xyz="1 0 0"/>
    <limit lower="1" upper="3" velocity="1" effort="1"/></joint>
  <joint name="m" type="prismatic"><parent link="slide"/><child link="finger"/><axis xyz="0 1 0"/>
    <limit lower="-9" upper="9" velocity="1" effort="1"/><mimic joint="s" multiplier="-2" offset="0.5"/></joint>
  <joint name="f" type="floating"><parent link="root"/><child link="fly"/></joint>
  <joint name="p" type="planar"><parent link="root"/><child link="roam"/><axis xyz="0 0 1"/></joint>
</robot>"""


@pytest.fixture(scope="session")
def robot():
    return cl.Robot.from_urdf(URDF, srdf=str(SRDF))


@pytest.fixture(scope="session")
def world(robot):
    return cl.World.from_file(WORLD, robot)


@pytest.fixture(scope="session")
def checker(robot, world):
    """All joints."""
    return cl.Checker(robot, world, padding=0.01)


@pytest.fixture(scope="session")
def arm(robot, world):
    """The joints of the arm."""
    return cl.Checker(robot, world, group="arm", fixed={"finger_joint1": 0.02})


@pytest.fixture(scope="session")
def home(robot, arm):
    return arm.configuration(robot.group_states["home"])


@pytest.fixture(scope="session")
def states(robot):
    return robot.random(np.random.default_rng(7), 400)
