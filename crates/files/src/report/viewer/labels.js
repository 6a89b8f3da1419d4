// Labels over the canvas: numbers of holes, points and lines at rims, and the mark at a chosen point.

import { begun } from "./activity.js";
import { dot } from "./camera.js";

/** Most holes with a number; the longest come first. */
const MOST_LABELS = 200;
/** About how many vertices of a rim are tested for visibility, and the fraction of them that must be visible. */
const LOOKED_AT = 24, SEEN_PART = 0.25;
/** A number is hidden by a surface in front of its hole's middle by more than this fraction of the diameter; the hole's patch bulges less. */
const BULGE = 0.45;
/** Of two numbers nearer than this, in pixels of the page, only the first is shown. */
const APART = 15;

export class Labels {
  constructor(viewer, layer, holes, rims) {
    this.viewer = viewer;
    this.layer = layer;
    this.pinned = null;
    this.points = [];
    this.lines = [];
    this.set(holes, rims);
    viewer.drawn = (part) => part || this.place();
  }

  /** Sets the holes and their rims, and removes points and lines. */
  set(holes, rims) {
    this.layer.replaceChildren();
    this.points = this.lines = [];
    if (this.pinned) this.pinned.elements = {};
    this.items = holes.slice(0, MOST_LABELS).map((hole, i) => {
      const all = rims[i] || new Float32Array(), n = all.length / 3, step = Math.max(1, Math.ceil(n / LOOKED_AT));
      const rim = [];
      for (let k = 0; k < n; k += step) rim.push([...all.subarray(3 * k, 3 * k + 3)]);
      return { hole, rim, seen: {}, elements: {} };
    });
  }

  /** Sets the points (number, position, and the side if they are on one side only) and the lines between positions. */
  setPoints(points, lines = []) {
    for (const { elements } of [...this.points, ...this.lines]) for (const element of Object.values(elements)) element.remove();
    const seen = new Map(this.points.map((point) => [point.id, point.seen]));
    this.points = points.map((point) => ({ ...point, seen: seen.get(point.id) || {}, elements: {} }));
    this.lines = lines.map((line) => ({ ...line, elements: {} }));
    this.place();
  }

  /** The element of a label in a pane; created at first use. */
  element(elements, side, name, text) {
    if (!elements[side]) {
      const element = elements[side] = document.createElement("span");
      element.className = name;
      element.textContent = text;
      this.layer.append(element);
    }
    return elements[side];
  }

  /** Moves all labels to their places in the current picture; visibility is tested once the view stops moving. */
  place() {
    this.settled = false;
    this.end ??= begun("labels");
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.look(), 120);
    this.arrange();
  }

  /** Tests which holes and points are visible. */
  look() {
    for (const pane of this.viewer.panes()) {
      const depth = this.viewer.depths(pane);
      for (const point of this.points) point.seen[pane.side] = (!point.side || point.side === pane.side) && this.isFree(point.at, 0.015 * this.viewer.camera.reach, depth);
      for (const item of this.items) item.seen[pane.side] = (!item.hole.side || item.hole.side === pane.side) && this.isSeen(item, depth);
    }
    this.arrange();
    this.settled = true;
    this.end?.();
    this.end = null;
  }

  /** Whether the section keeps a point and no surface is in front of it by more than `lift`. */
  isFree(point, lift, depth) {
    const p = this.viewer.place(point), [x, y, z, w] = this.viewer.section;
    return dot([x, y, z], point) <= w && p.depth > 0 && p.depth - lift <= depth(p);
  }

  isSeen({ hole, rim }, depth) {
    const { viewer } = this, slack = 0.015 * viewer.camera.reach + 0.03 * hole.diameter;
    const free = (point, lift) => {
      const p = viewer.place(point);
      return p.depth > 0 && p.depth - lift <= depth(p);
    };
    if (!rim.length || !this.isFree(hole.centre, Math.max(slack, BULGE * hole.diameter), depth)) return false;
    return rim.filter((point) => free(point, slack)).length >= SEEN_PART * rim.length;
  }

  arrange() {
    const panes = this.viewer.panes(), rims = this.viewer.options.rims;
    const shown = new Set();
    for (const pane of panes) {
      const taken = [];
      for (const { hole, seen, elements } of this.items) {
        const at = rims && seen[pane.side] && this.viewer.onPage(hole.centre, pane);
        if (!at || taken.some((p) => Math.hypot(p[0] - at[0], p[1] - at[1]) < APART)) continue;
        taken.push(at);
        shown.add(this.show(this.element(elements, pane.side, "label", hole.id), at));
      }
      for (const { side, ends, elements } of this.lines) {
        const places = rims && (!side || side === pane.side) && ends.map((end) => this.viewer.onPage(end, pane));
        if (!places || places.includes(null)) continue;
        const [[x0, y0], [x1, y1]] = places, element = this.show(this.element(elements, pane.side, "crease", ""), places[0]);
        element.style.width = Math.hypot(x1 - x0, y1 - y0).toFixed(1) + "px";
        element.style.transform = `rotate(${Math.atan2(y1 - y0, x1 - x0).toFixed(4)}rad)`;
        shown.add(element);
      }
      for (const { id, at, seen, elements, chosen } of this.points) {
        const place = rims && seen[pane.side] && this.viewer.onPage(at, pane);
        if (!place) continue;
        const element = this.show(this.element(elements, pane.side, "end", ""), place);
        element.dataset.end = id;
        element.classList.toggle("chosen", Boolean(chosen));
        shown.add(element);
      }
      const [x, y, z, w] = this.viewer.section, cut = this.pinned && dot([x, y, z], this.pinned.point) > w;
      const at = this.pinned && !cut && this.viewer.onPage(this.pinned.point, pane);
      if (at) shown.add(this.show(this.element(this.pinned.elements, pane.side, "pin", ""), at));
    }
    for (const element of this.layer.children) element.hidden = !shown.has(element);
  }

  show(element, [x, y]) {
    element.style.left = x.toFixed(1) + "px";
    element.style.top = y.toFixed(1) + "px";
    return element;
  }

  /** Marks a point of the scene. */
  pin(point) {
    this.pinned = { point, elements: this.pinned?.elements || {} };
    this.arrange();
  }
}
