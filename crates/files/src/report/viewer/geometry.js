// Unpacks the arrays of a page into meshes, computes normals and per-face flags, and has geometric queries on faces and rims.

import { cross, dot, minus, plus } from "./camera.js";

/** Reads integer arrays one after another: length, stride, then zigzag-encoded differences, all in bytes of seven bits. */
function arrayReader(bytes) {
  let at = 0;
  const whole = () => {
    let value = 0, scale = 1, byte;
    do {
      byte = bytes[at++];
      value += (byte & 127) * scale;
      scale *= 128;
    } while (byte > 127);
    return value;
  };
  return () => {
    const length = whole(), stride = whole(), values = new Int32Array(length);
    for (let i = 0; i < length; i++) {
      const zigzag = whole();
      const difference = zigzag % 2 ? -(zigzag + 1) / 2 : zigzag / 2;
      values[i] = difference + (i >= stride ? values[i - stride] : 0);
    }
    return values;
  };
}

async function inflated(text) {
  const packed = atob(text.trim());
  const bytes = new Uint8Array(packed.length);
  for (let i = 0; i < packed.length; i++) bytes[i] = packed.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** Unit normals from their octahedral encoding. */
function normalsOf(folded) {
  const normals = new Float32Array(folded.length / 2 * 3);
  for (let i = 0; i < folded.length / 2; i++) {
    let x = folded[2 * i] / 1023, y = folded[2 * i + 1] / 1023;
    const z = 1 - Math.abs(x) - Math.abs(y);
    if (z < 0) {
      const fold = x;
      x = (1 - Math.abs(y)) * (fold < 0 ? -1 : 1);
      y = (1 - Math.abs(fold)) * (y < 0 ? -1 : 1);
    }
    const length = Math.hypot(x, y, z) || 1;
    normals.set([x / length, y / length, z / length], 3 * i);
  }
  return normals;
}

/** Unpacks the meshes. Positions are relative to the scene's centre. Faces: first those in both meshes, then new ones, then removed ones. */
export async function unpack(text, header) {
  const next = arrayReader(await inflated(text));
  const placed = (steps) => Float32Array.from(steps, (s) => s * header.step - header.radius);
  const positions = placed(next()), normals = normalsOf(next());
  const curvatures = next(), distances = next(), errors = next(), faces = next(), regions = next();
  const points = placed(next()), lengths = next();
  const rims = [];
  let start = 0;
  for (const length of lengths) {
    rims.push(points.subarray(3 * start, 3 * (start + length)));
    start += length;
  }
  const count = faces.length / 3;
  const parts = {
    kept: [0, header.kept],
    new: [header.kept, header.kept + header.new],
    gone: [header.kept + header.new, count],
  };
  const mesh = { ...header, positions, normals, curvatures, distances, errors, faces, regions, rims, parts };
  return { ...mesh, facts: factsOf(mesh) };
}

/**
 * Bits of a face's flags: region (lowest 16), origin (0 both meshes, 1 new, 2 removed or of an earlier step), masked, marked, image (8 bits),
 * in a stroke of the smoothing brush, hidden.
 */
export const ORIGIN = 16, MASKED = 1 << 18, MARKED = 1 << 19, IMAGE = 20, STROKE = 1 << 28, HIDDEN = 1 << 29;

/** The flags of the faces of a mesh whose new faces are contiguous. */
function factsOf({ faces, kept, regions, parts }) {
  const facts = new Uint32Array(faces.length / 3);
  facts.fill(1 << ORIGIN, ...parts.new);
  facts.fill(2 << ORIGIN, ...parts.gone);
  for (let i = 0; i < parts.new[1] - kept; i++) facts[kept + i] |= regions[i];
  return facts;
}

/** Vertex normals, weighted by the areas of the faces and not normalised. */
export function vertexNormals(positions, faces) {
  const normals = new Float32Array(positions.length);
  for (let i = 0; i < faces.length; i += 3) {
    const a = 3 * faces[i], b = 3 * faces[i + 1], c = 3 * faces[i + 2];
    const ex = positions[b] - positions[a], ey = positions[b + 1] - positions[a + 1], ez = positions[b + 2] - positions[a + 2];
    const gx = positions[c] - positions[a], gy = positions[c + 1] - positions[a + 1], gz = positions[c + 2] - positions[a + 2];
    const x = ey * gz - ez * gy, y = ez * gx - ex * gz, z = ex * gy - ey * gx;
    normals[a] += x; normals[a + 1] += y; normals[a + 2] += z;
    normals[b] += x; normals[b + 1] += y; normals[b + 2] += z;
    normals[c] += x; normals[c + 1] += y; normals[c + 2] += z;
  }
  return normals;
}

/** The edges of rims for drawing: seven numbers each, for both ends and the number of the colour; and where each rim starts. */
export function rimBuffer(rims, kinds) {
  const starts = [0];
  for (const rim of rims) starts.push(starts[starts.length - 1] + rim.length / 3);
  const values = new Float32Array(7 * starts[rims.length]);
  rims.forEach((rim, r) => {
    const n = rim.length / 3;
    for (let i = 0; i < n; i++) {
      const j = (i + 1) % n, at = 7 * (starts[r] + i);
      values.set(rim.subarray(3 * i, 3 * i + 3), at);
      values.set(rim.subarray(3 * j, 3 * j + 3), at + 3);
      values[at + 6] = kinds[r];
    }
  });
  return { values, starts };
}

/** The corners of a face. */
export function cornersOf({ positions, faces }, face) {
  return [0, 1, 2].map((k) => {
    const v = 3 * faces[3 * face + k];
    return [positions[v], positions[v + 1], positions[v + 2]];
  });
}

/** The distance along a ray to the plane of a face, clamped to the depth range of the face's corners. */
export function alongRay(mesh, face, origin, direction) {
  const [a, b, c] = cornersOf(mesh, face), n = cross(minus(b, a), minus(c, a));
  const ends = [a, b, c].map((p) => dot(minus(p, origin), direction)), slope = dot(n, direction);
  const t = slope ? dot(n, minus(a, origin)) / slope : ends[0];
  return Math.min(Math.max(t, Math.min(...ends)), Math.max(...ends));
}

/** Sum of the area vectors of a region's new faces, and sum of their lengths; both are twice the areas. */
export function facing(mesh, region) {
  let sum = [0, 0, 0], area = 0;
  const p = (v) => [mesh.positions[3 * v], mesh.positions[3 * v + 1], mesh.positions[3 * v + 2]];
  for (let i = 0; i < mesh.new; i++) {
    if (mesh.regions[i] !== region) continue;
    const f = 3 * (mesh.kept + i), a = p(mesh.faces[f]);
    const n = cross(minus(p(mesh.faces[f + 1]), a), minus(p(mesh.faces[f + 2]), a));
    sum = plus(sum, n);
    area += Math.hypot(...n);
  }
  return { sum, area };
}

/** The direction that a rim faces: twice its area vector. */
export function rimFacing(rim) {
  let sum = [0, 0, 0];
  const n = rim.length / 3, p = (i) => rim.subarray(3 * (i % n), 3 * (i % n) + 3);
  for (let i = 0; i < n; i++) sum = plus(sum, cross(minus(p(i), p(0)), minus(p(i + 1), p(0))));
  return sum;
}
