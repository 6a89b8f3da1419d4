// The card beside a hole that was clicked in the view: its size, its action, fill, and join with another hole.

import { digits, find, newButton } from "../../report/viewer/controls.js";
import { putIcons } from "./icons.js";
import { tr } from "./strings.js";

/** Distance between the clicked point and the card, and between the card and the edge of the window, in pixels of the page. */
const ASIDE = 16, MARGIN = 8;

export class HoleCard {
  constructor(app) {
    this.app = app;
    this.id = null;
    /** The hole that the next clicked hole is joined with. */
    this.joins = null;
  }

  /** Shows the card of a hole beside a point of the window; or joins the hole, if another one waits for it. */
  show(id, x, y) {
    const { holes } = this.app, [first] = holes.group(id), hole = holes.byId.get(first), card = find("#hole-card");
    if (this.joins !== null && !holes.group(id).includes(this.joins)) return this.join(id);
    this.id = id;
    const title = document.createElement("h2"), size = document.createElement("p"), close = newButton("", () => this.hide(), { className: "icon-button" }), actions = document.createElement("div");
    title.textContent = holes.nameOf(hole);
    size.textContent = tr("card_size", { diameter: digits(hole.diameter) + this.app.unit(), edges: hole.edges });
    close.dataset.icon = "close";
    close.setAttribute("aria-label", tr("close"));
    actions.classList.add("grid", "three");
    actions.append(...["fill", "flat", "open"].map((doing) => this.action(id, doing)));
    const run = newButton(tr("fill_it"), () => {
      this.hide();
      this.app.steps.run("fill", { only: holes.group(id) });
    });
    run.className = "first";
    run.disabled = Boolean(this.app.steps.job) || holes.doing(id) === "open";
    const join = newButton(tr("join_with"), () => {
      this.hide();
      this.joins = id;
      this.app.say(tr("join_next", { id }));
    });
    card.replaceChildren(title, close, size, actions, run, join);
    putIcons(card);
    card.hidden = false;
    const { offsetWidth: wide, offsetHeight: high } = card, [from, to] = this.span(first, x);
    const fits = (at) => at >= MARGIN && at + wide < innerWidth - MARGIN, left = [to + ASIDE, from - ASIDE - wide, x + ASIDE].find(fits) ?? Math.max(MARGIN, x - ASIDE - wide);
    card.style.left = left + "px";
    card.style.top = Math.max(MARGIN, Math.min(y - 20, innerHeight - high - MARGIN)) + "px";
    return undefined;
  }

  /** The first and the last place of a rim from left to right in the window, with the place `x` of a click, so that the card stands beside it. */
  span(id, x) {
    const { holes, viewer } = this.app, { left } = viewer.canvas.getBoundingClientRect();
    return holes.onPage(id).reduce(([from, to], [at]) => [Math.min(from, left + at), Math.max(to, left + at)], [x, x]);
  }

  /** A choice of the action for the hole. */
  action(id, doing) {
    const label = document.createElement("label"), input = document.createElement("input"), text = document.createElement("span"), set = document.createElement("fieldset");
    Object.assign(input, { type: "radio", name: "card-doing", value: doing, checked: this.app.holes.doing(id) === doing });
    text.textContent = text.title = tr("doing_" + doing);
    input.addEventListener("change", () => {
      this.app.holes.set(id, doing);
      find("#hole-card .first").disabled = doing === "open" || Boolean(this.app.steps.job);
    });
    label.append(input, text);
    set.append(label);
    return set;
  }

  /** Joins the waiting hole and another one by a bridge. If either has a bridge already, all holes of both bridges get the same one. */
  join(id) {
    const { holes } = this.app, pair = [this.joins, id], bridges = holes.bridges();
    this.joins = null;
    const taken = pair.map((hole) => holes.doings.get(hole)).filter((doing) => bridges.has(doing)), bridge = taken[0] ?? holes.freeBridge();
    const joined = [...new Set([...pair.flatMap((hole) => holes.group(hole)), ...taken.flatMap((name) => bridges.get(name))])].sort((a, b) => a - b);
    holes.put(joined.map((hole) => [hole, bridge]));
    holes.changed();
    this.app.say(tr("joined_now", { ids: joined.join(" + ") }));
  }

  /** Hides the card; returns whether it was shown or waited for a hole. */
  hide() {
    const was = !find("#hole-card").hidden || this.joins !== null;
    find("#hole-card").hidden = true;
    this.id = this.joins = null;
    return was;
  }
}
