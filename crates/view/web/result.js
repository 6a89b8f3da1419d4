// The card with the result of the last step: a line, three numbers, and a list of what became of each hole.

import { digits, find, newButton, rising } from "../../report/viewer/controls.js";
import { counterpartLine } from "./like.js";
import { counts, outcomeWords, tr, whole } from "./strings.js";
import { putNumbers, worse } from "./verdict.js";

/** Upper bound of the number of listed holes. */
const LISTED = 300;

/** The commands that concern the holes in the marked region only. */
const ON_REGION = ["restore", "fair"];

/** The number of holes that are closed, left open as asked, and open. A report counts the holes that were not chosen too, but does not list them. */
function outcomesOf({ outcomes, holes = [] }) {
  const of = (outcome) => outcomes?.[outcome] ?? holes.filter((hole) => hole.outcome === outcome).length;
  const [closed, left, open] = ["closed", "left", "open"].map(of);
  return { closed, left, open, all: closed + left + open };
}

/** What a step did, in a line. */
export function stepLine(report) {
  const { closed, left, open, all } = outcomesOf(report), { command } = report, parts = [], steps = report.steps || {};
  const removed = ["dropped", "debris", "inside"].reduce((sum, name) => sum + (steps[`${name}_components`] || 0), 0);
  if (command === "restore") parts.push(tr(open ? "restored_open" : "restored"));
  else if (command === "fair") parts.push(tr("smoothed"));
  else if (all > left) parts.push(tr("closed_of", { closed, all: counts("of_hole", all - left) }));
  else if (!all && !removed && !steps.welded_vertices) parts.push(tr("nothing_open"));
  if (steps.welded_vertices) parts.push(tr("boundary_merged", { count: whole(steps.welded_vertices) }));
  if (removed) parts.push(tr("components_removed", { components: counts("component", removed) }));
  if (open) parts.push(tr("still_open", { open }));
  if (left && !ON_REGION.includes(command)) parts.push(tr("left_of", { left, all: counts("of_hole", all) }));
  for (const { bridge, components, holes } of report.regions || []) if (bridge && components > 1) parts.push(tr("separate_caps", { ids: holes.join(" + ") }));
  if (report.outcomes?.intersecting_patches) parts.push(tr("patches_intersect", { count: report.outcomes.intersecting_patches }));
  // Chains of the input: of a repair the verdict on the result names what is open.
  if (report.open_chains?.length && command !== "repair") parts.push(tr("chains_open", { count: report.open_chains.length }));
  return parts.join(" ");
}

export class Result {
  constructor(app) {
    this.app = app;
    this.closed = new Set();
    /** The number of updates: a check that an earlier one requested is not shown. */
    this.updates = 0;
    find("#result-close").addEventListener("click", () => {
      this.closed.add(app.model.state.current);
      this.update();
    });
    find("#result-open").addEventListener("click", () => {
      this.closed.delete(app.model.state.current);
      this.update();
    });
  }

  /** Shows the result of the step that made the current mesh, unless it was closed. */
  async update() {
    const { current } = this.app.model, { report, standing } = current, number = ++this.updates;
    const waits = !report || this.app.steps.previews.length > 0, isClosed = this.closed.has(current.id);
    find("#result").hidden = waits || isClosed;
    find("#result-open").hidden = waits || !isClosed;
    if (!report) return;
    const level = report.open_chains?.length && report.command === "fill" ? "bad" : standing;
    this.put(level, stepLine(report), report, null);
    this.list(report);
    if (find("#result").hidden) return;
    const found = await this.app.verdict.of(current.id).catch(() => null);
    if (!found || number !== this.updates || this.app.model.current.id !== current.id) return;
    // Of a repair only the mesh that it made is judged, as in the terminal.
    const { level: judged, line } = this.app.verdict.judged(found), isRepair = report.command === "repair", isWhole = found.closed || isRepair;
    this.put(isRepair ? judged : isWhole ? worse(level, judged) : level, isWhole ? `${stepLine(report)} ${line}` : stepLine(report), report, found);
  }

  put(level, line, report, found) {
    const { verdict } = this.app, { largest: error, unknown_percent: part } = report.invented?.expected_error || {}, isKnown = Number.isFinite(error), { closed, left, all } = outcomesOf(report);
    find("#result").dataset.level = level;
    find("#result-line").textContent = line;
    putNumbers(find("#result-numbers"), [
      [all > left ? `${closed} / ${all - left}` : "–", tr("number_closed")],
      [isKnown ? verdict.error(error) : "–", tr("number_error") + (isKnown && part > 0 ? `; ${tr("unknown_on", { part: digits(part) })}` : "")],
      verdict.wallNumber(found?.walls, found ? "–" : "…"),
    ]);
  }

  /** Moves the view to the place of a hole of the step. */
  show(hole) {
    const mesh = this.app.shown();
    if (mesh) this.app.holes.look(hole, mesh, hole.normal);
  }

  /** Lists what became of each hole, those that are open first, with the expected error in the colour of the map; then the notes of the step. */
  list(report) {
    const patches = new Map((report.invented?.patches || []).flatMap((patch) => patch.holes.map((id) => [id, patch])));
    const rank = { open: 0, closed: 1, left: 2 }, concerned = (report.holes || []).filter((hole) => !ON_REGION.includes(report.command) || hole.outcome !== "left");
    // The rims of one patch are one row.
    const rims = (id) => patches.get(id)?.holes ?? [id], holes = concerned.filter(({ id }) => rims(id)[0] === id).sort((a, b) => rank[a.outcome] - rank[b.outcome] || a.id - b.id);
    const list = document.createElement("ul"), high = this.app.model.state.error_high || 1;
    list.append(...holes.slice(0, LISTED).map((hole) => {
      const item = document.createElement("li"), how = newButton(outcomeWords(hole), () => this.show(hole), { className: "link" }), right = document.createElement("span"), error = patches.get(hole.id)?.expected_error?.largest;
      item.className = hole.outcome;
      right.className = "of-error";
      if (Number.isFinite(error)) {
        const swatch = Object.assign(document.createElement("i"), { className: "swatch" });
        swatch.style.background = rising(error / high);
        right.append(swatch, this.app.verdict.error(error));
      }
      // After a cut the holes have other numbers than on the page: its patches are counted.
      item.append(Object.assign(document.createElement("b"), { textContent: ON_REGION.includes(report.command) ? hole.region || "–" : rims(hole.id).join(" + ") }), how, right);
      return item;
    }));
    const after = Object.assign(document.createElement("p"), { className: "hint", textContent: counterpartLine(report) });
    const notes = (report.notes || []).map((note) => Object.assign(document.createElement("p"), { className: "hint", textContent: note }));
    const links = Object.assign(document.createElement("p"), { className: "hint" });
    links.append(this.app.steps.report(this.app.model.current.id));
    find("#summary").replaceChildren(list, after, ...notes, links);
  }
}
