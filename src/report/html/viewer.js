// Draws the meshes.

class Viewer {
  constructor(canvas, mesh, open) {
    this.canvas = canvas;
    this.mesh = mesh;
    this.camera = new Camera(mesh.radius);
    this.options = { show: "both", colour: "plain", wire: false, flat: false, rims: true };
    this.selected = { region: 0, rim: -1 };
    this.frames = 0;
    this.open = open;
    this.start();
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => { this.start(); this.refresh(); });
    new ResizeObserver(() => this.refresh()).observe(canvas);
  }

  start() {
    const gl = this.canvas.getContext("webgl2", { antialias: true, alpha: false });
    if (!gl) throw new Error("this browser has no WebGL 2");
    this.gl = gl;
    this.surface = this.program(SURFACE_VERTEX, SURFACE_FRAGMENT);
    this.rim = this.program(RIM_VERTEX, RIM_FRAGMENT);
    this.depth = this.program(DEPTH_VERTEX, DEPTH_FRAGMENT, gl.getAttribLocation(this.surface.program, "position"));
    this.depthTarget = null;
    this.corners = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.corners);
    gl.bufferData(gl.ARRAY_BUFFER, cornerBuffer(this.mesh), gl.STATIC_DRAW);
    const rims = rimBuffer(this.mesh.rims, this.open);
    this.starts = rims.starts;
    this.rims = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.rims);
    gl.bufferData(gl.ARRAY_BUFFER, rims.values, gl.STATIC_DRAW);
    this.surfaceArray = gl.createVertexArray();
    gl.bindVertexArray(this.surfaceArray);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.corners);
    const attribute = (name, size, type, normalised, at) => {
      const place = gl.getAttribLocation(this.surface.program, name);
      if (place < 0) return;
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, size, type, normalised, CORNER_BYTES, at);
    };
    attribute("position", 3, gl.FLOAT, false, 0);
    attribute("normal", 3, gl.SHORT, true, 12);
    attribute("region", 1, gl.UNSIGNED_SHORT, false, 18);
    attribute("values", 2, gl.BYTE, true, 20);
    this.rimArray = gl.createVertexArray();
    gl.bindVertexArray(null);
  }

  program(vertex, fragment, position = -1) {
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
    if (position >= 0) gl.bindAttribLocation(program, position, "position");
    gl.linkProgram(program);
    if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
      throw new Error("the shaders do not go together: " + gl.getProgramInfoLog(program));
    }
    const places = {};
    return { program, at: (name) => places[name] ??= gl.getUniformLocation(program, name) };
  }

  /** Draws with the next frame. */
  refresh() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => { this.waiting = false; this.draw(); });
  }

  colours() {
    const style = getComputedStyle(this.canvas);
    const colour = (name) => {
      const text = style.getPropertyValue("--" + name).trim().slice(1);
      const digits = text.length === 3 ? [...text].map((d) => d + d).join("") : text;
      return [0, 2, 4].map((i) => parseInt(digits.slice(i, i + 2), 16) / 255);
    };
    return Object.fromEntries(["sky", "base", "patch", "chosen", "inside", "edge", "rim", "bad", "mark"].map((n) => [n, colour(n)]));
  }

  /** The sides that are shown, each with its part of the canvas in pixels: left, width. */
  panes() {
    const width = this.canvas.width, half = Math.floor(width / 2);
    if (this.options.show !== "both") return [{ side: this.options.show, left: 0, width }];
    return [{ side: "before", left: 0, width: half }, { side: "after", left: half, width: width - half }];
  }

  draw() {
    const gl = this.gl, canvas = this.canvas;
    if (gl.isContextLost()) return;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const size = [canvas.clientWidth, canvas.clientHeight].map((x) => Math.max(1, Math.round(x * ratio)));
    if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
    const colours = this.colours();
    gl.disable(gl.SCISSOR_TEST);
    gl.depthMask(true);
    gl.clearColor(...colours.sky, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.SCISSOR_TEST);
    gl.enable(gl.DEPTH_TEST);
    for (const pane of this.panes()) {
      gl.viewport(pane.left, 0, pane.width, canvas.height);
      gl.scissor(pane.left, 0, pane.width, canvas.height);
      const matrix = this.camera.matrix(pane.width / canvas.height);
      this.drawSurface(pane.side, matrix, colours);
      if (this.options.rims && this.mesh.rims.length) this.drawRims(matrix, pane.width, canvas.height, ratio, colours, pane.side);
    }
    this.frames++;
    this.drawn?.();
  }

  /** How far away the surface of a pane is: a function of a place as `place` gives it. Drawn small, and read back. */
  depths(pane) {
    const gl = this.gl, { program, at } = this.depth, scale = Math.min(1, 480 / Math.max(pane.width, this.canvas.height));
    const width = Math.max(1, Math.round(pane.width * scale)), height = Math.max(1, Math.round(this.canvas.height * scale));
    if (gl.isContextLost()) return () => -Infinity;
    if (this.depthTarget?.width !== width || this.depthTarget?.height !== height) this.depthTarget = this.target(width, height);
    const far = Math.hypot(...this.camera.eye) + 2 * this.mesh.radius;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.depthTarget.frame);
    gl.viewport(0, 0, width, height);
    gl.disable(gl.SCISSOR_TEST);
    gl.disable(gl.BLEND);
    gl.enable(gl.DEPTH_TEST);
    gl.depthMask(true);
    gl.clearColor(1, 1, 1, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.useProgram(program);
    gl.bindVertexArray(this.surfaceArray);
    gl.uniformMatrix4fv(at("matrix"), false, this.camera.matrix(pane.width / this.canvas.height));
    gl.uniform1f(at("far"), far);
    for (const part of this.partsOf(pane.side)) {
      const [first, end] = this.mesh.parts[part];
      if (end > first) gl.drawArrays(gl.TRIANGLES, 3 * first, 3 * (end - first));
    }
    const bytes = new Uint8Array(4 * width * height), half = Math.min(width, height) / 2;
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return ({ x, y }) => {
      const column = Math.floor(width / 2 + x * half), row = Math.floor(height / 2 + y * half);
      let most = -Infinity;
      for (let i = Math.max(0, column - 1); i <= Math.min(width - 1, column + 1); i++) {
        for (let j = Math.max(0, row - 1); j <= Math.min(height - 1, row + 1); j++) {
          const k = 4 * (j * width + i);
          const part = (bytes[k] + bytes[k + 1] / 255 + bytes[k + 2] / 65025) / 255;
          most = Math.max(most, bytes[k] === 255 ? Infinity : part * far);
        }
      }
      return most;
    };
  }

  /** A picture that is not shown. */
  target(width, height) {
    const gl = this.gl, old = this.depthTarget, frame = gl.createFramebuffer();
    const colour = gl.createRenderbuffer(), depth = gl.createRenderbuffer();
    if (old) [old.colour, old.depth].forEach((buffer) => gl.deleteRenderbuffer(buffer));
    if (old) gl.deleteFramebuffer(old.frame);
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    for (const [buffer, format, place] of [[colour, gl.RGBA8, gl.COLOR_ATTACHMENT0], [depth, gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT]]) {
      gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
      gl.renderbufferStorage(gl.RENDERBUFFER, format, width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, buffer);
    }
    return { frame, colour, depth, width, height };
  }

  drawSurface(side, matrix, colours) {
    const gl = this.gl, { program, at } = this.surface, { options, mesh } = this;
    gl.useProgram(program);
    gl.bindVertexArray(this.surfaceArray);
    gl.disable(gl.BLEND);
    gl.depthMask(true);
    gl.uniformMatrix4fv(at("matrix"), false, matrix);
    gl.uniform3fv(at("eye"), this.camera.eye);
    ["right", "up", "towards"].forEach((name, i) => gl.uniform3fv(at(name), this.camera.axes[i]));
    for (const name of ["base", "chosen", "inside", "edge"]) gl.uniform3fv(at(name), colours[name]);
    gl.uniform3fv(at("patch_"), colours.patch);
    gl.uniform1i(at("colouring"), ["plain", "curvature", "distance"].indexOf(options.colour));
    gl.uniform1i(at("marks"), mesh.marks);
    gl.uniform1i(at("colours"), mesh.palette.length);
    if (mesh.palette.length) gl.uniform3fv(at("palette"), mesh.palette.flat());
    gl.uniform1i(at("faceted"), options.flat);
    gl.uniform1f(at("wire"), options.wire ? 0.5 : 0);
    gl.uniform1f(at("selected"), this.selected.region || -1);
    for (const part of this.partsOf(side)) {
      const [first, end] = mesh.parts[part];
      if (end === first) continue;
      gl.uniform1i(at("isNew"), part === "new");
      gl.uniform1i(at("isKept"), part === "kept");
      gl.drawArrays(gl.TRIANGLES, 3 * first, 3 * (end - first));
    }
  }

  partsOf(side) {
    return ["kept", side === "before" ? "gone" : "new"];
  }

  drawRims(matrix, width, height, ratio, colours, side) {
    const gl = this.gl, { program, at } = this.rim;
    gl.useProgram(program);
    gl.bindVertexArray(this.rimArray);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.rims);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    gl.uniformMatrix4fv(at("matrix"), false, matrix);
    gl.uniform2f(at("size"), width, height);
    gl.uniform1f(at("lift"), 2e-4);
    gl.uniform3fv(at("done"), side === "before" ? colours.bad : colours.rim);
    gl.uniform3fv(at("left"), colours.bad);
    const all = [0, this.starts[this.starts.length - 1]];
    this.strokes(all, 2.2 * ratio, side === "before" ? 0.9 : 0.55, 0.12);
    const chosen = this.selected.rim;
    if (chosen < 0) return;
    gl.uniform3fv(at("done"), colours.mark);
    gl.uniform3fv(at("left"), colours.mark);
    this.strokes([this.starts[chosen], this.starts[chosen + 1]], 4.5 * ratio, 1, 0.3);
  }

  /** Draws sides of rims, and faintly where they are hidden. */
  strokes([first, end], width, strength, hidden) {
    const gl = this.gl, { program, at } = this.rim;
    if (end === first) return;
    [["from", 3, 0], ["to", 3, 12], ["open", 1, 24]].forEach(([name, size, offset]) => {
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

  /** The pane under a point of the canvas, and the point in parts of the pane's smaller half side. */
  aim(x, y) {
    const ratio = this.canvas.width / this.canvas.clientWidth, height = this.canvas.height;
    const panes = this.panes();
    const pane = panes.find((p) => x * ratio < p.left + p.width) || panes[panes.length - 1];
    const half = Math.min(pane.width, height) / 2;
    return { side: pane.side, x: (x * ratio - pane.left - pane.width / 2) / half, y: (height / 2 - y * ratio) / half, half: half / ratio };
  }

  /** The face under a point of the canvas, its region, and where it is met. */
  pick(x, y) {
    const aim = this.aim(x, y), eye = this.camera.eye, ray = this.camera.ray(aim.x, aim.y);
    const hit = meet(this.mesh, this.partsOf(aim.side).map((p) => this.mesh.parts[p]), eye, ray);
    if (!hit) return { aim };
    const own = hit.face - this.mesh.kept;
    const region = own >= 0 && own < this.mesh.new ? this.mesh.regions[own] : 0;
    return { aim, region, point: plus(eye, times(ray, hit.t)) };
  }

  /** Where a point of the scene is seen, in the units of `aim`, and its distance from the eye. */
  place(point) {
    const d = minus(point, this.camera.eye), [r, u, t] = this.camera.axes;
    const depth = -dot(d, t), s = Math.tan(HALF_FIELD) * depth;
    return { x: dot(d, r) / s, y: dot(d, u) / s, depth, unit: s };
  }

  /** Where a point of the scene is on the page, from the canvas's corner; null outside of the pane. */
  onPage(point, pane) {
    const p = this.place(point), ratio = this.canvas.width / this.canvas.clientWidth || 1, height = this.canvas.height;
    const half = Math.min(pane.width, height) / 2, x = pane.width / 2 + p.x * half, y = height / 2 - p.y * half;
    if (!(p.depth > 0 && x >= 0 && x <= pane.width && y >= 0 && y <= height)) return null;
    return [(pane.left + x) / ratio, y / ratio];
  }

  /** Moves the camera to a place in a short time. */
  fly(goal) {
    const camera = this.camera, from = { centre: camera.centre, axes: camera.axes, reach: camera.reach };
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    const start = performance.now(), length = still ? 0 : 450, flight = this.flight = {};
    const step = () => {
      if (this.flight !== flight) return;
      const t = length ? Math.min(1, (performance.now() - start) / length) : 1, s = t * t * (3 - 2 * t);
      camera.centre = plus(times(from.centre, 1 - s), times(goal.centre, s));
      camera.reach = from.reach ** (1 - s) * goal.reach ** s;
      camera.axes = between(from.axes, goal.axes, s);
      this.refresh();
      if (t < 1) requestAnimationFrame(step);
    };
    step();
  }
}
