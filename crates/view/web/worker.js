// Worker that prepares a mesh: welds vertices at the same position, finds the faces round each, sorts the faces
// along a space-filling curve, and makes a coarse version for a moving view. Also computes ambient occlusion.

import { bends, round } from "../../report/viewer/bends.js";

/** Number of faces, about, of the coarse version of a large mesh. */
const THIN = 40_000;

/** For each vertex the first one at the same position. */
function welded(positions) {
  const count = positions.length / 3, whole = new Uint32Array(positions.buffer, positions.byteOffset, positions.length);
  const size = 2 ** Math.ceil(Math.log2(2 * count + 2)), table = new Int32Array(size).fill(-1), first = new Uint32Array(count);
  for (let v = 0; v < count; v++) {
    // 0 and -0 are the same position but have different bits.
    const bits = (k) => positions[3 * v + k] === 0 ? 0 : whole[3 * v + k];
    let hash = Math.imul(bits(0), 0x9e3779b1) ^ Math.imul(bits(1), 0x85ebca6b) ^ Math.imul(bits(2), 0xc2b2ae35);
    hash = Math.imul(hash ^ hash >>> 15, 0x2c1b3c6d);
    let slot = (hash ^ hash >>> 13) & size - 1;
    for (;;) {
      const other = table[slot];
      if (other < 0) {
        table[slot] = v;
        first[v] = v;
        break;
      }
      if ([0, 1, 2].every((k) => positions[3 * other + k] === positions[3 * v + k])) {
        first[v] = other;
        break;
      }
      slot = slot + 1 & size - 1;
    }
  }
  return first;
}

/** Spreads ten bits, with two zeros between them, for a Morton code. */
function apart(x) {
  x = (x | x << 16) & 0x030000ff;
  x = (x | x << 8) & 0x0300f00f;
  x = (x | x << 4) & 0x030c30c3;
  return (x | x << 2) & 0x09249249;
}

/** The smallest coordinates, and the longest side of the bounding box. */
function bounds(positions) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < positions.length; i += 3) {
    for (let k = 0; k < 3; k++) {
      const x = positions[i + k];
      if (x < low[k]) low[k] = x;
      if (x > high[k]) high[k] = x;
    }
  }
  return { low, most: Math.max(high[0] - low[0], high[1] - low[1], high[2] - low[2]) || 1 };
}

/** Sorts the faces by the Morton codes of their centroids, so that successive faces are near each other. */
function together(positions, faces, { low, most }) {
  const count = faces.length / 3, scale = 1023.99 / most / 3;
  let codes = new Uint32Array(count), numbers = Uint32Array.from({ length: count }, (_, i) => i);
  for (let f = 0; f < count; f++) {
    const a = 3 * faces[3 * f], b = 3 * faces[3 * f + 1], c = 3 * faces[3 * f + 2];
    const at = (k) => apart((positions[a + k] + positions[b + k] + positions[c + k] - 3 * low[k]) * scale | 0);
    codes[f] = at(0) | at(1) << 1 | at(2) << 2;
  }
  for (let shift = 0; shift < 30; shift += 10) {
    const next = new Uint32Array(1025), sorted = new Uint32Array(count), moved = new Uint32Array(count);
    for (let i = 0; i < count; i++) next[(codes[i] >>> shift & 1023) + 1]++;
    for (let i = 0; i < 1024; i++) next[i + 1] += next[i];
    for (let i = 0; i < count; i++) {
      const to = next[codes[i] >>> shift & 1023]++;
      sorted[to] = codes[i];
      moved[to] = numbers[i];
    }
    [codes, numbers] = [sorted, moved];
  }
  const ordered = new Uint32Array(faces.length);
  for (let i = 0; i < count; i++) for (let k = 0; k < 3; k++) ordered[3 * i + k] = faces[3 * numbers[i] + k];
  return { faces: ordered, numbers };
}

/** A coarse version by vertex clustering, with one vertex for each cell of a grid; null for small meshes, or if it is not much smaller. */
function thinned(positions, faces, { low, most }) {
  const count = faces.length / 3;
  if (count < 2 * THIN) return null;
  for (let cells = 240; cells > 40; cells *= 0.75) {
    const thin = atCells(positions, faces, low, most / cells, Math.ceil(cells) + 1);
    if (thin.numbers.length < 1.5 * THIN) return thin;
  }
  return null;
}

function atCells(positions, faces, low, size, wide) {
  const stands = new Int32Array(wide ** 3).fill(-1), of = new Uint32Array(positions.length / 3);
  for (let v = 0; v < of.length; v++) {
    let cell = 0;
    for (let k = 0; k < 3; k++) cell = cell * wide + Math.min(wide - 1, (positions[3 * v + k] - low[k]) / size | 0);
    if (stands[cell] < 0) stands[cell] = v;
    of[v] = stands[cell];
  }
  const corners = [], numbers = [];
  for (let i = 0; i < faces.length; i += 3) {
    const a = of[faces[i]], b = of[faces[i + 1]], c = of[faces[i + 2]];
    if (a === b || b === c || c === a) continue;
    corners.push(a, b, c);
    numbers.push(i / 3);
  }
  return { faces: Uint32Array.from(corners), numbers: Uint32Array.from(numbers) };
}

/** Directions from which ambient light comes, for meshes of up to [MANY] faces, and for larger ones. */
const DIRECTIONS = [64, 32], MANY = 300_000;
/** Width and height of a depth map in pixels. */
const SIZE = 512;
/** Distance by which a point must lie behind the depth map to be in shadow, and is first moved along its normal; in pixels. */
const SLACK = 1.5;
/** Number of times that the light is averaged over neighbouring vertices, since depth maps have pixels. */
const SMOOTHINGS = 2;

/** Unit vectors that are spread evenly over the sphere (Fibonacci lattice), each with two more at right angles. */
function directions(count) {
  return Array.from({ length: count }, (_, i) => {
    const z = 1 - (2 * i + 1) / count, r = Math.sqrt(1 - z * z), turn = i * Math.PI * (3 - Math.sqrt(5));
    const to = [r * Math.cos(turn), r * Math.sin(turn), z], across = Math.abs(z) < 0.9 ? [-to[1], to[0], 0] : [0, -to[2], to[1]], length = Math.hypot(...across);
    const right = across.map((x) => x / length), up = [1, 2, 0].map((a, k) => to[a] * right[(k + 2) % 3] - to[(k + 2) % 3] * right[a]);
    return [right, up, to];
  });
}

/** Draws the faces into a depth map: for each pixel the largest third coordinate. `at` has the coordinates in pixels. */
function depthMap(at, faces, map) {
  map.fill(-Infinity);
  for (let i = 0; i < faces.length; i += 3) {
    const a = 3 * faces[i], b = 3 * faces[i + 1], c = 3 * faces[i + 2];
    const ax = at[a], ay = at[a + 1], az = at[a + 2], bx = at[b] - ax, by = at[b + 1] - ay, cx = at[c] - ax, cy = at[c + 1] - ay;
    const area = bx * cy - by * cx;
    if (area === 0) continue;
    const bz = (at[b + 2] - az) / area, cz = (at[c + 2] - az) / area, sign = Math.sign(area), most = Math.abs(area);
    const left = Math.ceil(ax + Math.min(0, bx, cx)), right = Math.floor(ax + Math.max(0, bx, cx));
    const top = Math.ceil(ay + Math.min(0, by, cy)), bottom = Math.floor(ay + Math.max(0, by, cy));
    for (let y = top; y <= bottom; y++) {
      for (let x = left; x <= right; x++) {
        const px = x - ax, py = y - ay, u = px * cy - py * cx, v = bx * py - by * px;
        if (u * sign < 0 || v * sign < 0 || (u + v) * sign > most) continue;
        const z = az + u * bz + v * cz;
        if (z > map[y * SIZE + x]) map[y * SIZE + x] = z;
      }
    }
  }
}

/** For each vertex the part of the ambient light that reaches it, from 0 to 255: seen from many directions by depth maps. */
function occlusion(positions, faces, normals) {
  const count = positions.length / 3, { low, most } = bounds(positions), open = new Float32Array(count), all = new Float32Array(count);
  // The bounding cube fits into the map in every direction.
  const scale = (SIZE - 4) / (most * Math.sqrt(3)), middle = low.map((x) => x + most / 2), at = new Float32Array(positions.length), map = new Float32Array(SIZE * SIZE);
  for (const axes of directions(DIRECTIONS[faces.length / 3 > MANY ? 1 : 0])) {
    const [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = axes;
    for (let i = 0; i < at.length; i += 3) {
      const x = (positions[i] - middle[0]) * scale, y = (positions[i + 1] - middle[1]) * scale, z = (positions[i + 2] - middle[2]) * scale;
      at[i] = ax * x + ay * y + az * z + SIZE / 2;
      at[i + 1] = bx * x + by * y + bz * z + SIZE / 2;
      at[i + 2] = cx * x + cy * y + cz * z;
    }
    depthMap(at, faces, map);
    for (let v = 0, i = 0; v < count; v++, i += 3) {
      const x = normals[i], y = normals[i + 1], z = normals[i + 2], facing = cx * x + cy * y + cz * z;
      if (!(facing > 0)) continue;
      const column = Math.round(at[i] + SLACK * (ax * x + ay * y + az * z)), row = Math.round(at[i + 1] + SLACK * (bx * x + by * y + bz * z));
      all[v] += facing;
      if (at[i + 2] + SLACK * facing + SLACK >= map[row * SIZE + column]) open[v] += facing;
    }
  }
  let light = open.map((x, v) => all[v] ? x / all[v] : 1);
  for (let i = 0; i < SMOOTHINGS; i++) light = averaged(light, faces);
  return Uint8Array.from(light, (x) => Math.round(255 * x));
}

/** The mean of the values at the corners of the faces round each vertex. */
function averaged(values, faces) {
  const sums = values.slice(), counts = new Float32Array(values.length).fill(1);
  for (let i = 0; i < faces.length; i += 3) {
    const sum = values[faces[i]] + values[faces[i + 1]] + values[faces[i + 2]];
    for (let k = 0; k < 3; k++) {
      sums[faces[i + k]] += sum;
      counts[faces[i + k]] += 3;
    }
  }
  return sums.map((x, v) => x / counts[v]);
}

onmessage = ({ data: { positions, faces, normals } }) => {
  if (normals) {
    const light = occlusion(positions, faces, normals);
    postMessage(light, [light.buffer]);
    return;
  }
  const weld = welded(positions);
  const corners = Uint32Array.from(faces, (v) => weld[v]);
  const { starts, list } = round(corners, weld.length), bent = bends(positions, corners, { starts, list }, weld.some((first, v) => first !== v));
  const size = bounds(positions), thin = thinned(positions, faces, size), order = together(positions, faces, size);
  const given = [corners, starts, list, order.faces, order.numbers, ...thin ? [thin.faces, thin.numbers] : [], ...bent ? [bent] : []];
  postMessage({ corners, starts, list, thin, order, bends: bent }, given.map((array) => array.buffer));
};
