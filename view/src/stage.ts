// The picture: bodies, colours, lines between nearest points, and contacts.

import {
  AmbientLight,
  AxesHelper,
  Box3,
  Color,
  DirectionalLight,
  DoubleSide,
  GridHelper,
  Group,
  HemisphereLight,
  InstancedMesh,
  type Material,
  Mesh,
  MeshStandardMaterial,
  type Object3D,
  Points,
  PointsMaterial,
  Scene,
  Vector3,
  WebGLRenderer,
} from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";
import { CSS2DObject, CSS2DRenderer } from "three/addons/renderers/CSS2DRenderer.js";

import { FittingCamera } from "./camera";
import { drawContacts } from "./contacts";
import type { Geometry } from "./geometry";
import type { Body, BodyName, Document, Pair, Pose, Robot, Update } from "./messages";
import { draw, place, pointsMaterial } from "./shapes";
import { length } from "./units";

const COLOURS = { link: 0xb9c0c9, attached: 0xd79a3c, obstacle: 0x4f81bd };
const COLLIDING = 0xd92d20;
/** A robot whose pose is not known. */
const GREYED = 0x9aa0a8;
const WITNESS = 0xe5a50a;
const GROUND = { light: 0xf4f5f7, dark: 0x16181c };

/** Distances that are written beside their lines, where they do not hide each other. */
const LABELS = 4;

/** How far beyond the robot's reach obstacles are kept in the picture, as a share of its size. */
const AROUND = 0.25;

/** Padding (m) that is too small to be mentioned. */
const NO_PADDING = 5e-5;

/** Which pose of the robot is drawn: none, the default one, the last one that was known, or that of the update. */
export type DrawnPose = "none" | "default" | "last" | "current";

type Kind = BodyName[0];

/** A body in the picture, with what colours it. */
interface Figure {
  group: Group;
  shapes: Object3D[];
  materials: (MeshStandardMaterial | PointsMaterial)[];
  kind: Kind;
}

export class Stage {
  private readonly scene = new Scene();
  private readonly renderer: WebGLRenderer;
  private readonly labels: CSS2DRenderer;
  private readonly view: FittingCamera;
  private readonly bodies = new Group();
  private readonly findings = new Group();
  private readonly figures = new Map<string, Figure>();
  private robot: Document<Robot> | null = null;
  /** Figures of links, in the order of the robot's document. */
  private links: Figure[] = [];
  private model = 0;
  private world = 0;
  private drawnPose: DrawnPose = "none";
  private due = true;
  private readonly gl: WebGL2RenderingContext;
  /** Signalled when the last picture is finished. */
  private drawing: WebGLSync | null = null;

  constructor(private readonly canvas: HTMLCanvasElement) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true });
    this.gl = this.renderer.getContext() as WebGL2RenderingContext;
    this.labels = new CSS2DRenderer({ element: document.getElementById("labels") as HTMLElement });
    this.view = new FittingCamera(canvas, () => (this.due = true));
    this.addSurroundings();
    this.scene.add(this.bodies, this.findings);
    new ResizeObserver(() => this.resize()).observe(canvas);
  }

  /** Draws a picture if there is something new to see. */
  draw(): void {
    if (!this.due || this.isDrawing()) return;
    this.due = false;
    this.renderer.render(this.scene, this.view.camera);
    this.labels.render(this.scene, this.view.camera);
    this.drawing = this.gl.fenceSync(this.gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
  }

  /** Whether the last picture is not finished: without a graphics card that takes longer than the next one needs to come. */
  isDrawing(): boolean {
    const { gl, drawing } = this;
    if (!drawing) return false;
    if (!gl.isContextLost() && gl.getSyncParameter(drawing, gl.SYNC_STATUS) !== gl.SIGNALED) return true;
    gl.deleteSync(drawing);
    this.drawing = null;
    return false;
  }

  /** Turns the camera to all that there is to see. */
  fit(): void {
    this.view.refit();
  }

  private addSurroundings(): void {
    const dark = window.matchMedia("(prefers-color-scheme: dark)");
    const paint = () => {
      this.scene.background = new Color(dark.matches ? GROUND.dark : GROUND.light);
      this.due = true;
    };
    dark.addEventListener("change", paint);
    paint();
    const sun = new DirectionalLight(0xffffff, 1.8);
    sun.position.set(2, -3, 4);
    const grid = new GridHelper(10, 20, 0x8a929c, 0xc3c9d1).rotateX(Math.PI / 2);
    grid.material.transparent = true;
    grid.material.opacity = 0.35;
    this.scene.add(new HemisphereLight(0xffffff, 0x8890a0, 1.4), new AmbientLight(0xffffff, 0.3), sun, grid, new AxesHelper(0.2));
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(window.devicePixelRatio);
    this.renderer.setSize(width, height, false);
    this.labels.setSize(width, height);
    this.view.resize(width / height);
    this.due = true;
  }

  /** Draws other geometry; links of the same robot stay. */
  set({ robot, world }: Geometry): void {
    if (!robot || !world) return;
    const isSameRobot = robot === this.robot;
    for (const [name, { group, kind }] of this.figures) {
      if (isSameRobot && kind === "link") continue;
      dispose(group);
      group.removeFromParent();
      this.figures.delete(name);
    }
    const add = (kind: Kind, numbers: Document<unknown>) => (body: Body) => {
      const figure = drawBody(kind, body, numbers);
      this.figures.set(key([kind, body.name]), figure);
      const carrier = body.link === undefined ? undefined : this.figures.get(key(["link", body.link]));
      (carrier?.group ?? this.bodies).add(figure.group);
      return figure;
    };
    if (!isSameRobot) {
      this.links = robot.text.links.map(add("link", robot));
      this.place(robot.text.default_poses);
      this.drawnPose = "default";
    }
    this.robot = robot;
    this.links.forEach((link, i) => {
      const scale = world.text.link_scales[i] ?? 1;
      link.shapes.forEach((shape) => shape.scale.setScalar(scale));
    });
    world.text.obstacles.forEach(add("obstacle", world));
    world.text.attached.forEach(add("attached", world));
    this.model = robot.text.model;
    this.world = world.text.world;
    this.view.watch(this.extent(robot.text), !isSameRobot);
    this.due = true;
  }

  private place(poses: Pose[]): void {
    this.links.forEach((link, i) => poses[i] && place(link.group, poses[i]));
  }

  /** All that the robot can reach, where it is now, and what stands near it. */
  private extent({ reach }: Robot): Box3 {
    this.bodies.updateMatrixWorld(true);
    const box = new Box3();
    for (const { group } of this.links) box.expandByObject(group);
    if (reach) reach.forEach((corner) => box.expandByPoint(new Vector3(...corner)));
    if (box.isEmpty()) return box;
    const near = box.clone().expandByScalar(AROUND * box.getSize(new Vector3()).length());
    for (const { group, kind } of this.figures.values()) {
      if (kind === "obstacle") box.union(new Box3().expandByObject(group).intersect(near));
    }
    return box;
  }

  /** Shows what is known now; tells which pose of the robot that is. */
  show(update: Update): DrawnPose {
    const poses = update.model === this.model ? update.poses : null;
    if (poses) {
      this.place(poses);
      this.view.follow(this.links.map(({ group }) => group.position));
    }
    if (poses) this.drawnPose = "current";
    else if (this.drawnPose === "current") this.drawnPose = "last";
    const colliding = new Set((update.colliding ?? []).flat().map(key));
    for (const [name, figure] of this.figures) colour(figure, colliding.has(name), poses !== null);
    this.showFindings(update);
    this.due = true;
    return this.drawnPose;
  }

  /** Whether the geometry in the picture is that of an update. */
  isAbout({ model, world }: Update): boolean {
    return model === 0 || (model === this.model && world === this.world);
  }

  private showFindings(update: Update): void {
    dispose(this.findings);
    if (update.contacts?.length) this.findings.add(...drawContacts(update.contacts));
    const pairs = [...(update.near ?? [])];
    for (const nearest of [update.world_nearest?.pair, update.self_nearest?.pair, update.nearest]) {
      if (nearest && !pairs.some((pair) => isSame(pair, nearest))) pairs.unshift(nearest);
    }
    const apart = pairs.filter((pair) => pair.distance > 0);
    if (apart.length === 0) return;
    const geometry = new LineSegmentsGeometry().setPositions(apart.flatMap((pair) => pair.witness_points.flat()));
    // transparent things are drawn last: lines lie over obstacles
    const look = new LineMaterial({ color: WITNESS, linewidth: 3, depthTest: false, transparent: true });
    const lines = new LineSegments2(geometry, look);
    lines.renderOrder = 1;
    this.findings.add(lines);
    const written: Vector3[] = [];
    for (const pair of apart) {
      const middle = new Vector3(...pair.witness_points[0]).add(new Vector3(...pair.witness_points[1])).multiplyScalar(0.5);
      if (written.length === LABELS || written.some((other) => other.distanceTo(middle) < 0.06 * this.view.size)) continue;
      written.push(middle);
      this.findings.add(label(pair, middle));
    }
  }
}

const key = ([kind, name]: BodyName) => `${kind}/${name}`;

const isSame = (a: Pair, b: Pair) => a.bodies.map(key).join() === b.bodies.map(key).join();

function drawBody(kind: Kind, body: Body, numbers: Document<unknown>): Figure {
  const group = new Group();
  const surface = new MeshStandardMaterial({ roughness: 0.65, metalness: 0.05, flatShading: true, side: DoubleSide });
  const materials: Figure["materials"] = [surface];
  for (const shape of body.shapes) {
    const points = pointsMaterial(shape, COLOURS[kind]);
    if (points) materials.push(points);
    group.add(draw(shape, numbers, points ?? surface));
  }
  const figure = { group, shapes: [...group.children], materials, kind };
  colour(figure, false, true);
  return figure;
}

/** A robot whose pose is not known is greyed. */
function colour({ materials, kind }: Figure, colliding: boolean, placed: boolean): void {
  const greyed = kind !== "obstacle" && !placed;
  const solid = kind === "obstacle" ? 0.55 : greyed ? 0.45 : 1;
  for (const material of materials) {
    material.color.setHex(colliding ? COLLIDING : greyed ? GREYED : COLOURS[kind]);
    material.opacity = colliding ? Math.max(solid, 0.7) : solid;
    material.transparent = material.opacity < 1;
    material.depthWrite = !material.transparent;
  }
}

/** The distance of a pair, above the middle of its line. The line is longer by the padding, which is not drawn. */
function label({ distance, witness_points: [a, b] }: Pair, middle: Vector3): CSS2DObject {
  const text = document.createElement("div");
  text.className = "label";
  text.textContent = length(distance);
  const gap = new Vector3(...a).distanceTo(new Vector3(...b));
  if (gap - distance > NO_PADDING) {
    const note = document.createElement("small");
    note.textContent = `${length(gap)} less ${length(gap - distance)} padding`;
    text.append(note);
  }
  const object = new CSS2DObject(text);
  object.position.copy(middle);
  object.center.set(0.5, 1.3);
  return object;
}

/** Empties a group and frees what the graphics card holds of it. */
function dispose(group: Group): void {
  group.traverse((object) => {
    if (object instanceof InstancedMesh) object.dispose();
    if (object instanceof CSS2DObject) object.element.remove();
    if (object instanceof Mesh || object instanceof Points) {
      object.geometry.dispose();
      for (const material of [object.material as Material | Material[]].flat()) material.dispose();
    }
  });
  group.clear();
}
