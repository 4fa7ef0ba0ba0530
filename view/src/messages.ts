// What the server sends: /updates (crates/view/src/update_message.rs), /robot and /world (geometry_documents.rs there).

export type Status = "FREE" | "COLLIDING" | "UNKNOWN";

/** The kind of a body and its name: of one kind no two have the same. */
export type BodyName = ["link" | "attached" | "obstacle", string];

export type Point = [number, number, number];

/** Position (m), and quaternion in the order x, y, z, w. */
export type Pose = [number, number, number, number, number, number, number];

export interface Pair {
  bodies: [BodyName, BodyName];
  distance: number;
  witness_points: [Point, Point];
}

/** The nearest pair of one kind: not known, or none within the distance limit, or this one. */
export interface Nearest {
  known: boolean;
  pair: Pair | null;
}

/** A contact of a colliding pair. */
export interface Contact {
  /** Index of the pair in `colliding`. */
  pair: number;
  position: Point;
  /** Unit vector towards the second body, where it is known. */
  normal: Point | null;
  depth: number | null;
}

/** Lengths in metres, times in seconds. */
export interface Update {
  status: Status;
  reason: string | null;
  reason_code: string | null;
  warnings: string[];
  model: number;
  world: number;
  age: number | null;
  poses: Pose[] | null;
  /** Positions of the sliders (rad, m); absent where a node moves the robot. */
  sliders?: number[];
  // absent when nothing is known
  compute_time?: number;
  pairs_checked?: number;
  free_for?: number | null;
  nearest?: Pair | null;
  self_nearest?: Nearest;
  world_nearest?: Nearest;
  near?: Pair[];
  near_count?: number;
  colliding?: [BodyName, BodyName][];
  colliding_count?: number;
  /** In the order of `colliding`, the deepest of a pair first; absent where no contacts are computed. */
  contacts?: Contact[];
}

/** Numbers behind the text: the first and how many. */
export type Span = [number, number];

export type Shape = { pose: Pose; coarse: boolean } & (
  | { kind: "box"; size: Point }
  | { kind: "sphere"; radius: number }
  | { kind: "cylinder" | "cone" | "capsule"; radius: number; length: number }
  | { kind: "plane"; normal: Point; offset: number }
  | { kind: "mesh"; vertices: Span; triangles: Span }
  | { kind: "points"; radius: number; centres: Span }
  | { kind: "cubes"; cubes: Span }
);

export interface Body {
  name: string;
  link?: string;
  shapes: Shape[];
}

export interface Robot {
  model: number;
  name: string;
  frame: string;
  links: Body[];
  /** By link, while no joint state is known. */
  default_poses: Pose[];
  /** Corners of a box around what the robot can reach. */
  reach: [Point, Point] | null;
}

export interface World {
  model: number;
  world: number;
  obstacles: Body[];
  attached: Body[];
  link_scales: number[];
  largest_padding: number;
}

/** A text with numbers behind it (crates/view/src/document.rs). */
export class Document<T> {
  readonly text: T;
  private readonly numbers: ArrayBuffer;

  constructor(bytes: ArrayBuffer) {
    const length = new DataView(bytes).getUint32(0, true);
    this.text = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length))) as T;
    this.numbers = bytes.slice(4 + length);
  }

  floats([first, count]: Span): Float32Array<ArrayBuffer> {
    return new Float32Array(this.numbers, 4 * first, count);
  }

  integers([first, count]: Span): Uint32Array<ArrayBuffer> {
    return new Uint32Array(this.numbers, 4 * first, count);
  }
}
