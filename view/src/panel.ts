// Status, numbers and pairs as text.

import type { Geometry } from "./geometry";
import type { BodyName, Nearest, Update } from "./messages";
import { duration, length } from "./units";

/** Pairs that are listed. */
const LISTED = 12;

const NOTHING = "–";

const element = (id: string) => document.getElementById(id) as HTMLElement;

function write(id: string, text: string): void {
  const place = element(id);
  if (place.textContent !== text) place.textContent = text;
}

const pairName = (bodies: [BodyName, BodyName]) => bodies.map(([, name]) => name).join(" – ");

export function showGeometry({ robot, world }: Geometry): void {
  write("robot", robot?.text.name ?? NOTHING);
  write("links", `${robot?.text.links.length ?? NOTHING}`);
  const bodies = [robot?.text.links, world?.text.obstacles, world?.text.attached].flatMap((list) => list ?? []);
  const coarse = bodies.some((body) => body.shapes.some((shape) => shape.coarse));
  const held = world?.text.attached.length ?? 0;
  write(
    "obstacles",
    `${world?.text.obstacles.length ?? NOTHING}${held ? `, ${held} held` : ""}${coarse ? " (large ones in part)" : ""}`,
  );
}

/** Padding is part of every distance, but not of the picture. */
export function showPadding({ world }: Geometry): void {
  const padding = world?.text.largest_padding ?? 0;
  write("padding", padding > 0 ? `up to ${length(padding)} off each distance; not drawn` : "none");
}

export function showUpdate(update: Update): void {
  document.body.dataset.status = update.status;
  document.body.dataset.reasonCode = update.reason_code ?? "";
  document.title = `${update.status} – clearance`;
  write("status", update.status);
  write("reason", update.reason ?? "");
  showDistance(update);
  write("self-distance", distanceAndPair(update.self_nearest));
  write("world-distance", distanceAndPair(update.world_nearest));
  write("pairs-checked", `${update.pairs_checked ?? NOTHING}`);
  write("age", duration(update.age));
  write("compute-time", duration(update.compute_time));
  write("free-for", duration(update.free_for));
  showPairs(update);
  element("warnings").replaceChildren(...update.warnings.map((text) => item("li", text)));
}

function showDistance({ status, nearest, colliding }: Update): void {
  if (status === "UNKNOWN") {
    write("distance", NOTHING);
    write("nearest", "");
  } else if (nearest) {
    write("distance", length(nearest.distance));
    write("nearest", pairName(nearest.bodies));
  } else {
    write("distance", colliding?.length ? length(0) : "far");
    write("nearest", colliding?.length ? "" : "nothing within the distance limit");
  }
}

function distanceAndPair(nearest: Nearest | undefined): string {
  if (!nearest?.known) return NOTHING;
  return nearest.pair ? `${length(nearest.pair.distance)}, ${pairName(nearest.pair.bodies)}` : "far";
}

function showPairs(update: Update): void {
  const colliding = (update.colliding ?? []).map((bodies, i) => row(pairName(bodies), touch(update, i), "colliding"));
  const near = (update.near ?? []).filter((pair) => pair.distance > 0);
  const apart = near.map((pair) => row(pairName(pair.bodies), length(pair.distance), ""));
  element("pairs").replaceChildren(...[...colliding, ...apart].slice(0, LISTED));
  const touchingOfNear = (update.near?.length ?? 0) - near.length;
  const all = (update.colliding_count ?? 0) + (update.near_count ?? 0) - touchingOfNear;
  write("more-pairs", all > LISTED ? `and ${all - LISTED} more` : "");
}

/** The depth of a colliding pair: that of its first contact, if it is known. */
function touch({ contacts }: Update, pair: number): string {
  const depth = contacts?.find((contact) => contact.pair === pair)?.depth;
  return typeof depth === "number" ? `touches, ${length(depth)} deep` : "touches";
}

function row(name: string, value: string, kind: string): HTMLElement {
  const line = document.createElement("tr");
  line.className = kind;
  line.append(item("td", name), item("td", value));
  return line;
}

function item(tag: string, text: string): HTMLElement {
  const made = document.createElement(tag);
  made.textContent = text;
  return made;
}
