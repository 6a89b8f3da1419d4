// A normal for each corner of the faces, so that sharp edges look sharp.

/** The faces round each vertex, without those in the range `left`: entries starts[v] to starts[v + 1] of the list for vertex v. */
export function round(corners, count, left = [0, 0]) {
  const starts = new Uint32Array(count + 1), isLeft = (i) => i >= 3 * left[0] && i < 3 * left[1];
  for (let i = 0; i < corners.length; i++) if (!isLeft(i)) starts[corners[i] + 1]++;
  for (let v = 0; v < count; v++) starts[v + 1] += starts[v];
  const next = starts.slice(), list = new Uint32Array(starts[count]);
  for (let i = 0; i < corners.length; i++) if (!isLeft(i)) list[next[corners[i]]++] = i / 3 | 0;
  return { starts, list };
}

/** Cosine of the angle between two faces from which on the edge or corner between them is drawn sharp (40°). */
const SHARP = 0.766;

/** A unit vector in octahedral encoding, with 16 bits for each of the two coordinates, as the shaders read it. */
export function folded(x, y, z) {
  const size = Math.abs(x) + Math.abs(y) + Math.abs(z) || 1;
  let u = x / size, v = y / size;
  if (z < 0) [u, v] = [(1 - Math.abs(v)) * (u < 0 ? -1 : 1), (1 - Math.abs(u)) * (v < 0 ? -1 : 1)];
  return Math.round((u + 1) * 32767.5) | Math.round((v + 1) * 32767.5) << 16;
}

/**
 * A normal for each corner: of the faces round its vertex that are at less than the sharp angle to its face, weighted by their areas. Null if
 * no edge is sharp and no vertices coincide: then one normal for each vertex is enough.
 */
export function bends(positions, corners, { starts, list }, isWelded) {
  const normals = new Float32Array(corners.length), sizes = new Float32Array(corners.length / 3), found = new Uint32Array(corners.length);
  for (let i = 0; i < corners.length; i += 3) {
    const a = 3 * corners[i], b = 3 * corners[i + 1], c = 3 * corners[i + 2];
    const ex = positions[b] - positions[a], ey = positions[b + 1] - positions[a + 1], ez = positions[b + 2] - positions[a + 2];
    const gx = positions[c] - positions[a], gy = positions[c + 1] - positions[a + 1], gz = positions[c + 2] - positions[a + 2];
    const x = ey * gz - ez * gy, y = ez * gx - ex * gz, z = ex * gy - ey * gx;
    normals[i] = x;
    normals[i + 1] = y;
    normals[i + 2] = z;
    sizes[i / 3] = Math.sqrt(x * x + y * y + z * z);
  }
  let sharp = 0;
  for (let i = 0; i < corners.length; i++) {
    const f = 3 * (i / 3 | 0), least = SHARP * sizes[f / 3], nx = normals[f], ny = normals[f + 1], nz = normals[f + 2];
    let x = 0, y = 0, z = 0;
    for (let at = starts[corners[i]]; at < starts[corners[i] + 1]; at++) {
      const g = 3 * list[at];
      if (nx * normals[g] + ny * normals[g + 1] + nz * normals[g + 2] < least * sizes[g / 3]) {
        sharp++;
        continue;
      }
      x += normals[g];
      y += normals[g + 1];
      z += normals[g + 2];
    }
    found[i] = folded(x, y, z);
  }
  return sharp || isWelded ? found : null;
}

/** The same for a mesh before and after a change: the faces that it takes away do not bend those that it adds. */
export function bendsOfBoth({ positions, faces, parts }) {
  const count = positions.length / 3, [first, end] = parts.gone, of = (left) => bends(positions, faces, round(faces, count, left), true);
  const after = of(parts.gone);
  if (end > first) after.set(of(parts.new).subarray(3 * first, 3 * end), 3 * first);
  return after;
}
