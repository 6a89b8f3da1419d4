// A mesh on the graphics card: its arrays in textures, drawn by chunks of faces.

import { folded } from "./bends.js";

/** Faces of a chunk; a chunk is drawn or skipped as a whole. */
const CHUNK = 256;
/** Number of faces in view from which on a coarse version with clusters is drawn, if there is one. */
const MANY = 2_000_000;
/** Chunks of a group; if a group is completely inside or outside the picture, its chunks need no tests. */
const GROUP = 16;

/** No colouring; see [Surface.setColour]. */
const PLAIN = { kind: 0, on: 0, span: [0, 1], images: [], skipKept: false, gaps: false, limits: [-1, 1] };

/** Bounding boxes of chunks of faces: six numbers each, low then high. */
function chunkBoxes({ positions, faces }) {
  const boxes = new Float32Array(6 * Math.ceil(faces.length / 3 / CHUNK));
  for (let c = 0; c < boxes.length / 6; c++) {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    const end = Math.min(faces.length, 3 * CHUNK * (c + 1));
    for (let i = 3 * CHUNK * c; i < end; i++) {
      const v = 3 * faces[i];
      for (let k = 0; k < 3; k++) {
        const x = positions[v + k];
        if (x < low[k]) low[k] = x;
        if (x > high[k]) high[k] = x;
      }
    }
    boxes.set([...low, ...high], 6 * c);
  }
  return boxes;
}

/** Bounding boxes of rims. */
export function rimBoxes(rims) {
  const boxes = new Float32Array(6 * rims.length);
  rims.forEach((rim, r) => {
    for (let k = 0; k < 3; k++) {
      let low = Infinity, high = -Infinity;
      for (let i = k; i < rim.length; i += 3) {
        low = Math.min(low, rim[i]);
        high = Math.max(high, rim[i]);
      }
      boxes[6 * r + k] = low;
      boxes[6 * r + 3 + k] = high;
    }
  });
  return boxes;
}

/** Whether a part of the screen from [covered] overlaps another one. */
export const overlap = (box, part) => box && box[0] <= part[2] && box[2] >= part[0] && box[1] <= part[3] && box[3] >= part[1];

/** Bounding boxes of groups of boxes. */
function groupBoxes(boxes) {
  const groups = new Float32Array(6 * Math.ceil(boxes.length / 6 / GROUP));
  for (let g = 0; g < groups.length / 6; g++) {
    for (let k = 0; k < 6; k++) {
      let x = boxes[6 * GROUP * g + k];
      for (let c = GROUP * g; c < Math.min(boxes.length / 6, GROUP * (g + 1)); c++) x = k < 3 ? Math.min(x, boxes[6 * c + k]) : Math.max(x, boxes[6 * c + k]);
      groups[6 * g + k] = x;
    }
  }
  return groups;
}

/** The part of the screen that a box covers, from -1 to 1: left, bottom, right, top; null if it is behind the eye. */
export function covered(boxes, c, m) {
  let left = Infinity, bottom = Infinity, right = -Infinity, top = -Infinity, before = false;
  for (let k = 0; k < 8; k++) {
    const x = boxes[6 * c + (k & 1 ? 3 : 0)], y = boxes[6 * c + (k & 2 ? 4 : 1)], z = boxes[6 * c + (k & 4 ? 5 : 2)];
    const w = m[3] * x + m[7] * y + m[11] * z + m[15];
    if (w <= 1e-6) { before = true; continue; }
    const u = (m[0] * x + m[4] * y + m[8] * z + m[12]) / w, v = (m[1] * x + m[5] * y + m[9] * z + m[13]) / w;
    left = Math.min(left, u);
    right = Math.max(right, u);
    bottom = Math.min(bottom, v);
    top = Math.max(top, v);
  }
  if (before) return right < left ? null : [-1, -1, 1, 1];
  return [left, bottom, right, top];
}

export class Surface {
  constructor(gl, mesh) {
    this.mesh = mesh;
    /** Simplified versions by name; see [setLevel]. */
    this.levels = { ...mesh.levels };
    this.order = mesh.order;
    if (!this.order) this.chunk(mesh.faces);
    this.colour = PLAIN;
    this.start(gl);
  }

  /** Uploads everything to the graphics card; called again if the context was lost. */
  start(gl) {
    this.gl = gl;
    this.textures = {};
    this.bits = Math.min(12, Math.log2(gl.getParameter(gl.MAX_TEXTURE_SIZE)) | 0);
    const { positions, normals, faces, facts } = this.mesh, count = positions.length / 3;
    const vertices = new Uint32Array(4 * count), whole = new Uint32Array(positions.buffer, positions.byteOffset, positions.length);
    for (let i = 0; i < count; i++) {
      vertices[4 * i] = whole[3 * i];
      vertices[4 * i + 1] = whole[3 * i + 1];
      vertices[4 * i + 2] = whole[3 * i + 2];
      vertices[4 * i + 3] = folded(normals[3 * i], normals[3 * i + 1], normals[3 * i + 2]);
    }
    this.put("vertex", gl.RGBA32UI, vertices, 4);
    if (this.order) this.setOrder(this.order);
    else this.put("face", gl.R32UI, new Uint32Array(faces.buffer, faces.byteOffset, faces.length), 1);
    this.put("fact", gl.R32UI, facts, 1);
    // Unused samplers need a texture too.
    this.put("value", gl.R32F, new Float32Array(1), 1);
    this.put("colour", gl.RGBA8, new Uint8Array(4), 4);
    this.put("corner", gl.RG32F, new Float32Array(2), 2);
    this.put("ambient", gl.R8, new Uint8Array(1), 1);
    this.put("bend", gl.R32UI, new Uint32Array(1), 1);
    this.pictures([]);
    if (this.ambient) this.setAmbient(this.ambient);
    if (this.bends) this.setBends(this.bends);
    for (const [name, level] of Object.entries(this.levels)) this.setLevel(name, level);
    if (this.colour.values) this.setColour(this.colour);
  }

  /** Creates a texture for an array and writes it; the rest of the last row stays unused. */
  put(name, format, values, parts) {
    const gl = this.gl, width = 1 << this.bits, texels = values.length / parts, height = Math.max(1, Math.ceil(texels / width));
    const limit = gl.getParameter(gl.MAX_TEXTURE_SIZE);
    if (height > limit) throw new Error(`the mesh has more than the ${Math.floor(width * limit / 3)} faces that this graphics card takes`);
    gl.deleteTexture(this.textures[name] || null);
    const texture = this.textures[name] = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER]) gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
    this.write(name, format, values, parts, 0, texels);
  }

  /** Writes the texels `first` to `end` of an array, by whole rows and parts of rows. */
  write(name, format, values, parts, first, end) {
    const gl = this.gl, width = 1 << this.bits;
    const kinds = {
      [gl.RGBA32UI]: [gl.RGBA_INTEGER, gl.UNSIGNED_INT], [gl.R32UI]: [gl.RED_INTEGER, gl.UNSIGNED_INT],
      [gl.R32F]: [gl.RED, gl.FLOAT], [gl.RG32F]: [gl.RG, gl.FLOAT], [gl.RGBA8]: [gl.RGBA, gl.UNSIGNED_BYTE], [gl.R8]: [gl.RED, gl.UNSIGNED_BYTE],
    };
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.textures[name]);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    while (first < end) {
      const column = first % width, row = first / width | 0, rows = column ? 0 : (end - first) / width | 0;
      const wide = rows ? width : Math.min(width - column, end - first), texels = wide * (rows || 1);
      gl.texSubImage2D(gl.TEXTURE_2D, 0, column, row, wide, rows || 1, ...kinds[format], values.subarray(parts * first, parts * (first + texels)));
      first += texels;
    }
  }

  /** Uploads the changed flags of some faces. */
  changed(first = 0, end = this.mesh.facts.length) {
    if (end > first) this.write("fact", this.gl.R32UI, this.mesh.facts, 1, first, end);
  }

  /** Computes the boxes of the chunks, in the order in which faces are drawn. */
  chunk(faces) {
    this.boxes = chunkBoxes({ positions: this.mesh.positions, faces });
    this.groups = groupBoxes(this.boxes);
  }

  /** Sets a drawing order in which neighbouring faces follow each other: corners, and the index of each face. */
  setOrder(order) {
    this.order = order;
    this.chunk(order.faces);
    this.put("face", this.gl.R32UI, order.faces, 1);
    this.put("number", this.gl.R32UI, order.numbers, 1);
  }

  /**
   * Sets a simplified version: corners, and for each face the index of the face that it represents. `thin` is drawn while the view moves,
   * `clusters` otherwise, if many faces are in view.
   */
  setLevel(name, level) {
    this.levels[name] = level;
    this.put(name + "Face", this.gl.R32UI, level.faces, 1);
    this.put(name + "Number", this.gl.R32UI, level.numbers, 1);
  }

  /**
   * Colours the surface by `values`. `kind`: 0 none, 1 diverging scale, 2 rising scale, 3 colours as bytes, 4 texture coordinates in
   * `images`, which have the same size. `on`: 0 vertices, 1 faces, 2 corners. `span`: values at the ends of a scale. With `gaps`, values
   * below the scale are unknown. 5: a rising scale with `limits`, as parts of the span; values beyond them are faults.
   */
  setColour(colour) {
    const gl = this.gl;
    this.colour = { ...PLAIN, ...colour };
    const { kind, values } = this.colour;
    if (kind === 1 || kind === 2 || kind === 5) this.put("value", gl.R32F, values, 1);
    if (kind === 3) this.put("colour", gl.RGBA8, values, 4);
    if (kind === 4) this.put("corner", gl.RG32F, values, 2);
    if (kind === 4) this.pictures(this.colour.images);
  }

  /** Sets the part of the ambient light that reaches each vertex, from 0 to 255. */
  setAmbient(ambient) {
    this.ambient = ambient;
    this.put("ambient", this.gl.R8, ambient, 1);
  }

  /** Sets a normal for each corner of the faces, in octahedral encoding: the two sides of a sharp edge have different ones. */
  setBends(bends) {
    this.bends = bends;
    this.put("bend", this.gl.R32UI, bends, 1);
  }

  /** Uploads images of the same size as layers of one texture; the flags of a face select its layer. */
  pictures(images) {
    const gl = this.gl, [{ width, height } = { width: 1, height: 1 }] = images, kind = gl.TEXTURE_2D_ARRAY;
    gl.deleteTexture(this.textures.image || null);
    this.textures.image = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(kind, this.textures.image);
    gl.texStorage3D(kind, Math.floor(Math.log2(Math.max(width, height))) + 1, gl.RGBA8, width, height, Math.max(1, images.length));
    images.forEach((image, i) => gl.texSubImage3D(kind, 0, 0, 0, i, width, height, 1, gl.RGBA, gl.UNSIGNED_BYTE, image));
    gl.generateMipmap(kind);
    gl.texParameteri(kind, gl.TEXTURE_MIN_FILTER, gl.LINEAR_MIPMAP_LINEAR);
  }

  /** Binds the textures that a program reads to draw a simplified version, or all faces if `level` is null. */
  bind({ at }, level) {
    const gl = this.gl;
    const numbers = level ? level + "Number" : this.order ? "number" : "fact", own = ["vertex", "fact", "value", "colour", "corner", "ambient", "bend"];
    const used = { face: level ? level + "Face" : "face", number: numbers, ...Object.fromEntries(own.map((name) => [name, name])) };
    Object.entries(used).forEach(([name, from], i) => this.bindOne(at(name + "Texture"), i, this.textures[from]));
    this.bindOne(at("images"), 9, this.textures.image, gl.TEXTURE_2D_ARRAY);
    gl.uniform1i(at("wideBits"), this.bits);
    gl.uniform1i(at("occluded"), Boolean(this.ambient));
    // The corners of a simplified version are others.
    gl.uniform1i(at("creased"), Boolean(this.bends) && !level);
    gl.uniform1i(at("numbered"), Boolean(level || this.order));
  }

  bindOne(place, unit, texture, kind = this.gl.TEXTURE_2D) {
    if (place === null) return;
    const gl = this.gl;
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(kind, texture || null);
    gl.uniform1i(place, unit);
  }

  /** What to draw of a part of the screen: ranges of faces and their number, or the name of a simplified version. */
  plan(matrix, ranges, thinned, part = [-1, -1, 1, 1]) {
    if (thinned) return { level: "thin" };
    const spans = this.visible(matrix, this.order ? [[0, this.order.numbers.length]] : ranges, part), count = spans.reduce((sum, [from, to]) => sum + to - from, 0);
    return this.levels.clusters && count > MANY ? { level: "clusters" } : { level: null, spans, count };
  }

  /** A plan for single faces. */
  planOf(numbers) {
    const { faces } = this.mesh, corners = new Uint32Array(3 * numbers.length);
    for (let i = 0; i < numbers.length; i++) for (let k = 0; k < 3; k++) corners[3 * i + k] = faces[3 * numbers[i] + k];
    this.setLevel("single", { faces: corners, numbers });
    return { level: "single" };
  }

  /** The parts of ranges of faces whose chunks overlap a part of the screen. */
  visible(matrix, ranges, part) {
    const spans = [];
    const take = (first, end) => {
      const last = spans[spans.length - 1];
      if (last?.[1] === first) last[1] = end;
      else spans.push([first, end]);
    };
    const inside = (box) => box[0] >= part[0] && box[2] <= part[2] && box[1] >= part[1] && box[3] <= part[3];
    const size = CHUNK * GROUP;
    for (const [first, end] of ranges) {
      for (let g = first / size | 0; g * size < end; g++) {
        const group = covered(this.groups, g, matrix), from = Math.max(first, g * size), to = Math.min(end, (g + 1) * size);
        if (!overlap(group, part)) continue;
        if (inside(group)) { take(from, to); continue; }
        for (let c = from / CHUNK | 0; c * CHUNK < to; c++) {
          if (overlap(covered(this.boxes, c, matrix), part)) take(Math.max(from, c * CHUNK), Math.min(to, (c + 1) * CHUNK));
        }
      }
    }
    return spans;
  }

  /** Draws what a plan says, after [bind]. */
  draw({ level, spans }) {
    const gl = this.gl;
    if (level) gl.drawArrays(gl.TRIANGLES, 0, this.levels[level].faces.length);
    else for (const [from, to] of spans) gl.drawArrays(gl.TRIANGLES, 3 * from, 3 * (to - from));
  }

  free() {
    for (const texture of Object.values(this.textures)) this.gl.deleteTexture(texture);
    this.textures = {};
  }
}
