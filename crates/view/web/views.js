// Camera control: standard views, axis gizmo, up direction, roll, orthographic projection, fit, scale bar.

import { cross, dot, HALF_FIELD, minus, PARALLEL, plus, times, turned, frame } from "../../report/viewer/camera.js";
import { all, find, localised } from "../../report/viewer/controls.js";
import { kept, keep } from "./settings.js";

const SVG_NAME = "http://www.w3.org/2000/svg";
/** Angle of one roll, in radians. */
const ROLL = Math.PI / 12;
/** Largest length of the scale bar, in pixels of the page. */
const RULER = 110;
/** Upper bound of the number of points, about, that are used to fit the mesh into the view. */
const MOST_POINTS = 150_000;
/** Upper bound of the cosine of the angle between the view direction and the up direction in an upright view. */
const POLE = 0.995;

const AXES = { X: [1, 0, 0], Y: [0, 1, 0], Z: [0, 0, 1] };

export class Views {
  constructor(app) {
    this.app = app;
    const { viewer } = app, { camera } = viewer, orbit = camera.orbit.bind(camera);
    for (const button of all("[data-view]")) button.addEventListener("click", () => this.go(button.dataset.view));
    find("#reset").addEventListener("click", () => viewer.fly(this.home()));
    find("#fit").addEventListener("click", () => this.fitSelected());
    find("#roll-left").addEventListener("click", () => this.roll(ROLL));
    find("#roll-right").addEventListener("click", () => this.roll(-ROLL));
    find("#up").addEventListener("change", () => this.go("front"));
    for (const name of ["parallel", "upright"]) {
      find("#" + name).checked = kept(name, "") === "yes";
      find("#" + name).addEventListener("change", () => { keep(name, find("#" + name).checked ? "yes" : ""); this.set(); });
    }
    camera.orbit = (x, y) => find("#upright").checked ? this.turntable(x, y) : orbit(x, y);
    this.makeGizmo();
    this.set();
  }

  /** The up direction: the chosen one, or the program's guess from the mesh's extent. */
  up() {
    const chosen = find("#up").value;
    return chosen ? times(AXES[chosen[1]], chosen[0] === "-" ? -1 : 1) : this.app.model.state.scene.up;
  }

  /** Applies the projection, and levels an upright view. */
  set() {
    const { viewer } = this.app, { camera } = viewer;
    camera.field = find("#parallel").checked ? PARALLEL : HALF_FIELD;
    if (find("#upright").checked) camera.axes = frame(camera.axes[2], this.up());
    viewer.moving();
  }

  turntable(x, y) {
    const { camera } = this.app.viewer, up = this.up(), yaw = turned(camera.axes, up, -x), pitch = turned(yaw, yaw[0], -y);
    camera.axes = Math.abs(dot(pitch[2], up)) < POLE ? frame(pitch[2], up) : frame(yaw[2], up);
  }

  roll(angle) {
    const { viewer } = this.app;
    find("#upright").checked = false;
    viewer.fly({ ...viewer.camera, centre: viewer.camera.centre, axes: turned(viewer.camera.axes, viewer.camera.axes[2], angle), reach: viewer.camera.reach });
  }

  /** The axes of a standard view: right, up and towards the eye. */
  axesOf(name) {
    const up = this.up(), front = Math.abs(up[1]) > 0.5 ? [0, 0, 1] : [0, -1, 0], right = cross(up, front);
    const towards = {
      front, back: times(front, -1), right, left: times(right, -1), top: up, bottom: times(up, -1), isometric: plus(plus(front, right), up),
    }[name];
    return frame(towards, name === "top" ? times(front, -1) : name === "bottom" ? front : up);
  }

  /** Moves to a standard view of the whole mesh. */
  go(name) {
    this.app.viewer.fly(this.fit(this.axesOf(name)));
  }

  /** Moves to a place, seen along a direction; if that is zero, as one looks now. */
  look(centre, towards, reach) {
    const { viewer } = this.app;
    viewer.fly({ centre, axes: Math.hypot(...towards) ? frame(towards, this.up()) : viewer.camera.axes, reach });
  }

  /** The initial view, in which the mesh just fits. */
  home() {
    return this.fit(frame(this.app.model.state.scene.towards, this.up()));
  }

  /** The view with the given axes into which the points, or the whole mesh, just fit. */
  fit(axes, points = null) {
    const { viewer, model } = this.app, { radius, centre } = model.state.scene, mesh = viewer.sides.after?.mesh;
    if (!mesh) return { centre: [0, 0, 0], axes, reach: 1.08 * radius };
    const { clientWidth, clientHeight: high } = viewer.canvas, wide = clientWidth * (viewer.options.show === "both" ? 0.5 : 1), least = Math.min(wide, high);
    const all = points || mesh.positions, from = points ? middle(points) : minus(centre, mesh.centre);
    const stride = 3 * Math.max(1, Math.ceil(all.length / 3 / MOST_POINTS)), slope = Math.tan(viewer.camera.field);
    let reach = 1e-3 * radius;
    for (let i = 0; i < all.length; i += stride) {
      const d = [all[i] - from[0], all[i + 1] - from[1], all[i + 2] - from[2]];
      // With perspective, points nearer to the eye appear larger.
      const nearer = Math.max(0, dot(d, axes[2])) * slope;
      reach = Math.max(reach, Math.abs(dot(d, axes[0])) * least / wide + nearer, Math.abs(dot(d, axes[1])) * least / high + nearer);
    }
    return { centre: from, axes, reach: (points ? 1.3 : 1.06) * reach };
  }

  /** Fits the marked faces while Restore damage is open, else the chosen holes, else the whole mesh. */
  fitSelected() {
    const { app } = this, { viewer } = app, mesh = app.mesh(), mask = app.mask(), points = [];
    if (mesh && app.tab === "paint" && mask?.count) {
      for (let f = 0; f < mask.on.length; f++) if (mask.on[f]) for (let k = 0; k < 3; k++) points.push(...mesh.positions.subarray(3 * mesh.faces[3 * f + k], 3 * mesh.faces[3 * f + k] + 3));
    } else if (mesh) {
      for (const id of app.holes.picked) for (const x of mesh.rims[mesh.rimIds.indexOf(id)] || []) points.push(x);
    }
    viewer.fly(this.fit(viewer.camera.axes, points.length ? points : null));
  }

  makeGizmo() {
    const svg = find("#gizmo"), part = (name, to) => to.appendChild(document.createElementNS(SVG_NAME, name));
    this.balls = ["X", "Y", "Z"].flatMap((name) => [1, -1].map((sign) => {
      const group = part("g", svg), line = part("line", group), ball = part("circle", group), axis = times(AXES[name], sign);
      group.setAttribute("class", name.toLowerCase());
      ball.setAttribute("r", sign > 0 ? 10 : 6.5);
      if (sign < 0) ball.setAttribute("fill-opacity", 0.45);
      if (sign < 0) line.remove();
      const text = sign > 0 ? Object.assign(part("text", group), { textContent: name }) : null;
      ball.addEventListener("click", () => {
        const up = this.up(), level = Math.abs(dot(axis, up)) > 0.9 ? times(this.axesOf("front")[2], -Math.sign(dot(axis, up))) : up;
        this.app.viewer.fly(this.fit(frame(axis, level)));
      });
      return { group, line, ball, text, axis };
    }));
  }

  /** Updates the axis gizmo and the scale bar after the view was drawn. */
  drawn() {
    const { viewer } = this.app, [right, up, towards] = viewer.camera.axes;
    for (const { group, line, ball, text, axis } of [...this.balls].sort((a, b) => dot(a.axis, towards) - dot(b.axis, towards))) {
      const x = (37 * dot(axis, right)).toFixed(1), y = (-37 * dot(axis, up)).toFixed(1);
      ball.setAttribute("cx", x);
      ball.setAttribute("cy", y);
      [["x1", 0], ["y1", 0], ["x2", x], ["y2", y]].forEach(([name, value]) => line.setAttribute(name, value));
      text?.setAttribute("x", x);
      text?.setAttribute("y", y);
      find("#gizmo").append(group);
    }
    const unit = viewer.camera.reach / viewer.aim(0, 0).half, most = RULER * unit, ten = 10 ** Math.floor(Math.log10(most));
    const length = [5, 2, 1].map((n) => n * ten).find((n) => n <= most);
    find("#ruler i").style.width = (length / unit).toFixed(1) + "px";
    find("#ruler span").textContent = localised(Number(length.toPrecision(2))) + this.app.unit();
  }
}

/** The centre of the bounding box of points. */
function middle(points) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < points.length; i++) {
    low[i % 3] = Math.min(low[i % 3], points[i]);
    high[i % 3] = Math.max(high[i % 3], points[i]);
  }
  return times(plus(low, high), 0.5);
}
