"""Robots of the node benchmarks, from this repository and the shared folder: files, root link and joint ranges."""

import json
from dataclasses import dataclass
from math import pi
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parents[2]
SHARED = ROOT.parent / "shared/robots"


class NotHere(Exception):
    """A robot that this machine has not; the message says where it was looked for."""


@dataclass(frozen=True)
class Robot:
    name: str
    root_link: str
    arguments: tuple  # of the node
    joints: dict  # least and greatest position of each joint that is free [rad, m]


def robot(name):
    own = ROOT / "urdf" / name
    if own.is_dir():
        return _described(name, own / f"{name}.urdf", own / f"{name}.srdf", own)
    listing = SHARED / "robots.json"
    entries = json.loads(listing.read_text()) if listing.is_file() else []
    entry = next((entry for entry in entries if entry["name"] == name), None)
    if not entry:
        raise NotHere(f"no robot {name}: {listing} is not there, or does not list it")
    return _described(name, SHARED / entry["urdf"], SHARED / entry["srdf"], SHARED / entry["package_root"])


def _described(name, urdf, srdf, packages):
    arguments = ("--urdf", urdf, "--srdf", srdf, "--package-path", packages)
    tree = ElementTree.parse(urdf).getroot()
    return Robot(name, _root_link(tree), arguments, _free_joints(tree))


def _root_link(tree):
    children = {joint.find("child").get("link") for joint in tree.findall("joint")}
    return next(link.get("name") for link in tree.findall("link") if link.get("name") not in children)


def _free_joints(tree):
    return {
        joint.get("name"): _range(joint)
        for joint in tree.findall("joint")
        if joint.get("type") in ("revolute", "continuous", "prismatic") and joint.find("mimic") is None
    }


def _range(joint):
    limit = joint.find("limit")
    if joint.get("type") == "continuous" or limit is None:
        return -pi / 2, pi / 2
    return float(limit.get("lower", 0)), float(limit.get("upper", 0))
