// Contacts in the picture: a dot at each point, and a line along its normal.

import { BufferGeometry, Float32BufferAttribute, type Object3D, Points, PointsMaterial } from "three";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { LineSegments2 } from "three/addons/lines/LineSegments2.js";
import { LineSegmentsGeometry } from "three/addons/lines/LineSegmentsGeometry.js";

import type { Contact } from "./messages";

const CONTACT = 0xd91abf;

/** Size of a dot (pixels). */
const DOT = 7;

/** Least length of a line (m), so that it can be seen. */
const SHORTEST_LINE = 0.03;

/** Dots and lines, which lie over all bodies: contacts are inside them. */
export function drawContacts(contacts: Contact[]): Object3D[] {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(contacts.flatMap(({ position }) => position), 3));
  const dots = new PointsMaterial({ color: CONTACT, size: DOT, sizeAttenuation: false, depthTest: false, transparent: true });
  const drawn: Object3D[] = [new Points(geometry, dots)];
  const ends = contacts.flatMap(({ position, normal, depth }) => {
    if (!normal) return [];
    const length = Math.max(depth ?? 0, SHORTEST_LINE);
    return [...position, ...position.map((x, i) => x + length * (normal[i] ?? 0))];
  });
  if (ends.length > 0) {
    const look = new LineMaterial({ color: CONTACT, linewidth: 2, depthTest: false, transparent: true });
    drawn.push(new LineSegments2(new LineSegmentsGeometry().setPositions(ends), look));
  }
  for (const object of drawn) object.renderOrder = 2;
  return drawn;
}
