// Sharp edges between crease ends: the numbered points at rims, two of which are clicked to continue an edge between them.

import { minus } from "../../report/viewer/camera.js";
import { find } from "../../report/viewer/controls.js";
import { counts, tr } from "./strings.js";

/** A click chooses the nearest end within this distance, in pixels of the page. */
const NEAR = 11;

export class Creases {
  constructor(app) {
    this.app = app;
    this.ends = [];
    this.pairs = [];
    /** The end that was clicked first. */
    this.first = null;
  }

  /** Takes the crease ends of a state, and the pairs that were chosen. */
  update({ crease_ends: ends, creases }, fresh) {
    if (!fresh) return;
    this.ends = ends || [];
    this.pairs = creases || [];
    this.first = null;
    this.list();
  }

  end(id) {
    return this.ends.find((end) => end.id === id);
  }

  /** The end under a point of the canvas; null where there is none, or another mesh is shown. */
  at([x, y]) {
    const { labels, viewer } = this.app;
    let best = null;
    for (const pane of viewer.panes()) {
      for (const { id, at, seen } of labels.points) {
        const place = seen[pane.side] && viewer.onPage(at, pane), off = place ? Math.hypot(place[0] - x, place[1] - y) : Infinity;
        if (off < NEAR && (!best || off < best.off)) best = { id, off };
      }
    }
    return best?.id ?? null;
  }

  /** A click on an end: the first of two, the second, or on one that has an edge, which goes. */
  choose(id) {
    const { hole } = this.end(id), had = this.pairs.find((pair) => pair.includes(id)), first = this.first;
    this.first = null;
    if (had) return this.drop(had);
    if (first === null || this.end(first).hole !== hole) {
      this.first = id;
      this.show();
      const other = first === null ? "" : tr("end_elsewhere", { first });
      return this.app.say(other + tr("end_first", { id, hole }));
    }
    if (first === id) return this.changed("");
    this.pairs.push([first, id]);
    return this.changed(tr("end_second", { first, id, hole }));
  }

  drop(pair) {
    this.pairs = this.pairs.filter((other) => other !== pair);
    this.changed(tr("crease_gone", { a: pair[0], b: pair[1] }));
  }

  /** Tells the program, and shows the pairs in view, list and words. */
  changed(words) {
    this.app.choices.creases(this.app.model.state.current, this.pairs);
    this.list();
    this.show();
    this.app.holes.changed();
    this.app.say(words);
  }

  /** Points and lines in the view of the mesh that is worked on. */
  show() {
    const mesh = this.app.mesh(), chosen = new Set([this.first, ...this.pairs.flat()]);
    const points = mesh ? this.ends.map((end) => ({ id: end.id, at: minus(end.position, mesh.centre), side: "after", chosen: chosen.has(end.id) })) : [];
    const at = (id) => points.find((point) => point.id === id).at;
    this.app.labels.setPoints(points, mesh ? this.pairs.map(([a, b]) => ({ side: "after", ends: [at(a), at(b)] })) : []);
  }

  /** The pairs as a list, each with a button that takes it away. */
  list() {
    const row = (pair) => {
      const item = document.createElement("li"), button = document.createElement("button");
      button.type = "button";
      button.textContent = tr("take_away");
      button.setAttribute("aria-label", tr("take_away_label", { a: pair[0], b: pair[1] }));
      button.addEventListener("click", () => this.drop(pair));
      item.append(tr("crease_row", { pair: pair.join(" – "), hole: this.end(pair[0])?.hole }), button);
      return item;
    };
    const count = this.ends.length;
    find("#creases-hint").textContent = count ? tr("creases_hint", { edges: counts("crease", count) }) : "";
    find("#creases").replaceChildren(...this.pairs.map(row));
  }

  /** The pairs of a fill's parameters: those of the holes that are filled as usual, or of one of them. */
  params(only) {
    const isFilled = (hole) => this.app.holes.doings.get(hole) === "fill" && (!only || only.includes(hole));
    return this.pairs.filter(([a]) => isFilled(this.end(a)?.hole));
  }
}
