// Sharp edges across holes: numbered crease ends at the rims; clicking two of them continues a sharp edge between them.

import { minus } from "../../report/viewer/camera.js";
import { find } from "../../report/viewer/controls.js";
import { counts, tr } from "./strings.js";

/** Largest distance between a click and a crease end, in pixels of the page. */
const NEAR = 11;

export class Creases {
  constructor(app) {
    this.app = app;
    this.ends = [];
    this.pairs = [];
    /** The first clicked end of a pair. */
    this.first = null;
  }

  /** Shows the crease ends of a state, and the chosen pairs. */
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

  /** The number of the crease end at a point of the canvas; null if there is none. */
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

  /** Handles a click on an end: the first of a pair, the second, or an end with an edge, which is removed. */
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

  /** Sends the pairs to the program, and updates view, list and message. */
  changed(words) {
    this.app.choices.creases(this.app.model.state.current, this.pairs);
    this.list();
    this.show();
    this.app.holes.changed();
    this.app.say(words);
  }

  /** Draws crease ends and pairs as points and lines in the view of the current mesh. */
  show() {
    const mesh = this.app.mesh(), chosen = new Set([this.first, ...this.pairs.flat()]);
    const points = mesh ? this.ends.map((end) => ({ id: end.id, at: minus(end.position, mesh.centre), side: "after", chosen: chosen.has(end.id) })) : [];
    const at = (id) => points.find((point) => point.id === id).at;
    this.app.labels.setPoints(points, mesh ? this.pairs.map(([a, b]) => ({ side: "after", ends: [at(a), at(b)] })) : []);
  }

  /** Lists the pairs, each with a button that removes it. */
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

  /** The pairs for a fill's parameters: pairs at holes with the action fill; only at the holes `only`, if given. */
  params(only) {
    const isFilled = (hole) => this.app.holes.doing(hole) === "fill" && (!only || only.includes(hole));
    return this.pairs.filter(([a]) => isFilled(this.end(a)?.hole));
  }
}
