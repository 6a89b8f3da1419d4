// The list of holes: sorting, filter, selection, and the action for each hole.

import { frame, minus } from "../../report/viewer/camera.js";
import { all, digits, directionTo, find, numberIn } from "../../report/viewer/controls.js";
import { counts, outcomeWords, tr } from "./strings.js";
import { isInside } from "./paint.js";
import { rimHoles } from "./display.js";

const DOINGS = ["fill", "open", "flat"];
/** Upper bound of the number of shown rows. */
const MOST_ROWS = 2000;

const doingName = (doing) => DOINGS.includes(doing) ? tr("doing_" + doing) : tr("doing_bridge", { number: doing.replace("bridge ", "") });

export class Holes {
  constructor(app) {
    this.app = app;
    this.list = [];
    this.byId = new Map();
    this.doings = new Map();
    /** The hole that was chosen last, and all chosen holes. */
    this.chosen = null;
    this.picked = new Set();
    this.over = null;
    /** What each row shows: action, whether it is chosen, and so on. */
    this.written = new WeakMap();
    this.sort = { by: "id", falls: false };
    for (const query of ["#wider", "#narrower"]) find(query).addEventListener("input", () => this.filter());
    find("#set-all").addEventListener("change", () => {
      this.put(this.listed().flatMap(({ id }) => this.group(id)).map((id) => [id, find("#set-all").value]));
      find("#set-all").value = "";
      this.changed();
    });
    find("#fill-chosen").addEventListener("click", () => app.steps.run("fill", { only: this.only() }));
    find("#fill-all").addEventListener("click", () => app.steps.run("fill"));
    for (const button of all("#holes-head button")) button.addEventListener("click", () => this.sortBy(button.dataset.sort));
    this.useList(find("#holes"));
  }

  /** Makes the rows usable by pointer and keyboard; the whole list is one tab stop. */
  useList(list) {
    const idAt = (event) => Number(event.target.closest("li")?.dataset.hole) || null;
    list.addEventListener("pointerover", (event) => this.hover(idAt(event)));
    list.addEventListener("pointerleave", () => this.hover(null));
    list.addEventListener("keydown", (event) => {
      const row = event.target.closest("li"), isSelect = event.target.tagName === "SELECT";
      if (!row || isSelect && event.key !== "ArrowLeft" && event.key !== "Escape") return;
      const rows = [...list.children], at = rows.indexOf(row);
      const to = { ArrowDown: at + 1, ArrowUp: at - 1, Home: 0, End: rows.length - 1 }[event.key];
      if (event.key === "ArrowRight") row.querySelector("select").focus();
      else if (isSelect) row.querySelector(".hole").focus();
      else if (to !== undefined && rows[to]) {
        this.choose(Number(rows[to].dataset.hole), true, { range: event.shiftKey });
        rows[to].querySelector(".hole").focus();
      } else if (to === undefined) return;
      event.preventDefault();
      event.stopPropagation();
    });
  }

  /** Shows the holes of a state; `fresh` says that the current mesh has changed. */
  update({ holes, choices, number_shifts: shifts }, fresh) {
    const same = !fresh && holes.length === this.list.length;
    this.list = holes;
    this.byId = new Map(holes.map((hole) => [hole.id, hole]));
    this.shifts = shifts;
    if (same) return;
    if (fresh) this.doings = new Map(holes.map((hole) => [hole.id, choices[hole.id] ?? (hole.stays_open ? "open" : "fill")]));
    if (fresh || !holes.some((hole) => hole.id === this.chosen)) {
      this.chosen = null;
      this.picked.clear();
      this.app.viewer.selected = { region: 0, rim: -1 };
    }
    this.filter();
  }

  /** A hole and those that it is joined with, ascending: they are one row, chosen and treated as one. */
  group(id) {
    return [id, ...this.byId.get(id)?.joined ?? []].sort((a, b) => a - b);
  }

  /** The holes that are filled if these are, ascending: with all of their bridges. */
  withBridges(ids) {
    const bridges = this.bridges(), all = ids.flatMap((id) => [id, ...bridges.get(this.doings.get(id)) ?? []]);
    return [...new Set(all)].sort((a, b) => a - b);
  }

  /** The name of the chosen holes if they are filled as one, else their number. */
  chosenName() {
    const ids = this.withBridges([...this.picked]), together = this.bridges().get(this.doings.get(this.chosen)) ?? this.group(this.chosen);
    return ids.length === together.length ? tr("hole_within", { id: ids.join(" + ") }) : counts("hole", ids.length);
  }

  nameOf(hole) {
    return tr(this.isBorder(hole) ? "border_name" : "hole_name", { id: this.group(hole.id).join(" + ") });
  }

  /** The number of a hole in the input file, if it is another one. */
  numberBefore(id) {
    const shift = this.shifts?.findLast(([from]) => from <= id)?.[1];
    return shift ? id + shift : null;
  }

  isBorder(hole) {
    return Boolean(hole.outer_boundary);
  }

  /** The holes that pass the size filter, in the order of the list; of joined ones the first. */
  listed() {
    const bound = (query, none) => {
      const text = find(query).value.trim(), value = numberIn(text), right = !text || Number.isFinite(value) && value >= 0;
      find(query).setAttribute("aria-invalid", !right);
      return text && right ? value : none;
    };
    const low = bound("#wider", 0), high = bound("#narrower", Infinity), { by, falls } = this.sort, sign = falls ? -1 : 1;
    const key = (hole) => by === "doing" ? this.doing(hole.id) : hole[by];
    const order = (a, b) => key(a) < key(b) ? -sign : key(a) > key(b) ? sign : a.id - b.id;
    return this.list.filter((hole) => hole.diameter >= low && hole.diameter <= high && this.group(hole.id)[0] === hole.id).sort(order);
  }

  /** Sorts by a column; a second call reverses the order. */
  sortBy(by) {
    this.sort = { by, falls: this.sort.by === by && !this.sort.falls };
    this.filter();
  }

  filter() {
    const listed = this.listed();
    for (const button of all("#holes-head button")) {
      button.setAttribute("aria-pressed", button.dataset.sort === this.sort.by);
      button.classList.toggle("falls", this.sort.falls);
    }
    find("#holes").replaceChildren(...listed.slice(0, MOST_ROWS).map((hole) => this.row(hole)));
    find("#holes-trouble").textContent = listed.length > MOST_ROWS ? tr("too_many_rows", { count: listed.length, most: MOST_ROWS }) : "";
    find("#holes").dataset.none = tr(this.list.length ? "none_of_size" : "no_holes");
    this.changed();
  }

  /** The row of a hole. */
  row(hole) {
    const item = document.createElement("li"), button = document.createElement("button"), select = document.createElement("select");
    const name = this.nameOf(hole);
    const part = (kind, text) => Object.assign(document.createElement("span"), { className: kind, textContent: text });
    button.type = "button";
    button.className = "hole";
    button.dataset.hole = hole.id;
    button.tabIndex = -1;
    button.append(part("name", hole.id), part("size", digits(hole.diameter)), part("edges", hole.edges));
    const was = this.numberBefore(hole.id), { joined } = hole;
    // Several numbers have no room.
    if (joined.length) button.firstChild.append(Object.assign(document.createElement("small"), { textContent: joined.length > 1 ? ` × ${joined.length + 1}` : ` + ${joined[0]}` }));
    else if (was) button.firstChild.append(Object.assign(document.createElement("small"), { textContent: " " + tr("was_number", { was }) }));
    // A border that is joined is filled with its partner.
    if (this.isBorder(hole) && !hole.joined.length) button.firstChild.append(Object.assign(document.createElement("small"), { textContent: " " + tr("border_short") }));
    button.title = hole.outcome ? `${name}: ${outcomeWords(hole)}` : tr("row_title", { name, height: digits(hole.height, hole.diameter) + this.app.unit() });
    if (hole.joined.length) button.title += " " + tr("row_joined", { ids: hole.joined.join(", ") });
    button.addEventListener("click", (event) => this.choose(hole.id, true, { adds: event.ctrlKey || event.metaKey, range: event.shiftKey }));
    select.setAttribute("aria-label", tr("what_with", { name }));
    select.tabIndex = -1;
    select.addEventListener("change", () => this.set(hole.id, select.value));
    item.append(button, select);
    item.dataset.hole = hole.id;
    return item;
  }

  /** The action that is carried out for a hole: the chosen one, or flat where the preset closes flat what is to be filled. */
  doing(id) {
    const doing = this.doings.get(id) || "fill";
    return doing === "fill" && this.app.steps?.presets.caps ? "flat" : doing;
  }

  /** The bridges, each with its holes. */
  bridges() {
    const groups = new Map();
    for (const [id, doing] of this.doings) if (/^bridge/.test(doing)) groups.set(doing, [...(groups.get(doing) || []), id]);
    return groups;
  }

  /** The name of a bridge that no hole has. */
  freeBridge() {
    const bridges = this.bridges();
    let number = 1;
    while (bridges.has(`bridge ${number}`)) number++;
    return `bridge ${number}`;
  }

  /** Sets the actions for holes, and sends them to the program. */
  put(doings) {
    const { presets } = this.app.steps;
    // One hole that is not to be closed flat: the preset does not hold for all any more.
    if (presets.caps && doings.some(([, doing]) => doing === "fill")) {
      const flat = [...this.doings.keys()].filter((id) => this.doing(id) === "flat" && !doings.some(([other]) => other === id));
      presets.leave("fill");
      doings = [...doings, ...flat.map((id) => [id, "flat"])];
    }
    for (const [id, doing] of doings) this.doings.set(id, doing);
    this.app.choices.holes(this.app.model.state.current, Object.fromEntries(doings));
  }

  /** Sets the action for a hole; if the hole is chosen, for all chosen holes. */
  set(id, doing) {
    const ids = this.picked.has(id) ? [...this.picked] : this.group(id);
    this.put(ids.map((one) => [one, doing]));
    this.changed();
    if (id === this.chosen) this.tell(this.byId.get(id));
  }

  /** Shows size and action of a hole in the message line. */
  tell({ id, diameter, height }) {
    const unit = this.app.unit();
    this.app.say(tr("hole_summary", { id: this.group(id).join(" + "), diameter: digits(diameter) + unit, height: digits(height, diameter) + unit, doing: doingName(this.doing(id)) }));
  }

  /** Adds a hole to the last bridge, or to a first one if there is none. */
  bridge(id) {
    this.set(id, [...this.bridges().keys()].pop() || "bridge 1");
  }

  /** Shows the actions in the rows, the rims and the command line. */
  changed() {
    const numberOf = (name) => Number(name.replace("bridge ", "")), names = [...this.bridges().keys(), this.freeBridge()];
    const offered = [...DOINGS, ...names.sort((a, b) => numberOf(a) - numberOf(b))], offer = offered.join();
    const rows = all("#holes li"), first = rows.find((row) => Number(row.dataset.hole) === this.chosen) || rows[0];
    const unit = this.app.unit();
    for (const item of rows) {
      const id = Number(item.dataset.hole), doing = this.doing(id), shows = [doing, this.picked.has(id), offer, unit, item === first].join();
      // A row that shows the same already is left as it is: with a thousand rows writing all takes longer than drawing the mesh.
      if (this.written.get(item) === shows) continue;
      this.written.set(item, shows);
      const select = item.querySelector("select"), button = item.querySelector(".hole"), hole = this.byId.get(id);
      if ([...select.options].map((option) => option.value).join() !== offer) select.replaceChildren(...offered.map((value) => new Option(doingName(value), value)));
      select.value = doing;
      item.dataset.doing = doing.split(" ")[0];
      item.classList.toggle("picked", this.picked.has(id));
      button.setAttribute("aria-pressed", this.picked.has(id));
      button.tabIndex = item === first ? 0 : -1;
      const name = this.nameOf(hole);
      button.setAttribute("aria-label", tr("row_label", { name, diameter: digits(hole.diameter) + unit, edges: hole.edges, doing: doingName(doing) }));
    }
    find("#fill-all").disabled = Boolean(this.app.steps.job) || !this.canFill();
    const { size } = this.picked;
    find("#fill-chosen").disabled = !size;
    find("#fill-chosen").textContent = size ? tr("fill_chosen", { what: this.chosenName() }) : tr("fill_this");
    this.app.display.rims();
    this.app.steps.describe();
  }

  /** The colour index of each rim of a mesh, and the colours. */
  rimKinds(mesh) {
    const own = mesh.id === this.app.model.state.current, order = ["fill", "open", "flat", "bridge"];
    const kind = (id) => this.picked.size > 1 && this.picked.has(id) ? 4 : Math.max(0, order.indexOf(this.doing(id).split(" ")[0]));
    return { kinds: mesh.rimIds.map((id) => own ? kind(id) : 0), colours: ["bad", "soft", "fair", "second", "mark"] };
  }

  /** The chosen holes, ascending; null if none is chosen. */
  only() {
    return this.picked.size ? [...this.picked].sort((a, b) => a - b) : null;
  }

  /**
   * The parameters of a fill that select holes. With `only`, the bridges of these holes are filled as a whole. Throws an error if a bridge has
   * one hole only or nothing is to be filled.
   */
  params(only) {
    const groups = [...this.bridges().values()];
    if (only) {
      const own = groups.filter((group) => group.length > 1 && group.some((id) => only.includes(id)));
      const holes = this.withBridges(only), flat = holes.filter((id) => this.doing(id) === "flat");
      return { holes, keep_open: [], flat, bridge: own, crease: this.app.creases.params(holes) };
    }
    const crease = this.app.creases.params(null);
    const ids = (doing) => [...this.doings.keys()].filter((id) => this.doing(id) === doing), chosen = (test) => new Set(this.list.filter(test).map((h) => h.id));
    const border = chosen((h) => this.isBorder(h)), stays = chosen((h) => h.stays_open);
    // What stays open by itself is not named: a rim that is kept open joins no other.
    const open = ids("open").filter((id) => !stays.has(id));
    const filled = [...this.doings].filter(([, d]) => d !== "open").map(([id]) => id);
    const alone = [...this.bridges()].find(([, group]) => group.length < 2);
    if (alone) throw new Error(tr("bridge_alone", { bridge: doingName(alone[0]), id: alone[1][0] }));
    if (!this.list.length) throw new Error(tr("nothing_to_fill"));
    if (!filled.length) throw new Error(tr("all_stay_open"));
    // The program leaves an outer border open unless it faces a rim that is filled. Name all holes if it would leave one that is to be
    // filled, or may because another stays open; also if that list is the shorter one.
    const named = filled.some((id) => stays.has(id) || open.length && border.has(id)) || filled.length <= open.length;
    // A hole that is named is filled however wide it is.
    const most = numberIn(this.app.steps.forms.fill?.values().max_diameter ?? ""), wide = chosen((h) => h.diameter > most && this.doing(h.id) === "fill");
    const narrow = named ? filled.filter((id) => !wide.has(id)) : null;
    if (narrow && !narrow.length) throw new Error(tr("all_stay_open"));
    return { holes: narrow, keep_open: named ? [] : open, flat: ids("flat"), bridge: groups, crease };
  }

  /** The holes that a repair closes flat: those set so, and the one in the bottom. */
  caps() {
    const flat = [...this.doings].filter(([, doing]) => doing === "flat").map(([id]) => id);
    return [...flat, ...this.app.bottom.caps()].sort((a, b) => a - b);
  }

  /** The same as options of a repair. */
  capsText() {
    const ids = this.caps();
    return ids.length ? [`--flat ${ids.join(",")}`] : [];
  }

  /** The same parameters as options of the command line. */
  text(only) {
    let params;
    try {
      params = this.params(only);
    } catch (error) {
      return error.message;
    }
    const listed = (flag, ids) => ids.length ? ` ${flag} ${ids.join(",")}` : "";
    const { holes, keep_open: open, flat, bridge, crease } = params, groups = (flag, each) => each.map((ids) => ` ${flag} ${ids.join("+")}`).join("");
    return `--holes ${holes ? holes.join(",") : "all"}${listed("--keep-open", open)}${listed("--flat", flat)}${groups("--bridge", bridge)}${groups("--crease", crease)}`;
  }

  /** Whether any hole is to be filled, and no choice contradicts another. */
  canFill() {
    return this.text().startsWith("--");
  }

  /** Chooses a hole and moves the view there. `adds` adds it to the chosen ones, `range` all holes of the list from the last one to it. */
  choose(any, flies = true, { adds = false, range = false } = {}) {
    const group = this.group(any), [id] = group, hole = this.byId.get(id), { viewer } = this.app, mesh = viewer.sides.after?.mesh, last = this.chosen;
    const ids = this.listed().map((h) => h.id), [from, to] = [ids.indexOf(last), ids.indexOf(id)].sort((a, b) => a - b);
    const takesAway = adds && this.picked.has(id) && this.picked.size > group.length;
    if (!adds && !range) this.picked.clear();
    if (range && hole && from >= 0) for (const one of ids.slice(from, to + 1).flatMap((row) => this.group(row))) this.picked.add(one);
    else for (const one of group) if (takesAway) this.picked.delete(one); else if (hole) this.picked.add(one);
    this.chosen = takesAway ? this.group([...this.picked].pop())[0] : hole ? id : null;
    find(`#holes li[data-hole="${this.chosen}"]`)?.scrollIntoView({ block: "nearest" });
    const rim = mesh && this.chosen !== null ? mesh.rimIds.indexOf(this.chosen) : -1;
    viewer.selected = { region: 0, rim, mesh };
    this.changed();
    viewer.refresh();
    if (!hole) return;
    this.tell(hole);
    if (!flies || rim < 0 || adds || range) return;
    const { diameter } = hole, centre = minus(hole.centre, mesh.centre);
    this.look(hole, mesh, directionTo({ centre, diameter }, mesh.rims[rim]));
  }

  /** Moves the view to a hole, seen along a direction. */
  look({ centre, diameter }, mesh, towards) {
    const { viewer, views } = this.app;
    views.look(minus(centre, mesh.centre), towards, Math.max(0.85 * diameter, 1e-4 * viewer.camera.radius));
  }

  step(by) {
    const ids = this.listed().map((hole) => hole.id), at = ids.indexOf(this.chosen);
    if (ids.length) this.choose(ids[at < 0 ? (by > 0 ? 0 : ids.length - 1) : (at + by + ids.length) % ids.length]);
  }

  /** Highlights the row of a hole and its rim in the view, without drawing the mesh again. */
  hover(id) {
    if (id === this.over) return;
    this.over = id;
    for (const row of all("#holes li.over")) row.classList.remove("over");
    find(`#holes li[data-hole="${this.group(id)[0]}"]`)?.classList.add("over");
    this.drawOver();
  }

  drawOver() {
    find("#over").setAttribute("points", this.onPage(this.over).map((place) => place.map((x) => x.toFixed(1)).join(",")).join(" "));
  }

  /** The places of a hole's rim in the view, in pixels, without those behind the eye; none without a hole. */
  onPage(id) {
    const { viewer } = this.app, mesh = this.app.shown(), rim = mesh?.rims[mesh.rimIds.indexOf(id)] ?? [], pane = viewer.panes().find((p) => p.side === "after"), places = [];
    for (let k = 0; pane && k < rim.length; k += 3) {
      const place = viewer.onPage(rim.subarray(k, k + 3), pane);
      if (place) places.push(place);
    }
    return places;
  }

  /** The number of the hole whose rim or opening is under a point of the view; null if there is none. */
  at({ aim, point }) {
    const { viewer } = this.app, mesh = viewer.sides[aim.side]?.mesh;
    if (!mesh || mesh.id !== this.app.model.state.current) return null;
    const depth = point ? viewer.place(point).depth : Infinity, near = 7 / aim.half;
    let best = null;
    for (const { id, centre, diameter, rim } of mesh.rimHoles ??= rimHoles(mesh, aim.side)) {
      const p = viewer.place(centre), wide = 0.5 * diameter / p.unit;
      if (p.depth <= 0 || Math.hypot(p.x - aim.x, p.y - aim.y) > wide + near) continue;
      const seen = [];
      for (let k = 0; k < rim.length; k += 3) seen.push(viewer.place(rim.subarray(k, k + 3)));
      const polygon = seen.map((q) => [q.x, q.y]), onRim = seen.some((q) => Math.hypot(q.x - aim.x, q.y - aim.y) < near && q.depth < depth + 0.02 * diameter);
      const open = isInside(polygon, aim.x, aim.y) && p.depth < depth + 0.25 * diameter && !(point && p.depth > depth + 0.05 * diameter);
      if ((onRim || open) && (!best || p.depth < best.depth)) best = { id, depth: p.depth };
    }
    return best?.id ?? null;
  }

  /** The hole under a moving pointer. Only holes with a visible number count, since the surface is not picked while the pointer moves. */
  hoveredAt(at) {
    const { viewer, labels } = this.app, id = this.at({ aim: viewer.aim(...at) });
    return labels.items.some((item) => item.hole.id === id && item.seen.after) ? id : null;
  }
}
