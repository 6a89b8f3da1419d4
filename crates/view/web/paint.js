// Painting of masks: brush, box, lasso, whole components and smooth areas, by pointer or keyboard; strokes of the smoothing brush.

import { dot } from "../../report/viewer/camera.js";
import { WHOLE } from "../../report/viewer/viewer.js";
import { tr } from "./strings.js";

const SVG = "http://www.w3.org/2000/svg";

/** Whether a point lies inside a polygon. */
export function isInside(polygon, x, y) {
  let inside = false;
  for (let i = 0, j = polygon.length - 1; i < polygon.length; j = i++) {
    const [a, b] = [polygon[i], polygon[j]];
    if (a[1] > y !== b[1] > y && x < (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]) + a[0]) inside = !inside;
  }
  return inside;
}

/** The painting tools. */
export const PAINTS = ["brush", "fair", "box", "lasso", "component", "smooth"];
/** The tools with a radius. */
const BRUSHES = ["brush", "fair"];

/** The smallest box with two boxes: left, top, width and height; the first one may be null. */
function joined(a, b) {
  if (!a) return b;
  const left = Math.min(a[0], b[0]), top = Math.min(a[1], b[1]);
  return [left, top, Math.max(a[0] + a[2], b[0] + b[2]) - left, Math.max(a[1] + a[3], b[1] + b[3]) - top];
}

const corners = ([a, b], [c, d]) => [[a, b], [c, b], [c, d], [a, d]];

export class Paint {
  /**
   * `target` returns the painted mesh with its mask and topology, or null; `notify` is called after changes, and with errors; `smoother`
   * is the smoothing brush.
   */
  constructor(viewer, overlay, target, notify, smoother) {
    Object.assign(this, { viewer, overlay, target, notify, smoother });
    this.tool = "turn";
    this.erases = false;
    this.radius = viewer.camera.radius / 20;
    this.facing = true;
    /** Angle between normals above which an edge bounds the area that the tool for smooth areas marks, in degrees. */
    this.angle = 30;
    this.times = [];
    this.started = null;
  }

  get side() {
    return this.viewer.sides[this.pane().side];
  }

  pane() {
    const panes = this.viewer.panes();
    return panes.find((pane) => pane.side === "after") || panes[0];
  }

  /** Starts painting with the active tool at a pressed pointer; null if the pointer moves the view. */
  begin(event, at) {
    const aside = event.button !== 0 || event.shiftKey && event.pointerType === "mouse" && this.tool !== "brush";
    if (!PAINTS.includes(this.tool) || aside || event.altKey) return null;
    const target = this.target();
    if (!target) {
      this.notify(tr("still_preparing"), true);
      return null;
    }
    const erases = this.erases || event.shiftKey || event.ctrlKey || event.metaKey;
    if (this.tool === "component" || this.tool === "smooth") {
      this.component(at, erases);
      return { move() {}, end() {} };
    }
    return BRUSHES.includes(this.tool) ? this.brush(target, at, erases) : this.outline(at, erases);
  }

  /** What a stroke of the brush does: marks faces, and ends as a stroke that can be undone. */
  ink({ mask }, erases) {
    mask.begin();
    return {
      put: (faces) => mask.set(faces, erases ? 0 : 1),
      end: (broken) => {
        // A second finger moves the view: undo what the first one has painted in the meantime.
        if (!mask.end() || !broken) return;
        mask.undo();
        mask.undone.pop();
        this.redraw();
      },
    };
  }

  /** Starts a stroke of a brush; null if it is refused. */
  brush(target, at, erases) {
    const ink = this.tool === "fair" ? this.smoother.ink(target) : this.ink(target, erases);
    if (!ink) return null;
    let last = null, side = 0;
    const dab = (to) => {
      const start = performance.now(), met = this.met(to), own = met && Math.sign(target.topology.front(met.face, this.viewer.camera.eye));
      // A stroke stays on the side of the surface on which it began: through a hole the pointer meets the other one.
      side ||= own;
      if (!met || this.facing && own && own !== side) { last = null; return; }
      this.dab(target, met, last || met.point, ink, side);
      last = met.point;
      this.times.push(performance.now() - start);
    };
    dab(at);
    return {
      move: (event, to) => { dab(to); this.ring(to); },
      end: (event, broken) => {
        ink.end(broken);
        this.redrawStroke();
        this.ring(null);
        this.notify();
      },
    };
  }

  /** The point of the painted mesh under a point of the page; null if there is none. */
  met(at) {
    const met = this.viewer.pick(...at), own = this.viewer.sides[met.aim.side]?.mesh === this.target()?.mesh;
    if (met.point && !own) this.notify(tr("is_before"), true);
    return met.point && own ? met : null;
  }

  /** Marks the faces near the segment from the last point to this one, and draws them again. */
  dab({ topology }, { face, point }, last, ink, side) {
    const { eye } = this.viewer.camera, sign = side || 1, [x, y, z, w] = this.viewer.section;
    const seen = (f) => !this.facing || topology.front(f, eye) * sign > 0;
    const kept = (f) => this.viewer.section === WHOLE || dot([x, y, z], topology.middle(f)) <= w;
    const faces = topology.along(face, point, last, this.radius, (f) => seen(f) && kept(f));
    const changed = ink.put(faces);
    if (!changed) return;
    this.side.surface.changed(...changed);
    this.drawRound(topology, faces, [last, point]);
  }

  /** Draws the given faces again, which the brush has touched between two points. */
  drawRound({ mesh }, faces, points) {
    const { viewer } = this, pane = this.pane(), { half } = viewer.aim(0, 0);
    if (viewer.drewThin || viewer.coarse) return viewer.refresh();
    const a = 3 * mesh.faces[3 * faces[0]], b = 3 * mesh.faces[3 * faces[0] + 1];
    const edge = Math.hypot(...[0, 1, 2].map((k) => mesh.positions[a + k] - mesh.positions[b + k]));
    let part = null;
    for (const point of points) {
      const at = viewer.onPage(point, pane), pixels = half / viewer.place(point).unit;
      // Faces nearer to the eye look larger, and reach over the brush.
      const room = 6 + 1.2 * this.radius * pixels + Math.min(120, 2 * edge * pixels);
      if (at) part = joined(part, [at[0] - room, at[1] - room, 2 * room, 2 * room]);
    }
    if (!part) return;
    this.stroked = joined(this.stroked, part);
    viewer.draw(false, part, { side: pane.side, faces: Uint32Array.from(faces) });
  }

  /** Draws the part of the view with the last stroke again, with the rims over it. */
  redrawStroke() {
    const { viewer, stroked } = this;
    this.stroked = null;
    if (stroked && !viewer.drewThin && !viewer.coarse) viewer.draw(false, stroked);
  }

  /** Marks the component under a point, or its part up to sharp edges. */
  component(at, erases) {
    const target = this.target(), met = this.met(at);
    if (!target || !met) return this.notify(tr("no_surface"), true);
    this.apply(() => target.mask.set(this.tool === "smooth" ? target.topology.smooth(met.face, this.angle) : target.topology.spread([met.face], () => true), erases ? 0 : 1));
  }

  /** Applies a change as one stroke, and draws the whole view again. */
  apply(change) {
    const { mask } = this.target();
    mask.begin();
    change();
    mask.end();
    this.redraw();
  }

  redraw() {
    this.side?.surface.changed();
    this.viewer.refresh();
    this.notify();
  }

  /** Starts a box or a lasso with a pointer. */
  outline(at, erases) {
    const isBox = this.tool === "box";
    let points = [at];
    const shape = () => isBox ? corners(points[0], points[points.length - 1]) : points;
    return {
      move: (event, to) => {
        points.push(to);
        this.show(shape());
      },
      end: (event, broken) => {
        this.show(null);
        if (!broken && points.length > 1) this.within(shape(), erases);
      },
    };
  }

  /**
   * Marks the faces whose centres are inside a polygon of the page. If `facing` is set, only visible ones, and of these only those that turn
   * their outer side to the eye, if there are any: through a hole the inner side of others is seen.
   */
  within(polygon, erases) {
    const { viewer } = this, target = this.target(), pane = this.pane(), { topology, mask } = target, { eye } = viewer.camera;
    const depth = this.facing ? viewer.depths(pane, Infinity) : null, slack = 0.004 * viewer.camera.reach;
    const box = [0, 1].map((k) => [Math.min(...polygon.map((p) => p[k])), Math.max(...polygon.map((p) => p[k]))]);
    const [x, y, z, w] = viewer.section, faces = [];
    for (let f = 0; f < mask.on.length; f++) {
      const middle = topology.middle(f), at = viewer.onPage(middle, pane);
      if (!at || at[0] < box[0][0] || at[0] > box[0][1] || at[1] < box[1][0] || at[1] > box[1][1]) continue;
      if (dot([x, y, z], middle) > w || !isInside(polygon, ...at)) continue;
      if (depth) {
        const p = viewer.place(middle);
        if (p.depth - slack > depth(p)) continue;
      }
      faces.push(f);
    }
    if (!faces.length) return this.notify(tr("none_in_there"), true);
    const outer = this.facing ? faces.filter((f) => topology.front(f, eye) > 0) : [];
    this.apply(() => mask.set(outer.length ? outer : faces, erases ? 0 : 1));
  }

  /** Grows or shrinks the mask by a length along the mesh's edges. */
  grow(length, shrinks) {
    const { mask, topology } = this.target(), { corners: points } = topology, at = (f, k) => points[3 * f + k];
    if (!mask.count) return this.notify(tr("nothing_marked_yet"), true);
    const isIn = (f) => mask.on[f] === 1, near = topology.distances(topology.edge(isIn), length);
    const faces = [];
    if (shrinks) {
      for (let f = 0; f < mask.on.length; f++) if (mask.on[f] && [0, 1, 2].some((k) => near.get(at(f, k)) < length)) faces.push(f);
    } else {
      const own = new Set();
      for (let f = 0; f < mask.on.length; f++) if (mask.on[f]) for (let k = 0; k < 3; k++) own.add(at(f, k));
      for (let f = 0; f < mask.on.length; f++) {
        if (!mask.on[f] && [0, 1, 2].every((k) => near.has(at(f, k)) || own.has(at(f, k)))) faces.push(f);
      }
    }
    this.apply(() => mask.set(faces, shrinks ? 0 : 1));
  }

  /** Uses the active tool by keys, at the cross: a box takes two corners, a lasso points until one is entered twice. */
  key(at, erases) {
    const target = this.target();
    if (!target || !PAINTS.includes(this.tool)) return false;
    if (this.tool === "component" || this.tool === "smooth") this.component(at, erases);
    else if (BRUSHES.includes(this.tool)) this.brush(target, at, erases)?.end(null, false);
    else this.keyOutline(at, erases);
    return true;
  }

  keyOutline(at, erases) {
    const points = this.started ||= [], last = points[points.length - 1];
    const closes = this.tool === "box" ? points.length === 1 : last && Math.hypot(last[0] - at[0], last[1] - at[1]) < 3;
    if (!closes || this.tool === "box") points.push(at);
    const shape = this.tool === "box" ? corners(points[0], at) : points;
    this.show(shape);
    const next = { box: tr("box_corner"), lasso: tr("lasso_point") };
    if (!closes) return this.notify(next[this.tool]);
    this.cancel();
    this.within(shape, erases);
  }

  /** Cancels an outline that was started by keys. */
  cancel() {
    this.started = null;
    this.show(null);
  }

  /** Draws an outline over the view. */
  show(points) {
    let shape = this.overlay.querySelector("polygon");
    if (!shape) this.overlay.append(shape = document.createElementNS(SVG, "polygon"));
    shape.setAttribute("points", points ? points.map((p) => p.map((x) => x.toFixed(1)).join(",")).join(" ") : "");
  }

  /** Draws the brush as a circle of its radius on the surface, at a point of the page. */
  ring(at) {
    let ring = this.overlay.querySelector("circle");
    if (!ring) this.overlay.append(ring = document.createElementNS(SVG, "circle"));
    const { viewer } = this, shown = at && BRUSHES.includes(this.tool);
    ring.setAttribute("r", shown ? Math.max(1, this.radius / viewer.camera.reach * viewer.aim(...at).half) : 0);
    if (shown) [["cx", at[0]], ["cy", at[1]]].forEach(([name, x]) => ring.setAttribute(name, x.toFixed(1)));
  }
}
