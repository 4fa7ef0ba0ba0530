"""Finds the robots and mesh pairs to benchmark: the shared ones or, without them, those of this repository."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree


@dataclass(frozen=True)
class RobotSource:
    name: str
    urdf: Path
    srdf: Path | None
    package_root: Path
    random_states: Path | None = None
    free_states: Path | None = None
    # robots for which python-fcl is asked, too
    small: bool = False


@dataclass(frozen=True)
class MeshPairSource:
    name: str
    a: Path
    b: Path


@dataclass(frozen=True)
class Subjects:
    robots: list[RobotSource]
    mesh_pairs: list[MeshPairSource]
    note: str


def find(root: Path) -> Subjects:
    shared = root.parent / "shared"
    if (shared / "robots/robots.json").is_file() and (shared / "truth").is_dir():
        return Subjects(_truth(shared / "truth") + _published(shared / "robots"), _shared_pairs(shared), "")
    note = "The shared robots are not here: measured are the robots of `urdf/`, for which nothing is required."
    return Subjects(_bundled(root / "urdf"), _bundled_pairs(root / "urdf/demo_arm/meshes"), note)


def _truth(folder: Path) -> list[RobotSource]:
    return [
        RobotSource(
            f"truth/{name}",
            folder / name / "robot.urdf",
            folder / name / "robot.srdf",
            folder / name,
            folder / name / "states.json",
            folder / name / "states_free.json",
            small=True,
        )
        for name in ("ur5", "panda")
    ]


def _published(folder: Path) -> list[RobotSource]:
    entries = json.loads((folder / "robots.json").read_text())
    return [
        RobotSource(e["name"], folder / e["urdf"], folder / e["srdf"], folder / e["package_root"]) for e in entries
    ]


def _bundled(folder: Path) -> list[RobotSource]:
    def robot(name: str) -> RobotSource:
        srdf = folder / name / f"{name}.srdf"
        return RobotSource(name, folder / name / f"{name}.urdf", srdf if srdf.exists() else None, folder, small=True)

    return [robot(name) for name in ("two_link", "demo_arm", "dual_arm")]


def _shared_pairs(shared: Path) -> list[MeshPairSource]:
    """Pairs from 200 to 21 thousand triangles: hulls, arms, CAD shells of a humanoid, a concave scene."""
    robots = shared / "robots"
    ur5, panda = (shared / "truth" / name / "meshes" for name in ("ur5", "panda"))
    iiwa = robots / "kuka_lbr_iiwa_support/meshes/lbr_iiwa_14_r820/collision"
    pr2 = robots / "moveit_resources_pr2_description/urdf/meshes"
    torso = robots / "baxter_description/meshes/torso/base_link_collision.DAE"
    g1 = robots / "unitree_g1/meshes"
    scene = shared / "truth/common/shelf_scene.stl"
    hand, knee = panda / "collision_hand.stl", g1 / "left_knee_link.STL"
    return [
        MeshPairSource("Panda link5 – hand", panda / "collision_link5.stl", hand),
        MeshPairSource("iiwa base – link 6", iiwa / "base_link.stl", iiwa / "link_6.stl"),
        MeshPairSource("UR5 upper arm – forearm", *(ur5 / f"ur5_collision_{n}.stl" for n in ("upperarm", "forearm"))),
        MeshPairSource("PR2 upper arm – forearm", pr2 / "upper_arm_v0/upper_arm.stl", pr2 / "forearm_v0/forearm.stl"),
        MeshPairSource("Baxter torso – PR2 finger", torso, pr2 / "gripper_v0/l_finger.stl"),
        MeshPairSource("G1 wrist roll – elbow", g1 / "left_wrist_roll_link.STL", g1 / "right_elbow_link.STL"),
        MeshPairSource("G1 knee – head", knee, g1 / "head_link.STL"),
        MeshPairSource("shelf scene – Panda hand", scene, hand),
        MeshPairSource("shelf scene – G1 knee", scene, knee),
    ]


def _bundled_pairs(meshes: Path) -> list[MeshPairSource]:
    names = [("base", "hand"), ("link2", "link5"), ("link6", "finger")]
    return [MeshPairSource(f"{a} – {b}", meshes / f"{a}.stl", meshes / f"{b}.stl") for a, b in names]


def with_absolute_meshes(source: RobotSource, out: Path) -> None:
    """The URDF with mesh names that are absolute paths: readers look for relative ones in different places."""
    tree = ElementTree.parse(source.urdf)
    for mesh in tree.iter("mesh"):
        name = mesh.get("filename", "").strip()
        package = "package://"
        path = source.package_root / name[len(package) :] if name.startswith(package) else source.urdf.parent / name
        mesh.set("filename", str(path.resolve()))
    tree.write(out)
