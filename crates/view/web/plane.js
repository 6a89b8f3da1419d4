// The mirror plane in the view: a translucent rectangle with its normal, and handles that shift and turn it.

import { cross, dot, minus, plus, times, unit } from "../../report/viewer/camera.js";
import { find } from "../../report/viewer/controls.js";
import { planeAxes } from "./outline.js";

/** Half the side of the rectangle, in half extents of the mesh along it. */
const BEYOND = 1.05;
/** Length of the normal that is drawn, in radii of the mesh. */
const ARROW = 0.45;
/** Place of the handles that turn, as parts of the way from the middle of the rectangle to its sides. */
const ARM = 0.7;
/** Opacity of the rectangle: before the surface, and behind it. */
const OPACITY = [0.3, 0.08];
/** A handle that moves by less than this, in pixels per length of the normal or per radian, is seen from its end. */
const END_ON = 12;
/** What an arrow key does: part of the radius, and radians. */
const STEP = [0.005, Math.PI / 360];

// The depth is interpolated unclamped, so that a rectangle that reaches beyond the far plane is not cut off.
const VERTEX = `#version 300 es
uniform mat4 matrix;
uniform vec3 corners[4];
out vec2 depth;
void main() {
  vec4 p = matrix * vec4(corners[gl_VertexID], 1.0);
  depth = p.zw;
  gl_Position = vec4(p.xy, 0.0, p.w);
}`;
const FRAGMENT = `#version 300 es
precision highp float;
in vec2 depth;
uniform vec4 paint;
out vec4 colour;
void main() {
  gl_FragDepth = clamp(0.5 * depth.x / depth.y + 0.5, 0.0, 1.0);
  colour = paint;
}`;

export class Plane {
  constructor(app) {
    this.app = app;
    /** Centre, unit normal and the rectangle's directions, in the scene; null if no plane is shown. */
    this.placed = null;
    this.given = false;
    app.viewer.over = (side, matrix, colours) => this.draw(matrix, colours);
    this.handles = ["shift", "turn", "turn-other"].map((name) => find("#plane-" + name));
    this.handles.forEach((button, kind) => this.use(button, kind));
  }

  /** Shows the given plane with handles, or the plane that was found, while a command that can use it is open. */
  show() {
    const { app } = this, { like, steps, viewer } = app;
    const open = app.showsJob() && ["fill", "restore"].includes(steps?.kind) && find("#like")?.open;
    this.given = Boolean(open) && like.kind === "plane";
    const plane = !open ? null : this.given ? like.plane() : like.found(), had = this.placed;
    this.place(plane);
    if (had || this.placed) viewer.refresh();
  }

  /** Places the rectangle about the middle of the mesh. Its directions turn with the normal. */
  place(plane) {
    const mesh = this.app.viewer.sides.after?.mesh, { bounds } = this.app.model.state;
    if (!plane || !mesh || !bounds) {
      this.placed = null;
      return;
    }
    const [low, high] = bounds.map((corner) => minus(corner, mesh.centre)), normal = unit(plane[1]), point = minus(plane[0], mesh.centre);
    const middle = times(plus(low, high), 0.5), centre = minus(middle, times(normal, dot(minus(middle, point), normal)));
    const old = this.placed?.across, flat = old && minus(old, times(normal, dot(old, normal)));
    const across = flat && Math.hypot(...flat) > 0.1 ? unit(flat) : planeAxes(normal)[0], up = cross(normal, across);
    const half = (axis) => BEYOND * (high.reduce((sum, x, k) => sum + (x - low[k]) / 2 * Math.abs(axis[k]), 0) || this.app.viewer.camera.radius);
    this.placed = { centre, normal, across, up, wide: half(across), high: half(up) };
  }

  /** Sets the plane in the fields, and shows it. */
  set(centre, normal) {
    const { like, steps, viewer } = this.app, { centre: origin } = viewer.sides.after.mesh;
    const plane = [plus(centre, origin), normal];
    like.put(plane);
    this.place(plane);
    steps.describe();
    viewer.refresh();
  }

  /** The ends of the handles: the tip of the normal, and two points of the rectangle. */
  ends() {
    const { centre, normal, across, up, wide, high } = this.placed;
    return [plus(centre, times(normal, ARROW * this.app.viewer.camera.radius)), plus(centre, times(across, ARM * wide)), plus(centre, times(up, ARM * high))];
  }

  /** Draws the rectangle into a pane of the view: translucent, faint behind the surface, with its border. */
  draw(matrix, colours) {
    if (!this.placed) return;
    const { viewer } = this.app, { gl } = viewer, { centre, across, up, wide, high } = this.placed;
    // A program is lost with its context; then the viewer has new ones.
    if (this.of !== viewer.rim) [this.of, this.program] = [viewer.rim, viewer.program(VERTEX, FRAGMENT)];
    const { program, at } = this.program, corner = (x, y) => plus(centre, plus(times(across, x * wide), times(up, y * high)));
    gl.useProgram(program);
    gl.bindVertexArray(viewer.nothing);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.depthMask(false);
    gl.uniformMatrix4fv(at("matrix"), false, matrix);
    gl.uniform3fv(at("corners"), [[-1, -1], [1, -1], [1, 1], [-1, 1]].flatMap(([x, y]) => corner(x, y)));
    [gl.LEQUAL, gl.GREATER].forEach((test, i) => {
      gl.depthFunc(test);
      gl.uniform4fv(at("paint"), [...colours.mark, OPACITY[i]]);
      gl.drawArrays(gl.TRIANGLE_FAN, 0, 4);
      gl.uniform4fv(at("paint"), [...colours.mark, i ? 0.35 : 1]);
      gl.drawArrays(gl.LINE_LOOP, 0, 4);
    });
    gl.depthFunc(gl.LESS);
  }

  /** Places the normal and the handles over the view, after it was drawn. */
  drawn() {
    const { viewer } = this.app, panes = viewer.panes(), pane = panes[panes.length - 1], line = find("#plane-line");
    const ends = this.placed ? this.ends() : [], places = ends.map((end) => viewer.onPage(end, pane));
    this.handles.forEach((button, i) => {
      button.hidden = !this.given || !places[i];
      if (places[i]) [button.style.left, button.style.top] = places[i].map((x) => x.toFixed(1) + "px");
    });
    const from = this.placed && viewer.onPage(this.placed.centre, pane);
    line.toggleAttribute("hidden", !from || !places[0]);
    if (from && places[0]) [["x1", from[0]], ["y1", from[1]], ["x2", places[0][0]], ["y2", places[0][1]]].forEach(([name, x]) => line.setAttribute(name, x.toFixed(1)));
  }

  /** Lets a handle be dragged, and moved by arrow keys. */
  use(button, kind) {
    let last = null;
    button.addEventListener("pointerdown", (event) => {
      button.setPointerCapture(event.pointerId);
      last = [event.clientX, event.clientY];
    });
    button.addEventListener("pointermove", (event) => {
      if (!last) return;
      const now = [event.clientX, event.clientY], by = [now[0] - last[0], now[1] - last[1]];
      last = now;
      this.drag(kind, by);
    });
    const stop = () => { last = null; };
    button.addEventListener("pointerup", stop);
    button.addEventListener("pointercancel", stop);
    button.addEventListener("keydown", (event) => {
      const sign = { ArrowUp: 1, ArrowRight: 1, ArrowDown: -1, ArrowLeft: -1 }[event.key];
      if (!sign) return;
      event.preventDefault();
      event.stopPropagation();
      this.move(kind, sign * (event.shiftKey ? 10 : 1) * (kind ? STEP[1] : STEP[0] * this.app.viewer.camera.radius));
    });
  }

  /** The position of a point of the scene in pixels of the page, also outside of the view. */
  project(point) {
    const { viewer } = this.app, p = viewer.place(point), { half } = viewer.aim(viewer.canvas.clientWidth, 0);
    return [p.x * half, -p.y * half];
  }

  /** Moves a handle by a movement of the pointer, in pixels of the page: by the part along the handle's own movement in the picture. */
  drag(kind, by) {
    const { centre, normal } = this.placed, ends = this.ends(), along = (a, b) => [b[0] - a[0], b[1] - a[1]];
    const share = (way) => (by[0] * way[0] + by[1] * way[1]) / (way[0] ** 2 + way[1] ** 2 || 1);
    const from = this.project(ends[kind]), small = 0.05;
    if (kind === 0) {
      const length = ARROW * this.app.viewer.camera.radius, way = along(this.project(centre), from);
      const { reach } = this.app.viewer.camera, { half } = this.app.viewer.aim(this.app.viewer.canvas.clientWidth, 0);
      return this.move(0, Math.hypot(...way) > END_ON ? share(way) * length : -by[1] * reach / half);
    }
    const arm = minus(ends[kind], centre), way = along(from, this.project(plus(ends[kind], times(normal, small * Math.hypot(...arm))))).map((x) => x / small);
    if (Math.hypot(...way) > END_ON) return this.move(kind, share(way));
    // The handle moves towards the eye or away from it: shortening the side in the picture turns it.
    return this.move(kind, -share(along(this.project(centre), from)));
  }

  /** Shifts the plane by a length, or turns it by an angle: its side with the handle `kind` goes towards the normal. */
  move(kind, by) {
    const { centre, normal, across, up } = this.placed, side = kind === 1 ? across : up;
    if (kind === 0) return this.set(plus(centre, times(normal, by)), normal);
    const c = Math.cos(by), s = Math.sin(by);
    this.placed[kind === 1 ? "across" : "up"] = plus(times(side, c), times(normal, s));
    return this.set(centre, minus(times(normal, c), times(side, s)));
  }
}
