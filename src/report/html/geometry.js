// The arrays of the page, and what the graphics card gets of them.

/** Reads arrays of whole numbers one after the other: length, stride, then differences in bytes of seven bits. */
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

/** Normals from the octahedron they were unfolded to. */
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

/** The meshes: positions relative to the middle of the scene; faces of both, then those after, then those before. */
async function unpack(text, header) {
  const next = arrayReader(await inflated(text));
  const placed = (steps) => Float32Array.from(steps, (s) => s * header.step - header.radius);
  const positions = placed(next()), normals = normalsOf(next());
  const curvatures = next(), distances = next(), faces = next(), regions = next();
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
  return { ...header, positions, normals, curvatures, distances, faces, regions, rims, parts };
}

const CORNER_BYTES = 24;

/** For each corner of each face: position, normal, region, curvature and distance. */
function cornerBuffer(mesh) {
  const buffer = new ArrayBuffer(mesh.faces.length * CORNER_BYTES);
  const floats = new Float32Array(buffer), shorts = new Int16Array(buffer), bytes = new Int8Array(buffer);
  for (let i = 0; i < mesh.faces.length; i++) {
    const v = mesh.faces[i];
    for (let k = 0; k < 3; k++) {
      floats[6 * i + k] = mesh.positions[3 * v + k];
      shorts[12 * i + 6 + k] = mesh.normals[3 * v + k] * 32767;
    }
    const face = (i / 3 | 0) - mesh.kept;
    shorts[12 * i + 9] = face >= 0 && face < mesh.new ? mesh.regions[face] : 0;
    bytes[24 * i + 20] = mesh.curvatures[v];
    bytes[24 * i + 21] = mesh.distances[v];
  }
  return buffer;
}

/** The sides of a rim: both ends, and whether its hole is still open. */
function rimBuffer(rims, open) {
  const values = [], starts = [0];
  rims.forEach((rim, r) => {
    const n = rim.length / 3;
    for (let i = 0; i < n; i++) {
      const j = (i + 1) % n;
      values.push(rim[3 * i], rim[3 * i + 1], rim[3 * i + 2], rim[3 * j], rim[3 * j + 1], rim[3 * j + 2], open[r] ? 1 : 0);
    }
    starts.push(values.length / 7);
  });
  return { values: new Float32Array(values), starts };
}

/** The nearest face of some parts that a ray meets: its number and how far along. */
function meet(mesh, parts, origin, direction) {
  const p = mesh.positions;
  let best = null;
  for (const [first, end] of parts) {
    for (let f = first; f < end; f++) {
      const a = 3 * mesh.faces[3 * f], b = 3 * mesh.faces[3 * f + 1], c = 3 * mesh.faces[3 * f + 2];
      const e = [p[b] - p[a], p[b + 1] - p[a + 1], p[b + 2] - p[a + 2]];
      const g = [p[c] - p[a], p[c + 1] - p[a + 1], p[c + 2] - p[a + 2]];
      const h = cross(direction, g), area = dot(e, h);
      if (area === 0) continue;
      const s = [origin[0] - p[a], origin[1] - p[a + 1], origin[2] - p[a + 2]];
      const u = dot(s, h) / area;
      if (u < 0 || u > 1) continue;
      const q = cross(s, e), v = dot(direction, q) / area;
      if (v < 0 || u + v > 1) continue;
      const t = dot(g, q) / area;
      if (t > 0 && (!best || t < best.t)) best = { face: f, t };
    }
  }
  return best;
}

/** Sum of the normals of a region's patch times their areas, and the sum of the areas. */
function facing(mesh, region) {
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

/** The direction that a rim faces. */
function rimFacing(rim) {
  let sum = [0, 0, 0];
  const n = rim.length / 3, p = (i) => rim.subarray(3 * (i % n), 3 * (i % n) + 3);
  for (let i = 0; i < n; i++) sum = plus(sum, cross(minus(p(i), p(0)), minus(p(i + 1), p(0))));
  return sum;
}
