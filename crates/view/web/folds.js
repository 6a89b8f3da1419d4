// Lines over the surface: sharp edges, between two faces whose dihedral angle deviates from flat by more than a bound, and the rims of patches.

import { ORIGIN } from "../../report/viewer/geometry.js";
import { measuredFaces } from "./faces.js";

/** Smallest angle between the normals at an edge that is drawn, in degrees. */
const BEND = 30;
/** Number of faces above which no sharp edges are drawn: finding them would block the page for seconds. */
const MOST_FACES = 3_000_000;

/** Number of new faces above which the rims of patches are not drawn. */
const MOST_NEW = 300_000;

/** The edges between the new faces of a step and other faces as lines: the coordinates of both ends and a one each. */
export function patchLines({ positions: p, faces, facts }) {
  const edges = new Map(), count = p.length / 3, isNew = (f) => (facts[f] >>> ORIGIN & 3) === 1;
  let all = 0;
  for (let f = 0; f < facts.length; f++) all += isNew(f);
  if (all > MOST_NEW) return new Float32Array();
  for (let f = 0; f < facts.length; f++) {
    if (!isNew(f)) continue;
    for (let k = 0; k < 3; k++) {
      const a = faces[3 * f + k], b = faces[3 * f + (k + 1) % 3], edge = Math.min(a, b) * count + Math.max(a, b);
      if (edges.has(edge)) edges.delete(edge);
      else edges.set(edge, [3 * a, 3 * b]);
    }
  }
  const lines = [];
  for (const [a, b] of edges.values()) lines.push(p[a], p[a + 1], p[a + 2], p[b], p[b + 1], p[b + 2], 1);
  return Float32Array.from(lines);
}

/** The sharp edges of a mesh as lines: the coordinates of both ends and a zero each. */
export function foldLines({ mesh, corners, starts, list }) {
  const { positions: p, faces } = mesh, count = faces.length / 3, lines = [], least = Math.cos(BEND * Math.PI / 180);
  if (count > MOST_FACES) return new Float32Array();
  const { normals } = measuredFaces(mesh);
  for (let f = 0; f < count; f++) {
    for (let k = 0; k < 3; k++) {
      const a = corners[3 * f + k], b = corners[3 * f + (k + 1) % 3];
      for (let i = starts[a]; i < starts[a + 1]; i++) {
        const g = list[i], c = 3 * g;
        if (g <= f || corners[c] !== b && corners[c + 1] !== b && corners[c + 2] !== b) continue;
        const bend = normals[3 * f] * normals[c] + normals[3 * f + 1] * normals[c + 1] + normals[3 * f + 2] * normals[c + 2];
        if (bend < least) lines.push(p[3 * a], p[3 * a + 1], p[3 * a + 2], p[3 * b], p[3 * b + 1], p[3 * b + 2], 0);
      }
    }
  }
  return Float32Array.from(lines);
}
