"""Collision and distance queries of robots, and proofs that motions are free.

    import clearance as cl

    robot = cl.Robot.from_urdf("robot.urdf", srdf="robot.srdf")
    world = cl.World()
    world.add_box("table", (1.0, 2.0, 0.05), (0.6, 0.0, -0.1))
    checker = cl.Checker(robot, world, group="arm", padding=0.01)
    q = robot.random(rng=0, size=1000)
    free = checker.is_free(checker.configuration(robot.group_states["home"]))

Units are metres, radians and seconds. All poses and points are in the frame of the robot's root link. Joint positions are
float64 arrays in the order of ``joint_names``. All objects but ``View``, ``CollisionMatrix``, ``SphereCover``,
``ShapeCover`` and ``MeshCover`` pickle. The package has no thread of its own until the first batch.
"""

from ._clearance import (
    Certificate,
    Checker,
    CollisionMatrix,
    Error,
    MeshCover,
    Robot,
    ShapeCover,
    SphereCover,
    View,
    World,
    __version__,
    verify,
)
from ._results import (
    Clearance,
    CollisionReport,
    Contact,
    Distances,
    EdgeReports,
    FreeState,
    InputWarning,
    LeastClearance,
    LinkMeshes,
    LinkPair,
    LinkShapes,
    LinkSpheres,
    MeasuredSpheres,
    MotionClearance,
    MotionReport,
    PairDistance,
    Plan,
    Reason,
    SimplifiedMesh,
    TrajectoryReport,
    Verdict,
    Verification,
)

__all__ = [
    "Certificate",
    "Checker",
    "Clearance",
    "CollisionMatrix",
    "CollisionReport",
    "Contact",
    "Distances",
    "EdgeReports",
    "Error",
    "FreeState",
    "InputWarning",
    "LeastClearance",
    "LinkMeshes",
    "LinkPair",
    "LinkShapes",
    "LinkSpheres",
    "MeasuredSpheres",
    "MeshCover",
    "MotionClearance",
    "MotionReport",
    "PairDistance",
    "Plan",
    "Reason",
    "Robot",
    "ShapeCover",
    "SimplifiedMesh",
    "SphereCover",
    "TrajectoryReport",
    "Verdict",
    "Verification",
    "View",
    "World",
    "__version__",
    "verify",
]
