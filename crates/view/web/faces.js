// Areas and normals of the faces of a mesh, which maps and counts need; computed once for each mesh.

/** The area of each face, and its unit normal; zero for a degenerate face. */
export function measuredFaces(mesh) {
  return mesh.measured ??= measured(mesh);
}

function measured({ positions: p, faces }) {
  const areas = new Float32Array(faces.length / 3), normals = new Float32Array(faces.length);
  for (let f = 0; f < faces.length; f += 3) {
    const a = 3 * faces[f], b = 3 * faces[f + 1], c = 3 * faces[f + 2];
    const ex = p[b] - p[a], ey = p[b + 1] - p[a + 1], ez = p[b + 2] - p[a + 2], gx = p[c] - p[a], gy = p[c + 1] - p[a + 1], gz = p[c + 2] - p[a + 2];
    const x = ey * gz - ez * gy, y = ez * gx - ex * gz, z = ex * gy - ey * gx, length = Math.sqrt(x * x + y * y + z * z), scale = length ? 1 / length : 0;
    areas[f / 3] = length / 2;
    normals[f] = x * scale;
    normals[f + 1] = y * scale;
    normals[f + 2] = z * scale;
  }
  return { areas, normals };
}

/** The number of faces, their area, and the area of all faces; `counts` decides by a face's value. */
export function sumOf(mesh, values, counts) {
  const { areas } = measuredFaces(mesh);
  let count = 0, area = 0, all = 0;
  for (let f = 0; f < areas.length; f++) {
    all += areas[f];
    if (!counts(values[f])) continue;
    count++;
    area += areas[f];
  }
  return { count, area, all };
}
