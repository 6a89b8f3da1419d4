// Adjacency of faces: components, smooth areas, distances along edges, for painting.

import { cross, dot, minus, times } from "../../report/viewer/camera.js";

export class Topology {
  /** A mesh with the worker's results: the welded vertex of each corner, and the faces round each welded vertex. */
  constructor(mesh, { corners, starts, list }) {
    Object.assign(this, { mesh, corners, starts, list });
    this.visited = new Uint32Array(mesh.faces.length / 3);
    this.visit = 0;
  }

  /** Calls `called` with each face that shares an edge with `face`. */
  beside(face, called) {
    const { corners, starts, list } = this;
    for (let k = 0; k < 3; k++) {
      const a = corners[3 * face + k], b = corners[3 * face + (k + 1) % 3];
      for (let i = starts[a]; i < starts[a + 1]; i++) {
        const other = list[i], c = 3 * other;
        if (other !== face && (corners[c] === b || corners[c + 1] === b || corners[c + 2] === b)) called(other);
      }
    }
  }

  /** The faces that are connected to the seeds through faces for which `wanted` is true. */
  spread(seeds, wanted) {
    const stamp = ++this.visit, { visited } = this, reached = [];
    for (const face of seeds) {
      if (visited[face] === stamp) continue;
      visited[face] = stamp;
      reached.push(face);
    }
    const look = (other) => {
      if (visited[other] === stamp) return;
      visited[other] = stamp;
      if (wanted(other)) reached.push(other);
    };
    for (let i = 0; i < reached.length; i++) this.beside(reached[i], look);
    return reached;
  }

  /** The unit normal of a face. */
  normal(face) {
    const { positions: p, faces } = this.mesh, a = 3 * faces[3 * face], b = 3 * faces[3 * face + 1], c = 3 * faces[3 * face + 2];
    const n = cross([p[b] - p[a], p[b + 1] - p[a + 1], p[b + 2] - p[a + 2]], [p[c] - p[a], p[c + 1] - p[a + 1], p[c + 2] - p[a + 2]]);
    return times(n, 1 / (Math.hypot(...n) || 1));
  }

  /** The faces that are connected to one across edges whose normals differ by at most `angle` degrees. */
  smooth(face, angle) {
    const stamp = ++this.visit, { visited } = this, reached = [face], least = Math.cos(angle * Math.PI / 180);
    visited[face] = stamp;
    for (let i = 0; i < reached.length; i++) {
      const normal = this.normal(reached[i]);
      this.beside(reached[i], (other) => {
        if (visited[other] === stamp || dot(normal, this.normal(other)) < least) return;
        visited[other] = stamp;
        reached.push(other);
      });
    }
    return reached;
  }

  /** The centroid of a face. */
  middle(face) {
    const { positions: p, faces } = this.mesh, a = 3 * faces[3 * face], b = 3 * faces[3 * face + 1], c = 3 * faces[3 * face + 2];
    return [(p[a] + p[b] + p[c]) / 3, (p[a + 1] + p[b + 1] + p[c + 1]) / 3, (p[a + 2] + p[b + 2] + p[c + 2]) / 3];
  }

  /** Positive if the eye sees the front of a face. Unnormalised: six times the volume of the tetrahedron of face and eye. */
  front(face, eye) {
    const { positions: p, faces } = this.mesh, a = 3 * faces[3 * face], b = 3 * faces[3 * face + 1], c = 3 * faces[3 * face + 2];
    const ex = p[b] - p[a], ey = p[b + 1] - p[a + 1], ez = p[b + 2] - p[a + 2];
    const gx = p[c] - p[a], gy = p[c + 1] - p[a + 1], gz = p[c + 2] - p[a + 2];
    return (ey * gz - ez * gy) * (eye[0] - p[a]) + (ez * gx - ex * gz) * (eye[1] - p[a + 1]) + (ex * gy - ey * gx) * (eye[2] - p[a + 2]);
  }

  /** The faces that are connected to `face` and whose centroids are within a radius of the segment between two points. */
  along(face, from, to, radius, wanted) {
    const { positions: p, faces } = this.mesh, [fx, fy, fz] = from, [wx, wy, wz] = minus(to, from), length = wx * wx + wy * wy + wz * wz || 1;
    // Without vectors as arrays: this runs for thousands of faces while the pointer moves.
    return this.spread([face], (other) => {
      const a = 3 * faces[3 * other], b = 3 * faces[3 * other + 1], c = 3 * faces[3 * other + 2];
      const x = (p[a] + p[b] + p[c]) / 3 - fx, y = (p[a + 1] + p[b + 1] + p[c + 1]) / 3 - fy, z = (p[a + 2] + p[b + 2] + p[c + 2]) / 3 - fz;
      const t = Math.min(1, Math.max(0, (x * wx + y * wy + z * wz) / length)), u = x - t * wx, v = y - t * wy, w = z - t * wz;
      return u * u + v * v + w * w <= radius * radius && wanted(other);
    });
  }

  /** Distances of vertices from the sources along the mesh's edges, up to `length`, as a map (Dijkstra's algorithm). */
  distances(sources, length) {
    const { mesh: { positions: p }, corners, starts, list } = this, far = new Map(), heap = new Heap();
    for (const v of sources) {
      far.set(v, 0);
      heap.push(0, v);
    }
    const reach = (v, d) => {
      if (d <= length && d < (far.get(v) ?? Infinity)) {
        far.set(v, d);
        heap.push(d, v);
      }
    };
    while (heap.size) {
      const [d, v] = heap.pop();
      if (d > far.get(v)) continue;
      for (let i = starts[v]; i < starts[v + 1]; i++) {
        for (let k = 0; k < 3; k++) {
          const w = corners[3 * list[i] + k];
          if (w !== v) reach(w, d + Math.hypot(p[3 * w] - p[3 * v], p[3 * w + 1] - p[3 * v + 1], p[3 * w + 2] - p[3 * v + 2]));
        }
      }
    }
    return far;
  }

  /** The vertices shared by faces for which `isIn` is true and faces for which it is false. */
  edge(isIn) {
    const { corners } = this, sides = new Uint8Array(this.starts.length), points = [];
    for (let i = 0; i < corners.length; i++) sides[corners[i]] |= isIn(i / 3 | 0) ? 1 : 2;
    for (let v = 0; v < sides.length; v++) if (sides[v] === 3) points.push(v);
    return points;
  }
}

/** A binary heap with the smallest key first. */
class Heap {
  constructor() {
    this.keys = [];
    this.values = [];
  }

  get size() {
    return this.keys.length;
  }

  push(key, value) {
    const { keys, values } = this;
    let i = keys.length;
    for (keys.push(key), values.push(value); i > 0;) {
      const up = i - 1 >> 1;
      if (keys[up] <= key) break;
      keys[i] = keys[up];
      values[i] = values[up];
      i = up;
    }
    keys[i] = key;
    values[i] = value;
  }

  pop() {
    const { keys, values } = this, top = [keys[0], values[0]], key = keys.pop(), value = values.pop(), n = keys.length;
    if (!n) return top;
    let i = 0;
    for (;;) {
      let down = 2 * i + 1;
      if (down >= n) break;
      if (down + 1 < n && keys[down + 1] < keys[down]) down++;
      if (keys[down] >= key) break;
      keys[i] = keys[down];
      values[i] = values[down];
      i = down;
    }
    keys[i] = key;
    values[i] = value;
    return top;
  }
}
