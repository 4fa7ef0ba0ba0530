// The camera: shows a whole box until the user moves it, and again on request.

import { Box3, PerspectiveCamera, Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

/** From the middle of the box to the camera, at first. */
const DIRECTION = new Vector3(0.9, -1.1, 0.7).normalize();

/** Free space around the box, as a factor. */
const MARGIN = 1.06;

export class FittingCamera {
  readonly camera = new PerspectiveCamera(45, 1, 0.01, 500);
  private readonly controls: OrbitControls;
  private readonly box = new Box3();
  private isMovedByUser = false;

  /** `moved` is called whenever the picture has to be drawn anew. */
  constructor(
    canvas: HTMLCanvasElement,
    private readonly moved: () => void,
  ) {
    this.camera.up.set(0, 0, 1);
    this.camera.position.copy(DIRECTION).multiplyScalar(3);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", moved);
    this.controls.addEventListener("start", () => (this.isMovedByUser = true));
  }

  /** The length of the box's diagonal (m). */
  get size(): number {
    return this.box.isEmpty() ? 1 : this.box.getSize(new Vector3()).length();
  }

  resize(aspect: number): void {
    this.camera.aspect = aspect;
    this.camera.updateProjectionMatrix();
    if (!this.isMovedByUser) this.fit();
  }

  /** What has to be in the picture. A camera that the user has moved stays, unless it `isNew`. */
  watch(box: Box3, isNew: boolean): void {
    if (box.isEmpty()) return;
    this.box.copy(box);
    if (isNew) this.isMovedByUser = false;
    if (!this.isMovedByUser) this.fit();
  }

  /** Widens what has to be in the picture by points that have left it. */
  follow(points: Vector3[]): void {
    if (this.box.isEmpty() || points.every((point) => this.box.containsPoint(point))) return;
    points.forEach((point) => this.box.expandByPoint(point));
    if (!this.isMovedByUser) this.fit();
  }

  /** Turns back to the whole box, from the side from which it is seen now. */
  refit(): void {
    this.isMovedByUser = false;
    this.fit();
  }

  private fit(): void {
    if (this.box.isEmpty()) return;
    const middle = this.box.getCenter(new Vector3());
    const towards = this.camera.position.clone().sub(this.controls.target);
    if (towards.lengthSq() === 0) towards.copy(DIRECTION);
    towards.normalize();
    const distance = MARGIN * this.leastDistance(towards, middle);
    const { size } = this;
    this.controls.target.copy(middle);
    this.camera.position.copy(middle).addScaledVector(towards, distance);
    this.camera.near = distance / 200;
    this.camera.far = distance + 50 * Math.max(size, 1);
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.moved();
  }

  /** The least distance from the middle at which all corners are in the picture. */
  private leastDistance(towards: Vector3, middle: Vector3): number {
    const right = new Vector3().crossVectors(this.camera.up, towards).normalize();
    const above = new Vector3().crossVectors(towards, right);
    const tall = Math.tan((this.camera.fov * Math.PI) / 360);
    const wide = tall * this.camera.aspect;
    const distances = corners(this.box).map((corner) => {
      const from = corner.sub(middle);
      const aside = Math.max(Math.abs(from.dot(right)) / wide, Math.abs(from.dot(above)) / tall);
      return from.dot(towards) + aside;
    });
    return Math.max(...distances, 0.1);
  }
}

function corners({ min, max }: Box3): Vector3[] {
  const ends = [min, max];
  return ends.flatMap(({ x }) => ends.flatMap(({ y }) => ends.map(({ z }) => new Vector3(x, y, z))));
}
