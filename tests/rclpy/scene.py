"""Test helper: builds messages of `moveit_msgs` from a few words: objects, shapes and scenes. Metres, radians."""

from math import cos, sin, sqrt

from geometry_msgs.msg import Point, Pose
from moveit_msgs.msg import (
    AllowedCollisionEntry,
    AllowedCollisionMatrix,
    AttachedCollisionObject,
    CollisionObject,
    LinkPadding,
    LinkScale,
    ObjectColor,
    PlanningScene,
    PlanningSceneWorld,
)
from shape_msgs.msg import Mesh, MeshTriangle, Plane, SolidPrimitive


def pose(x=0.0, y=0.0, z=0.0, axis=(0, 0, 1), angle=0.0):
    """A place, and a turn about an axis."""
    half = angle / 2
    scale = sin(half) / sqrt(sum(number * number for number in axis))
    message = Pose()
    message.position.x, message.position.y, message.position.z = float(x), float(y), float(z)
    message.orientation.x, message.orientation.y, message.orientation.z = (scale * number for number in axis)
    message.orientation.w = cos(half)
    return message


def xyz(vector):
    return vector.x, vector.y, vector.z


def _primitive(kind, *dimensions):
    return SolidPrimitive(type=kind, dimensions=[float(dimension) for dimension in dimensions])


def box(x, y, z):
    return _primitive(SolidPrimitive.BOX, x, y, z)


def sphere(radius):
    return _primitive(SolidPrimitive.SPHERE, radius)


def cylinder(height, radius):
    return _primitive(SolidPrimitive.CYLINDER, height, radius)


def cone(height, radius):
    """Its axis is z, its apex up; the origin is half way up."""
    return _primitive(SolidPrimitive.CONE, height, radius)


def plane(a, b, c, d):
    """ax + by + cz + d = 0"""
    return Plane(coef=[float(a), float(b), float(c), float(d)])


def mesh(vertices, triangles):
    message = Mesh()
    message.vertices = [Point(x=float(x), y=float(y), z=float(z)) for x, y, z in vertices]
    message.triangles = [MeshTriangle(vertex_indices=triangle) for triangle in triangles]
    return message


def fine_mesh(count):
    """A strip of so many triangles, a metre long."""
    vertices = [[i / count, 0.01 * (i % 2), 0.0] for i in range(count + 2)]
    return mesh(vertices, [[i, i + 1, i + 2] for i in range(count)])


def cube_mesh(side):
    """A cube of twelve triangles, seen from outside."""
    vertices = [((i & 1) - 0.5, (i >> 1 & 1) - 0.5, (i >> 2 & 1) - 0.5) for i in range(8)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    triangles = [triangle for a, b, c, d in faces for triangle in ((a, b, c), (a, c, d))]
    return mesh([[side * number for number in vertex] for vertex in vertices], triangles)


def obstacle(name, *shapes, at=None, frame="base", operation=CollisionObject.ADD, subframes=None):
    """A collision object. A shape is a message, or a pair of one and its pose on the object; without it there is none."""
    message = CollisionObject(id=name, operation=operation)
    message.header.frame_id = frame
    message.pose = at or pose()
    for shape in shapes:
        _add_shape(message, *(shape if isinstance(shape, tuple) else (shape, None)))
    message.subframe_names = list(subframes or {})
    message.subframe_poses = list((subframes or {}).values())
    return message


def _add_shape(message, shape, place):
    shapes, poses = {
        SolidPrimitive: (message.primitives, message.primitive_poses),
        Mesh: (message.meshes, message.mesh_poses),
        Plane: (message.planes, message.plane_poses),
    }[type(shape)]
    shapes.append(shape)
    if place:
        poses.append(place)


def ball(name, x, y=0.0, z=0.0, radius=0.1, **where):
    return obstacle(name, sphere(radius), at=pose(x, y, z), **where)


def removal(name=""):
    """Without a name: of everything."""
    return obstacle(name, operation=CollisionObject.REMOVE)


def move(name, at, frame="base"):
    return obstacle(name, at=at, frame=frame, operation=CollisionObject.MOVE)


def attached(link, part, touch_links=()):
    """`part` is a collision object, or the name of one of the world."""
    part = obstacle(part, frame=link) if isinstance(part, str) else part
    return AttachedCollisionObject(link_name=link, object=part, touch_links=list(touch_links))


def detachment(name, link=""):
    return AttachedCollisionObject(link_name=link, object=removal(name))


def matrix(*pairs, names=(), defaults=None):
    """Pairs that may touch; all other pairs of these names, and of `names`, may not."""
    names = sorted({name for pair in pairs for name in pair} | set(names))
    message = AllowedCollisionMatrix(entry_names=names)
    message.entry_values = [
        AllowedCollisionEntry(enabled=[(a, b) in pairs or (b, a) in pairs for b in names]) for a in names
    ]
    message.default_entry_names = list(defaults or {})
    message.default_entry_values = list((defaults or {}).values())
    return message


def full(*obstacles, attached=(), allowed=None):
    """A scene that replaces the one before."""
    message = PlanningScene(is_diff=False, world=PlanningSceneWorld(collision_objects=list(obstacles)))
    message.robot_state.attached_collision_objects = list(attached)
    message.allowed_collision_matrix = allowed or AllowedCollisionMatrix()
    return message


def diff(*obstacles, attached=(), allowed=None, padding=None, scale=None, colors=()):
    """A scene that changes the one before."""
    message = full(*obstacles, attached=attached, allowed=allowed)
    message.is_diff = message.robot_state.is_diff = True
    message.link_padding = [LinkPadding(link_name=link, padding=value) for link, value in (padding or {}).items()]
    message.link_scale = [LinkScale(link_name=link, scale=value) for link, value in (scale or {}).items()]
    message.object_colors = [ObjectColor(id=name) for name in colors]
    return message
