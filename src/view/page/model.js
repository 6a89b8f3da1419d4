// The meshes of the states: fetched once, the next from what changed.

/** So many meshes are kept beside those that are shown. */
const KEPT_MESHES = 4;

/** The parts of some arrays that ranges name, one after the other. */
function gathered(values, parts, ranges, extra) {
  let count = extra.length;
  for (let i = 0; i < ranges.length; i += 2) count += parts * (ranges[i + 1] - ranges[i]);
  const all = new values.constructor(count);
  let at = 0;
  for (let i = 0; i < ranges.length; i += 2) {
    const part = values.subarray(parts * ranges[i], parts * ranges[i + 1]);
    all.set(part, at);
    at += part.length;
  }
  all.set(extra, at);
  return all;
}

/** The faces' facts of a state from where they are from and their regions. */
function stateFacts(origin, region, count) {
  const facts = new Uint32Array(count);
  for (let i = 0; i < count; i++) facts[i] = (origin ? origin[i] << ORIGIN : 0) | (region ? region[i] : 0);
  return facts;
}

/** Runs of a value and its length, spread out. */
function spread(runs, count) {
  if (!runs || runs.length === count) return runs;
  const all = new runs.constructor(count);
  let at = 0;
  for (let i = 0; i < runs.length; i += 2) all.fill(runs[i + 1], at, at += runs[i]);
  return all;
}

class Model {
  constructor() {
    this.meshes = new Map();
    this.rims = new Map();
    this.values = new Map();
    this.state = null;
  }

  async fetchState() {
    return this.state = await askJson("state");
  }

  /** The state of a number. */
  find(id) {
    return this.state.states.find((s) => s.id === id);
  }

  get current() {
    return this.find(this.state.current);
  }

  /** The mesh of a state, with its rims. */
  async mesh(id) {
    if (!this.meshes.has(id)) {
      const made = Promise.all([this.fetchMesh(id), this.fetchRims(id)]).then(([mesh, rims]) => Object.assign(mesh, rims));
      made.catch(() => this.meshes.delete(id));
      this.meshes.set(id, made);
    }
    return this.meshes.get(id);
  }

  async fetchMesh(id) {
    const parent = this.find(id)?.parent, from = this.meshes.has(parent) ? await this.meshes.get(parent) : null;
    const { header, arrays } = await askArrays(`mesh/${id}` + (from ? `?from=${parent}` : ""));
    let { positions, faces } = arrays;
    if (header.from !== null && header.from !== undefined && arrays.kept_faces) {
      positions = gathered(from.positions, 3, arrays.kept_vertices, positions);
      faces = gathered(from.faces, 3, arrays.kept_faces, faces);
    }
    const count = faces.length / 3, origin = spread(arrays.origin, count), region = spread(arrays.region, count);
    const facts = stateFacts(origin, region, count), fresh = Boolean(origin?.includes(1) || origin?.includes(2));
    const normals = vertexNormals(positions, faces);
    return { id, positions, faces, facts, normals, marks: fresh, earlier: 0.35, centre: header.centre };
  }

  async fetchRims(id) {
    const { arrays: { points, starts, ids } } = await askArrays(`rims/${id}`);
    const rims = [], numbers = [...(ids || [])];
    for (let i = 0; i + 1 < starts.length; i++) rims.push(points.subarray(3 * starts[i], 3 * starts[i + 1]));
    return { rims, rimIds: numbers };
  }

  /** Values to colour a state by, with their header. */
  async valuesOf(id, name) {
    const key = id + "/" + name;
    if (!this.values.has(key)) {
      const got = askArrays(`values/${id}?name=${encodeURIComponent(name)}`);
      got.catch(() => this.values.delete(key));
      this.values.set(key, got);
      for (const old of [...this.values.keys()].slice(0, -6)) this.values.delete(old);
    }
    return this.values.get(key);
  }

  /** Forgets meshes, the oldest first, save some. */
  forget(used) {
    const gone = [...this.meshes.keys()].filter((id) => !used.includes(id)).slice(0, -KEPT_MESHES);
    for (const id of gone) this.meshes.delete(id);
  }

  /** Has the worker find out who is next to whom, and which faces stand for all; without one that is done here. */
  prepare(mesh) {
    mesh.prepared ??= new Promise((done, failed) => {
      const worker = new Worker("worker.js");
      worker.onmessage = ({ data }) => {
        worker.terminate();
        done(data);
      };
      worker.onerror = (event) => failed(new Error("the surface cannot be prepared: " + event.message));
      worker.postMessage({ positions: mesh.positions, faces: mesh.faces });
    });
    return mesh.prepared;
  }
}
