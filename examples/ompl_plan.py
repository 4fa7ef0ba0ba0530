#!/usr/bin/env python3
"""Plans with OMPL around the demo world, with edges that are proven free:  ompl_plan.py [--planner RRTConnect] [--time 5]

Needs the Python packages clearance and ompl. Prints the path, and checks its certificate with independent code.
Exit code 0: a path was found; 1: none was found.
"""

import argparse
import sys
from pathlib import Path

from ompl import geometric as og
from ompl import util as ou

import clearance as cl
from clearance import ompl as proven

ROOT = Path(__file__).resolve().parents[1]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--planner", default="RRTConnect", help="class of ompl.geometric")
    parser.add_argument("--time", type=float, default=5.0, help="limit of the search (s)")
    arguments = parser.parse_args()
    ou.setLogLevel(ou.LOG_WARN)

    robot = cl.Robot.from_urdf(ROOT / "urdf/demo_arm/demo_arm.urdf", srdf=ROOT / "urdf/demo_arm/demo_arm.srdf")
    checker = cl.Checker(robot, cl.World.from_file(ROOT / "config/demo_world.yaml", robot), group="arm")

    space = proven.state_space(checker)
    setup = og.SimpleSetup(space)
    information = setup.getSpaceInformation()
    setup.setStateValidityChecker(proven.StateValidityChecker(information, checker))
    information.setMotionValidator(proven.MotionValidator(information, checker))
    setup.setPlanner(getattr(og, arguments.planner)(information))

    joints = proven.JointMapping(space, checker)
    ends = [{"joint1": side, "joint2": 0.5, "joint4": -1.6, "joint6": 1.8} for side in (-0.8, 0.8)]
    setup.setStartAndGoalStates(*(joints.state(checker.configuration(end)) for end in ends))
    setup.solve(arguments.time)
    if not setup.haveExactSolutionPath():
        print(f"{arguments.planner} found no path in {arguments.time} s")
        return 1
    setup.simplifySolution()

    path = setup.getSolutionPath()
    states = proven.positions(path, information, checker)
    certificate = proven.certificate(path, information, checker)
    verified = cl.verify(certificate, robot, checker.world, trajectory=(None, checker.expand(states)))
    for state in states:
        print(" ".join(f"{position:7.4f}" for position in state))
    print(f"{len(states)} states, every edge proven free; certificate verified: {verified.valid}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
