// The picture: bodies, colours, and lines between nearest points.

import {
  AmbientLight,
  AxesHelper,
  Box3,
  CanvasTexture,
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
  PerspectiveCamera,
  Points,
  PointsMaterial,
  Scene,
  Sprite,
  SpriteMaterial,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";

import type { Geometry } from "./geometry";
import type { Body, BodyName, Document, Pair, Robot, Update } from "./messages";
import { draw, place, pointsMaterial } from "./shapes";

const COLOURS = { link: 0xb9c0c9, attached: 0xd79a3c, obstacle: 0x4f81bd };
const COLLIDING = 0xd92d20;
const WITNESS = 0xe5a50a;
const GROUND = { light: 0xf4f5f7, dark: 0x16181c };

/** Distances that are written beside their lines, where they do not hide each other. */
const LABELS = 4;

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
  private readonly camera = new PerspectiveCamera(45, 1, 0.01, 500);
  private readonly renderer: WebGLRenderer;
  private readonly controls: OrbitControls;
  private readonly bodies = new Group();
  private readonly findings = new Group();
  private readonly figures = new Map<string, Figure>();
  private robot: Document<Robot> | null = null;
  /** Figures of links, in the order of the robot's document. */
  private links: Figure[] = [];
  private model = 0;
  private shown = 0;
  /** Of the robot (m). */
  private size = 1;
  private due = true;
  private readonly gl: WebGL2RenderingContext;
  /** Signalled when the last picture is finished. */
  private drawing: WebGLSync | null = null;
  /** Whether the robot is in it. */
  private drawsRobot = false;

  /** `drawn` is called when there is a picture of the robot. */
  constructor(
    private readonly canvas: HTMLCanvasElement,
    private readonly drawn: () => void,
  ) {
    this.renderer = new WebGLRenderer({ canvas, antialias: true });
    this.gl = this.renderer.getContext() as WebGL2RenderingContext;
    this.camera.up.set(0, 0, 1);
    this.camera.position.set(2, -2, 1.5);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => (this.due = true));
    this.addSurroundings();
    this.scene.add(this.bodies, this.findings);
    new ResizeObserver(() => this.resize()).observe(canvas);
    const frame = () => {
      requestAnimationFrame(frame);
      if (!this.due || this.isDrawing()) return;
      this.due = false;
      this.renderer.render(this.scene, this.camera);
      this.drawing = this.gl.fenceSync(this.gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
      this.drawsRobot = this.shown !== 0;
    };
    frame();
  }

  /** Whether the last picture is not finished: without a graphics card that takes longer than the next one needs to come. */
  private isDrawing(): boolean {
    const { gl, drawing } = this;
    if (!drawing) return false;
    if (!gl.isContextLost() && gl.getSyncParameter(drawing, gl.SYNC_STATUS) !== gl.SIGNALED) return true;
    gl.deleteSync(drawing);
    this.drawing = null;
    if (this.drawsRobot) this.drawn();
    return false;
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
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
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
    if (!isSameRobot) this.links = robot.text.links.map(add("link", robot));
    this.robot = robot;
    this.links.forEach((link, i) => {
      const scale = world.text.link_scales[i] ?? 1;
      link.shapes.forEach((shape) => shape.scale.setScalar(scale));
    });
    world.text.obstacles.forEach(add("obstacle", world));
    world.text.attached.forEach(add("attached", world));
    this.model = robot.text.model;
    this.due = true;
  }

  /** Shows what is known now. */
  show(update: Update): void {
    const poses = update.model === this.model ? update.poses : null;
    if (poses) this.links.forEach((link, i) => poses[i] && place(link.group, poses[i]));
    const colliding = new Set((update.colliding ?? []).flat().map(key));
    for (const [name, figure] of this.figures) colour(figure, colliding.has(name), poses !== null);
    this.showFindings(update);
    if (poses && this.shown !== this.model) {
      this.shown = this.model;
      this.frameRobot();
    }
    this.due = true;
  }

  private showFindings(update: Update): void {
    dispose(this.findings);
    const pairs = [...(update.near ?? [])];
    const { nearest } = update;
    if (nearest && !pairs.some((pair) => isSame(pair, nearest))) pairs.unshift(nearest);
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
      if (written.length === LABELS || written.some((other) => other.distanceTo(middle) < 0.12 * this.size)) continue;
      written.push(middle);
      this.findings.add(label(pair.distance, middle));
    }
  }

  /** Looks at the robot from a distance at which all of it is seen. */
  private frameRobot(): void {
    this.bodies.updateMatrixWorld(true);
    const box = new Box3();
    for (const { group } of this.links) box.expandByObject(group);
    if (box.isEmpty()) return;
    const size = (this.size = box.getSize(new Vector3()).length());
    box.getCenter(this.controls.target);
    this.camera.position.copy(this.controls.target).add(new Vector3(0.9, -1.1, 0.7).multiplyScalar(Math.max(size, 0.1)));
    this.camera.near = size / 200;
    this.camera.far = Math.max(size * 50, 50);
    this.camera.updateProjectionMatrix();
    this.controls.update();
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

/** Where the robot is unknown, it is only hinted at. */
function colour({ materials, kind }: Figure, colliding: boolean, placed: boolean): void {
  const solid = kind === "obstacle" ? 0.55 : placed ? 1 : 0.25;
  for (const material of materials) {
    material.color.setHex(colliding ? COLLIDING : COLOURS[kind]);
    material.opacity = colliding ? Math.max(solid, 0.7) : solid;
    material.transparent = material.opacity < 1;
    material.depthWrite = !material.transparent;
  }
}

/** The distance of a pair, beside the middle of its line. */
function label(distance: number, middle: Vector3): Sprite {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [256, 64];
  const pen = canvas.getContext("2d");
  if (pen) {
    pen.font = "600 40px system-ui, sans-serif";
    pen.textAlign = "center";
    pen.textBaseline = "middle";
    pen.lineWidth = 8;
    pen.strokeStyle = "#000a";
    pen.fillStyle = "#ffd75e";
    const text = `${(1000 * distance).toFixed(1)} mm`;
    pen.strokeText(text, 128, 32);
    pen.fillText(text, 128, 32);
  }
  const texture = new CanvasTexture(canvas);
  const sprite = new Sprite(new SpriteMaterial({ map: texture, depthTest: false, sizeAttenuation: false }));
  sprite.position.copy(middle);
  sprite.center.set(0.5, -0.2);
  sprite.scale.set(0.14, 0.035, 1);
  sprite.renderOrder = 2;
  return sprite;
}

/** Empties a group and frees what the graphics card holds of it. */
function dispose(group: Group): void {
  group.traverse((object) => {
    if (object instanceof InstancedMesh) object.dispose();
    if (object instanceof Mesh || object instanceof Points || object instanceof Sprite) {
      object.geometry.dispose();
      for (const material of [object.material as Material | Material[]].flat()) {
        if (material instanceof SpriteMaterial) material.map?.dispose();
        material.dispose();
      }
    }
  });
  group.clear();
}
