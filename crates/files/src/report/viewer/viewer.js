// The 3D view: draws meshes in one pane or two, and finds the faces under the pointer.

import { begun } from "./activity.js";
import { alongRay, ORIGIN, rimBuffer } from "./geometry.js";
import { between, Camera, dot, minus, plus, times } from "./camera.js";
import { NUMBER_FRAGMENT, NUMBER_VERTEX, RIM_FRAGMENT, RIM_VERTEX, SURFACE_FRAGMENT, SURFACE_VERTEX } from "./shaders.js";
import { sliceOf, Still } from "./still.js";
import { covered, overlap, rimBoxes, Surface } from "./surface.js";

/** Meshes with at least this many faces are drawn without antialiasing: their faces are about as small as the pixels. */
const LARGE = 400_000;
/** Milliseconds; if a picture takes longer, it is drawn with fewer faces or fewer pixels while the view moves. */
const FLUID = 45;
/** Resolutions of a coarse picture, as fractions of the full one: the first whose upper bound of the measured milliseconds at half holds. */
const COARSE = [[0.5, 1.3 * FLUID], [0.34, 2 * FLUID], [0.24, Infinity]];
/** Milliseconds; if a full picture takes longer, a change is first seen in one with fewer faces or pixels: within 100 ms on most machines. */
const SLOW = 80;
/** Frames that the first picture of a motion waits if a full picture takes long: what a click changes beside the view is seen before. */
const BESIDE = 2;
/** Meshes whose numbers of faces differ by less than this fraction are taken to be drawn in the same time. */
const SIMILAR = 0.1;
/** A section plane that cuts nothing. */
export const WHOLE = [0, 0, 0, 1];

export class Viewer {
  /** `faces` is the number of faces to expect; with `parts`, parts of the picture can be redrawn alone. */
  constructor(canvas, { radius, faces = 0, parts = false }) {
    this.canvas = canvas;
    this.camera = new Camera(radius);
    this.options = { show: "both", colour: "plain", wire: false, flat: false, rims: true };
    this.selected = { region: 0, rim: -1 };
    this.section = WHOLE;
    this.split = 0.5;
    this.frames = 0;
    // Milliseconds of a picture with all faces (whole), with fewer faces (thin) and with fewer pixels (coarse).
    this.costs = {};
    this.sides = {};
    this.surfaces = new Map();
    this.smooth = faces < LARGE;
    this.parts = parts;
    // Without antialiasing, and where the picture is kept between frames, the full picture can be drawn in slices.
    this.still = parts && !this.smooth ? new Still(this) : null;
    this.start();
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => { this.start(); this.refresh(); });
    new ResizeObserver(() => this.refresh()).observe(canvas);
  }

  start() {
    const gl = this.canvas.getContext("webgl2", { antialias: this.smooth, alpha: false, preserveDrawingBuffer: this.parts });
    if (!gl) throw new Error("this browser has no WebGL 2");
    this.gl = gl;
    gl.getExtension("EXT_color_buffer_float");
    this.surface = this.program(SURFACE_VERTEX, SURFACE_FRAGMENT);
    this.number = this.program(NUMBER_VERTEX, NUMBER_FRAGMENT);
    this.rim = this.program(RIM_VERTEX, RIM_FRAGMENT);
    this.hidden = null;
    this.nothing = gl.createVertexArray();
    this.rimArray = gl.createVertexArray();
    for (const surface of this.surfaces.values()) surface.start(gl);
    for (const side of Object.values(this.sides)) this.putRims(side);
  }

  /**
   * Shows a mesh on a side, or ranges of its faces, with rims; `kinds` has the index in `colours` for each rim. Sides with the same mesh
   * share its data on the graphics card. `segments` are further lines, seven numbers each: both ends, and 0 for a sharp edge, 1 for the rim of a patch.
   */
  setSide(name, { mesh, ranges, rims = [], kinds = [], colours = ["rim", "bad"], strength = 0.9, segments = null }) {
    const old = this.sides[name];
    if (old) this.gl.deleteBuffer(old.rimBuffer);
    if (!this.surfaces.has(mesh)) this.surfaces.set(mesh, new Surface(this.gl, mesh));
    const side = { mesh, surface: this.surfaces.get(mesh), ranges: ranges || [[0, mesh.faces.length / 3]], rims, kinds, colours, strength, segments };
    this.sides[name] = side;
    this.putRims(side);
    // A mended mesh of about the same size takes about the same time.
    const size = mesh.faces.length, similar = old && Math.abs(size - old.mesh.faces.length) < SIMILAR * size;
    if (old?.mesh !== mesh && !similar) this.costs = {};
    this.refresh();
  }

  /** Frees the data of meshes that are on no side and not in `meshes`. */
  keep(meshes = []) {
    const used = new Set([...meshes, ...Object.values(this.sides).map((side) => side.mesh)]);
    for (const [mesh, surface] of this.surfaces) {
      if (used.has(mesh)) continue;
      surface.free();
      this.surfaces.delete(mesh);
    }
  }

  putRims(side) {
    const gl = this.gl, { values, starts } = rimBuffer(side.rims, side.kinds);
    side.starts = starts;
    side.boxes = rimBoxes(side.rims);
    side.rimBuffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, side.rimBuffer);
    const lines = side.segments || new Float32Array(), all = new Float32Array(values.length + lines.length);
    all.set(values);
    all.set(lines, values.length);
    gl.bufferData(gl.ARRAY_BUFFER, all, gl.STATIC_DRAW);
  }

  program(vertex, fragment) {
    const gl = this.gl, program = gl.createProgram();
    for (const [type, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS) && !gl.isContextLost()) {
        throw new Error("a shader does not compile: " + gl.getShaderInfoLog(shader));
      }
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
      throw new Error("the shaders do not go together: " + gl.getProgramInfoLog(program));
    }
    const places = {};
    return { program, at: (name) => places[name] ??= gl.getUniformLocation(program, name) };
  }

  /** Redraws with the next frame; if a full picture takes long, first with fewer faces or pixels. */
  refresh() {
    if (this.costs.whole > SLOW) this.moving();
    else this.request();
  }

  /** Draws with the next frame, or `later` frames after it. */
  request(later = 0) {
    if (this.waiting) return;
    this.waiting = true;
    const end = begun("frame"), draw = () => {
      this.waiting = false;
      this.draw(this.isMoving);
      end();
    };
    const wait = (frames) => requestAnimationFrame(frames ? () => wait(frames - 1) : draw);
    wait(later);
  }

  /** Redraws while the view moves: with fewer faces or pixels, if a full picture takes too long, until the view has stopped. */
  moving() {
    const later = this.isMoving || !(this.costs.whole > SLOW) ? 0 : BESIDE;
    this.isMoving = true;
    this.endMotion ??= begun("motion");
    clearTimeout(this.rest);
    this.rest = setTimeout(() => {
      // On a slow machine the last picture of the motion is not drawn yet.
      if (this.waiting) return this.moving();
      this.isMoving = false;
      if ((this.drewThin || this.coarse) && this.still && this.costs.whole > SLOW) this.still.begin(this.costs.whole);
      else if (this.drewThin || this.coarse) this.request();
      this.endMotion();
      return this.endMotion = null;
    }, 160);
    this.request(later);
  }

  colours() {
    const style = getComputedStyle(this.canvas);
    const colour = (name) => {
      const text = style.getPropertyValue("--" + name).trim().slice(1);
      const digits = text.length === 3 ? [...text].map((d) => d + d).join("") : text;
      return [0, 2, 4].map((i) => parseInt(digits.slice(i, i + 2), 16) / 255);
    };
    const names = ["sky", "base", "patch", "chosen", "inside", "edge", "rim", "bad", "mark", "mask", "fault", "soft", "second", "fair", "good", "seam"];
    return Object.fromEntries(names.map((n) => [n, colour(n)]));
  }

  /** The visible sides, each with its part of the canvas in pixels, and `under`: the part for which its picture is projected. */
  panes() {
    const { width } = this.canvas, half = Math.floor(width / 2), { show } = this.options;
    const pane = (side, left, right, under = [left, right]) => ({ side, left, width: right - left, under: { left: under[0], width: under[1] - under[0] } });
    if (show === "both") return [pane("before", 0, half), pane("after", half, width)];
    if (show !== "slider") return [pane(show, 0, width)];
    const at = Math.round(this.split * width);
    return [pane("before", 0, at, [0, width]), pane("after", at, width, [0, width])];
  }

  /**
   * Draws everything, or only a part of the canvas: left, top, width and height in pixels of the page. If only the colours of some faces of
   * a side have changed, these faces are drawn over the picture where that is possible. `slice` draws the part of the faces between two fractions.
   */
  draw(fewer = false, part = null, changed = null, slice = null) {
    const gl = this.gl, canvas = this.canvas, isFirst = !slice?.from, isLast = !slice || slice.to === 1;
    if (gl.isContextLost()) return;
    if (!slice && this.still?.drop() && part) {
      // The rest of the picture is not drawn yet.
      this.moving();
      return;
    }
    this.coarse = fewer && (this.costs.thin ?? this.costs.whole) > FLUID;
    const ratio = Math.min(window.devicePixelRatio || 1, 2) * (this.coarse ? COARSE.find(([, most]) => !(this.costs.coarse > most))[0] : 1);
    const size = [canvas.clientWidth, canvas.clientHeight].map((x) => Math.max(1, Math.round(x * ratio)));
    if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
    const colours = this.colours(), start = performance.now();
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.enable(gl.SCISSOR_TEST);
    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
    gl.clearColor(...colours.sky, 1);
    this.drewThin = false;
    const bounds = part ? [part[0] * ratio, size[1] - (part[1] + part[3]) * ratio, part[2] * ratio, part[3] * ratio] : [0, 0, ...size];
    for (const pane of this.panes()) {
      const side = this.sides[pane.side], { under } = pane;
      const left = Math.max(pane.left, Math.floor(bounds[0])), right = Math.min(pane.left + pane.width, Math.ceil(bounds[0] + bounds[2]));
      const bottom = Math.max(0, Math.floor(bounds[1])), top = Math.min(size[1], Math.ceil(bounds[1] + bounds[3]));
      if (right <= left || top <= bottom) continue;
      gl.viewport(under.left, 0, under.width, canvas.height);
      gl.scissor(left, bottom, right - left, top - bottom);
      gl.depthMask(true);
      const over = changed?.side === pane.side && side && this.canDrawOver(side) ? changed.faces : null;
      if (!over && isFirst) gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
      if (!side) continue;
      const matrix = this.camera.matrix(under.width / canvas.height);
      const [across, up] = [(x) => 2 * (x - under.left) / under.width - 1, (y) => 2 * y / size[1] - 1];
      const within = [across(left), up(bottom), across(right), up(top)];
      this.drawSurface(side, matrix, colours, fewer, within, over, slice);
      if (!isLast) continue;
      if (this.options.rims && side.rims.length || side.segments) this.drawRims(side, matrix, under.width, canvas.height, ratio, colours, part && within);
      this.over?.(side, matrix, colours);
    }
    if (!isLast) return;
    if (!part && !slice) this.measure(start, fewer);
    this.frames++;
    this.drawn?.(part);
  }

  /** Measures the time of the first picture of each kind: all faces, fewer faces, fewer pixels. */
  measure(start, fewer) {
    const kind = this.coarse ? "coarse" : this.drewThin ? "thin" : "whole";
    if (this.costs[kind] !== undefined || kind === "thin" && !fewer) return;
    this.gl.readPixels(0, 0, 1, 1, this.gl.RGBA, this.gl.UNSIGNED_BYTE, new Uint8Array(4));
    this.costs[kind] = performance.now() - start;
  }

  /**
   * Whether faces can be drawn over the picture: it has kept its depths, and has all faces. Large meshes only, which have no antialiasing:
   * others are drawn soon enough, and have smooth outlines.
   */
  canDrawOver({ surface }) {
    return this.parts && !this.smooth && !surface.levels.clusters && !this.options.wire;
  }

  /** Draws a surface, only the faces `over` over the picture, or only a slice of the faces. */
  drawSurface({ mesh, surface, ranges }, matrix, colours, fewer, within, over, slice) {
    const gl = this.gl, { program, at } = this.surface, { options } = this, { colour } = surface;
    const thinned = fewer && Boolean(surface.levels.thin) && !(this.costs.whole < FLUID), plan = over ? surface.planOf(over) : surface.plan(matrix, ranges, thinned, within);
    this.drewThin ||= thinned;
    if (slice && plan.level && slice.from) return;
    if (slice && !plan.level) plan.spans = sliceOf(plan.spans, plan.count, slice);
    gl.useProgram(program);
    gl.bindVertexArray(this.nothing);
    gl.disable(gl.BLEND);
    gl.depthMask(true);
    surface.bind(this.surface, plan.level);
    gl.uniformMatrix4fv(at("matrix"), false, matrix);
    gl.uniform3fv(at("eye"), this.camera.eye);
    ["right", "up", "towards"].forEach((name, i) => gl.uniform3fv(at(name), this.camera.axes[i]));
    for (const name of ["base", "chosen", "inside", "edge", "mask", "fault"]) gl.uniform3fv(at(name), colours[name]);
    gl.uniform3fv(at("patch_"), colours.patch);
    gl.uniform4fv(at("section"), this.section);
    gl.uniform1i(at("colouring"), colour.kind === 3 && plan.level && colour.on === 2 ? 0 : colour.kind);
    gl.uniform1i(at("valuesOn"), colour.on);
    gl.uniform2fv(at("span"), colour.span);
    gl.uniform2fv(at("limits"), colour.limits.map((x) => Math.min(x, 1e10)));
    gl.uniform1i(at("skipKept"), Boolean(colour.skipKept));
    gl.uniform1i(at("gaps"), Boolean(colour.gaps));
    gl.uniform1i(at("marks"), mesh.marks);
    const palette = mesh.palette || [];
    gl.uniform1i(at("colours"), palette.length);
    if (palette.length) gl.uniform3fv(at("palette"), palette.flat());
    gl.uniform1f(at("earlier"), mesh.earlier || 0);
    gl.uniform1i(at("faceted"), options.flat);
    gl.uniform1i(at("shading"), options.shading || 0);
    gl.uniform3fv(at("lamp"), this.lamp());
    gl.uniform1f(at("wire"), options.wire && !plan.level ? 0.5 : 0);
    gl.uniform1i(at("selected"), this.selected.region || -1);
    gl.depthFunc(over ? gl.LEQUAL : gl.LESS);
    surface.draw(plan);
    gl.depthFunc(gl.LESS);
  }

  /** The direction of the main light, which moves with the eye: rotated by `options.light` degrees about the picture's vertical. */
  lamp() {
    const angle = (this.options.light || 0) * Math.PI / 180, c = Math.cos(angle), s = Math.sin(angle), [right, up, towards] = this.camera.axes;
    return plus(plus(times(right, s - 0.55 * c), times(up, 0.7)), times(towards, c + 0.55 * s));
  }

  /** Draws the rims; if only a part of the screen is drawn, the rims from the first to the last one in it. */
  drawRims(side, matrix, width, height, ratio, colours, part) {
    const seen = part ? side.rims.map((_, r) => r).filter((r) => overlap(covered(side.boxes, r, matrix), part)) : [0, side.rims.length - 1];
    if (!side.segments && !seen.length) return;
    const gl = this.gl, { program, at } = this.rim;
    gl.useProgram(program);
    gl.bindVertexArray(this.rimArray);
    gl.bindBuffer(gl.ARRAY_BUFFER, side.rimBuffer);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    gl.uniformMatrix4fv(at("matrix"), false, matrix);
    gl.uniform2f(at("size"), width, height);
    gl.uniform1f(at("lift"), 2e-4);
    gl.uniform4fv(at("section"), this.section);
    gl.uniform1f(at("slack"), 1e-4 * this.camera.radius);
    const kinds = (names) => gl.uniform3fv(at("kinds"), Array.from({ length: 5 }, (_, i) => colours[names[i % names.length]]).flat());
    const lines = side.starts[side.starts.length - 1] || 0;
    kinds(["edge", "seam"]);
    if (side.segments) this.strokes([lines, lines + side.segments.length / 7], 1.6 * ratio, 0.85, 0);
    if (!this.options.rims) return;
    kinds(side.colours);
    const [first, last] = [seen[0], seen[seen.length - 1]];
    this.strokes(side.rims.length && seen.length ? [side.starts[first], side.starts[last + 1]] : [0, 0], 2.2 * ratio, side.strength, 0.12);
    const { rim: chosen, mesh } = this.selected;
    if (chosen < 0 || mesh && mesh !== side.mesh || chosen + 1 >= side.starts.length) return;
    kinds(["mark"]);
    this.strokes([side.starts[chosen], side.starts[chosen + 1]], 4.5 * ratio, 1, 0.3);
  }

  /** Draws edges of rims; hidden ones are drawn faintly. */
  strokes([first, end], width, strength, hidden) {
    const gl = this.gl, { program, at } = this.rim;
    if (end === first) return;
    [["from", 3, 0], ["to", 3, 12], ["kind", 1, 24]].forEach(([name, size, offset]) => {
      const place = gl.getAttribLocation(program, name);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, size, gl.FLOAT, false, 28, 28 * first + offset);
      gl.vertexAttribDivisor(place, 1);
    });
    gl.uniform1f(at("width"), width);
    for (const [test, part] of [[gl.GREATER, hidden], [gl.LEQUAL, strength]]) {
      gl.depthFunc(test);
      gl.uniform1f(at("strength"), part);
      gl.drawArraysInstanced(gl.TRIANGLES, 0, 6, end - first);
    }
    gl.depthFunc(gl.LESS);
  }

  /** The pane under a point of the canvas, and the point as fractions of the pane's smaller half side. */
  aim(x, y) {
    const ratio = this.canvas.width / this.canvas.clientWidth, height = this.canvas.height;
    const panes = this.panes();
    const pane = panes.find((p) => x * ratio < p.left + p.width) || panes[panes.length - 1], { under } = pane;
    const half = Math.min(under.width, height) / 2;
    return { side: pane.side, x: (x * ratio - under.left - under.width / 2) / half, y: (height / 2 - y * ratio) / half, half: half / ratio };
  }

  /** The face under a point of the canvas, its region, and the point on it. */
  pick(x, y) {
    const aim = this.aim(x, y), pane = this.panes().find((p) => p.side === aim.side), side = this.sides[aim.side];
    if (!side || this.gl.isContextLost()) return { aim };
    const { left, width } = pane.under, height = this.canvas.height, ratio = this.canvas.width / this.canvas.clientWidth;
    const column = Math.floor(x * ratio - left), row = Math.floor(height - y * ratio);
    if (column < 0 || row < 0 || column >= width || row >= height) return { aim };
    const [number] = this.numbers(pane, 1, [column, row, 1, 1]);
    if (!number) return { aim };
    const eye = this.camera.eye, ray = this.camera.ray(aim.x, aim.y), { mesh } = side;
    const fact = mesh.facts[number - 1], region = (fact >> ORIGIN & 3) === 1 ? fact & 65535 : 0;
    return { aim, face: number - 1, region, point: plus(eye, times(ray, alongRay(mesh, number - 1, eye, ray))) };
  }

  /** The depth of the surface in a pane, as a function of a point from `place`. Face indices are drawn at low resolution and read back. */
  depths(pane, most = 480) {
    const side = this.sides[pane.side], scale = Math.min(1, most / Math.max(pane.under.width, this.canvas.height));
    if (!side || this.gl.isContextLost()) return () => -Infinity;
    const width = Math.max(1, Math.round(pane.under.width * scale)), height = Math.max(1, Math.round(this.canvas.height * scale));
    const numbers = this.numbers(pane, scale, [0, 0, width, height], Boolean(side.surface.levels.thin) && most <= 480), half = Math.min(width, height) / 2;
    const { camera } = this, eye = camera.eye, known = new Map();
    const depth = (i, j) => {
      const at = j * width + i, number = numbers[at];
      if (!number) return Infinity;
      if (!known.has(at)) {
        const ray = camera.ray((i + 0.5 - width / 2) / half, (j + 0.5 - height / 2) / half);
        known.set(at, -dot(ray, camera.axes[2]) * alongRay(side.mesh, number - 1, eye, ray));
      }
      return known.get(at);
    };
    return ({ x, y }) => {
      const column = Math.floor(width / 2 + x * half), row = Math.floor(height / 2 + y * half);
      let most = -Infinity;
      for (let i = Math.max(0, column - 1); i <= Math.min(width - 1, column + 1); i++) {
        for (let j = Math.max(0, row - 1); j <= Math.min(height - 1, row + 1); j++) most = Math.max(most, depth(i, j));
      }
      return most;
    };
  }

  /** The indices, plus one, of the faces seen in a part of a pane drawn at a scale; 0 where there is no face. */
  numbers(pane, scale, [left, bottom, width, height], thinned = false) {
    const gl = this.gl, side = this.sides[pane.side], { under } = pane;
    const whole = [Math.max(1, Math.round(under.width * scale)), Math.max(1, Math.round(this.canvas.height * scale))];
    if (this.hidden?.width !== whole[0] || this.hidden?.height !== whole[1]) this.hidden = this.target(...whole);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.hidden.frame);
    gl.viewport(0, 0, ...whole);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(left, bottom, width, height);
    gl.disable(gl.BLEND);
    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
    gl.clearBufferuiv(gl.COLOR, 0, [0, 0, 0, 0]);
    gl.clearBufferfv(gl.DEPTH, 0, [1]);
    const matrix = this.camera.matrix(under.width / this.canvas.height), { program, at } = this.number;
    gl.useProgram(program);
    gl.bindVertexArray(this.nothing);
    gl.uniformMatrix4fv(at("matrix"), false, matrix);
    gl.uniform4fv(at("section"), this.section);
    const part = [2 * left / whole[0] - 1, 2 * bottom / whole[1] - 1, 2 * (left + width) / whole[0] - 1, 2 * (bottom + height) / whole[1] - 1];
    const plan = side.surface.plan(matrix, side.ranges, thinned, part);
    side.surface.bind(this.number, plan.level);
    side.surface.draw(plan);
    const four = new Uint32Array(4 * width * height), numbers = new Uint32Array(width * height);
    gl.readPixels(left, bottom, width, height, gl.RGBA_INTEGER, gl.UNSIGNED_INT, four);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    for (let i = 0; i < numbers.length; i++) numbers[i] = four[4 * i];
    return numbers;
  }

  /** A hidden framebuffer for face indices. */
  target(width, height) {
    const gl = this.gl, old = this.hidden, frame = gl.createFramebuffer();
    const colour = gl.createRenderbuffer(), depth = gl.createRenderbuffer();
    if (old) [old.colour, old.depth].forEach((buffer) => gl.deleteRenderbuffer(buffer));
    if (old) gl.deleteFramebuffer(old.frame);
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    for (const [buffer, format, place] of [[colour, gl.R32UI, gl.COLOR_ATTACHMENT0], [depth, gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT]]) {
      gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
      gl.renderbufferStorage(gl.RENDERBUFFER, format, width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, buffer);
    }
    return { frame, colour, depth, width, height };
  }

  /** The position of a point of the scene in the units of `aim`, and its depth. */
  place(point) {
    const d = minus(point, this.camera.eye), [r, u, t] = this.camera.axes;
    const depth = -dot(d, t), s = Math.tan(this.camera.field) * depth;
    return { x: dot(d, r) / s, y: dot(d, u) / s, depth, unit: s };
  }

  /** The position of a point of the scene in pixels of the page from the canvas's corner; null outside the pane. */
  onPage(point, pane) {
    const p = this.place(point), ratio = this.canvas.width / this.canvas.clientWidth || 1, height = this.canvas.height;
    const { under } = pane, half = Math.min(under.width, height) / 2;
    const x = under.left + under.width / 2 + p.x * half, y = height / 2 - p.y * half;
    if (!(p.depth > 0 && x >= pane.left && x <= pane.left + pane.width && y >= 0 && y <= height)) return null;
    return [x / ratio, y / ratio];
  }

  /** Animates the camera to a goal. */
  fly(goal) {
    const camera = this.camera, from = { centre: camera.centre, axes: camera.axes, reach: camera.reach };
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    const start = performance.now(), length = still ? 0 : 450, flight = this.flight = {}, end = begun("flight");
    const step = () => {
      if (this.flight !== flight) return end();
      this.moving();
      const t = length ? Math.min(1, (performance.now() - start) / length) : 1, s = t * t * (3 - 2 * t);
      camera.centre = plus(times(from.centre, 1 - s), times(goal.centre, s));
      camera.reach = from.reach ** (1 - s) * goal.reach ** s;
      camera.axes = between(from.axes, goal.axes, s);
      this.refresh();
      if (t < 1) return requestAnimationFrame(step);
      this.flight = null;
      return end();
    };
    step();
  }
}
