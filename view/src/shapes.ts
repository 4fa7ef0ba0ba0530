// Shapes as three.js draws them, in the frame of their body; z is up, as in ROS.

import {
  BoxGeometry,
  BufferAttribute,
  BufferGeometry,
  CapsuleGeometry,
  ConeGeometry,
  CylinderGeometry,
  InstancedMesh,
  type Material,
  Matrix4,
  Mesh,
  type Object3D,
  PlaneGeometry,
  Points,
  PointsMaterial,
  Quaternion,
  SphereGeometry,
  Vector3,
} from "three";

import type { Document, Pose, Shape } from "./messages";

/** How much of a plane is shown (m). */
const PLANE_SHOWN = 6;

/** Least size of a point (m): what has none is not seen. */
const LEAST_POINT = 0.004;

const Z = new Vector3(0, 0, 1);

export function place(object: Object3D, [x, y, z, qx, qy, qz, qw]: Pose): void {
  object.position.set(x, y, z);
  object.quaternion.set(qx, qy, qz, qw);
}

export function draw(shape: Shape, numbers: Document<unknown>, material: Material): Object3D {
  const object = form(shape, numbers, material);
  place(object, shape.pose);
  return object;
}

function form(shape: Shape, numbers: Document<unknown>, material: Material): Object3D {
  switch (shape.kind) {
    case "box":
      return new Mesh(new BoxGeometry(...shape.size), material);
    case "sphere":
      return new Mesh(new SphereGeometry(shape.radius, 32, 20), material);
    // these three stand along y
    case "cylinder":
      return upright(new CylinderGeometry(shape.radius, shape.radius, shape.length, 32), material);
    case "cone":
      return upright(new ConeGeometry(shape.radius, shape.length, 32), material);
    case "capsule":
      return upright(new CapsuleGeometry(shape.radius, shape.length, 10, 32), material);
    case "plane": {
      const normal = new Vector3(...shape.normal);
      const geometry = new PlaneGeometry(PLANE_SHOWN, PLANE_SHOWN)
        .applyQuaternion(new Quaternion().setFromUnitVectors(Z, normal))
        .translate(...normal.multiplyScalar(shape.offset).toArray());
      return new Mesh(geometry, material);
    }
    case "mesh": {
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new BufferAttribute(numbers.floats(shape.vertices), 3));
      geometry.setIndex(new BufferAttribute(numbers.integers(shape.triangles), 1));
      return new Mesh(geometry, material);
    }
    case "points": {
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new BufferAttribute(numbers.floats(shape.centres), 3));
      return new Points(geometry, material);
    }
    case "cubes":
      return cubes(numbers.floats(shape.cubes), material);
  }
}

function upright(geometry: BufferGeometry, material: Material): Object3D {
  return new Mesh(geometry.rotateX(Math.PI / 2), material);
}

function cubes(numbers: Float32Array, material: Material): Object3D {
  const mesh = new InstancedMesh(new BoxGeometry(2, 2, 2), material, numbers.length / 4);
  const matrix = new Matrix4();
  for (let i = 0; i < mesh.count; i++) {
    const [x = 0, y = 0, z = 0, half = 0] = numbers.subarray(4 * i, 4 * i + 4);
    mesh.setMatrixAt(i, matrix.makeScale(half, half, half).setPosition(x, y, z));
  }
  return mesh;
}

/** What points are drawn with in the place of a material of surfaces. */
export function pointsMaterial(shape: Shape, color: number): PointsMaterial | null {
  if (shape.kind !== "points") return null;
  return new PointsMaterial({ color, size: Math.max(2 * shape.radius, LEAST_POINT) });
}
