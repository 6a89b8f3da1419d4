// The group "Patches and unit" of the tab Save: unit, tolerance, mark, files of patches and missing piece; figures of the new surface.

import { all, digits, find, numberIn } from "../../report/viewer/controls.js";
import { askJson } from "./net.js";
import { tr } from "./strings.js";

/** The commands whose steps make patches. */
const PATCHING = ["fill", "restore", "repair"];
/** The controls that need patches; the piece needs a restoration. */
const OF_PATCHES = ["#tolerance", "#mark", "#mark-colour", "#patch-paint", "#patches-file"];
/** Units whose symbol is not the program's name of them. */
const SYMBOLS = { um: "µm" };

/** The symbol of a unit of length. */
export const symbolOf = (unit) => SYMBOLS[unit] || unit || "";

/** Lets all lists of units choose the same one. `changed` is called after a choice. */
export function useUnits(changed) {
  const lists = all(".unit-choice");
  for (const list of lists) {
    list.addEventListener("change", () => {
      for (const other of lists) other.value = list.value;
      changed();
    });
  }
}

/** Chooses a unit in all lists, without keeping it. */
function chooseUnit(unit) {
  for (const list of all(".unit-choice")) list.value = unit;
}

export class Deliver {
  constructor(app) {
    this.app = app;
    this.asked = 0;
    for (const query of [...OF_PATCHES, "#piece-file"]) find(query).addEventListener("change", () => this.changed());
  }

  /** Fills the controls with what was saved last with the current mesh. */
  start({ deliver }) {
    if (!deliver) return;
    if (deliver.unit) chooseUnit(deliver.unit);
    find("#tolerance").value = deliver.tolerance ?? "";
    find("#patches-file").checked = deliver.patches;
    find("#piece-file").checked = deliver.piece;
    find("#patch-paint").value = deliver.paint ?? "";
    const [kind, colour] = (deliver.mark || "").split("=");
    find("#mark").value = kind;
    if (colour) find("#mark-colour").value = "#" + colour;
  }

  /** The command that made the current mesh; undefined for the file itself. */
  get command() {
    return this.app.model.current?.command[0];
  }

  /** Whether the file has paint, and the chosen format keeps it. */
  get keepsPaint() {
    return Boolean(this.app.model.state.file.painted) && find("#save-format").value === "3mf";
  }

  /** Offers the paint of patches where it can be kept. */
  offerPaint() {
    find("#patch-paint-label").hidden = !this.keepsPaint;
  }

  /** What is to be handed over, without what the last step does not make. */
  wanted() {
    const made = (query) => !find(query).disabled, wanted = {}, text = find("#tolerance").value.trim(), tolerance = numberIn(text);
    if (find("#deliver-unit").value) wanted.unit = find("#deliver-unit").value;
    const wrong = Boolean(text) && !(tolerance > 0 && Number.isFinite(tolerance));
    find("#tolerance").setAttribute("aria-invalid", wrong);
    if (wrong && made("#tolerance")) throw new Error(tr("tolerance_positive"));
    if (text && made("#tolerance")) wanted.tolerance = tolerance;
    const mark = find("#mark").value;
    if (mark && made("#mark")) wanted.mark = mark === "hatch" ? mark : `${mark}=${find("#mark-colour").value.slice(1)}`;
    if (find("#patch-paint").value && made("#patch-paint") && this.keepsPaint) wanted.paint = find("#patch-paint").value;
    for (const name of ["patches", "piece"]) if (made(`#${name}-file`) && find(`#${name}-file`).checked) wanted[name] = true;
    return wanted;
  }

  /** The same as a query parameter. */
  query() {
    return "deliver=" + encodeURIComponent(JSON.stringify(this.wanted()));
  }

  /** Enables the controls for what the last step made; if the current mesh is another one, measures its patches. */
  update(fresh) {
    const patches = PATCHING.includes(this.command);
    for (const query of OF_PATCHES) find(query).disabled = !patches;
    find("#piece-file").disabled = this.command !== "restore";
    this.offerPaint();
    find("#deliver-hint").textContent = patches ? "" : tr("no_patches_yet");
    if (fresh) this.changed();
  }

  /** Shows the figures, and the recipe with these options. */
  changed() {
    find("#mark-colour-label").hidden = find("#mark").value !== "colour";
    if (this.app.tab === "save") this.app.save?.recipe();
    return this.app.attempt("#deliver-trouble", () => this.measure());
  }

  async measure() {
    const asked = this.asked += 1, { model } = this.app, put = (panel, legend = "") => {
      find("#deliver-said").textContent = panel;
      find("#scale-said").textContent = legend;
    };
    if (!PATCHING.includes(this.command)) return put("");
    const wanted = this.wanted(), { invented, piece } = await askJson(`deliver/${model.state.current}?${this.query()}`);
    // Another mesh or other values were chosen in the meantime.
    if (asked !== this.asked) return undefined;
    if (invented?.area > 0) {
      const { area, error, within } = this.sentences(invented, wanted.tolerance);
      put([area, error, within].join(" "), [area, within].join(" "));
    } else {
      put(tr("invented_none"));
    }
    const beyond = invented?.beyond_tolerance || [], troubles = [];
    if (beyond.length) troubles.push(this.beyond(beyond));
    if (piece && !piece.made) troubles.push(tr("no_piece", { reason: piece.reason }));
    find("#deliver-trouble").textContent = troubles.join(" ");
    return undefined;
  }

  /** The patches that are not within the tolerance: of a restoration by their own numbers, since the holes had others after the cut. */
  beyond(holes) {
    const { report } = this.app.model.current, patches = new Set((report?.holes || []).filter(({ id }) => holes.includes(id)).map(({ region }) => region));
    return this.command === "restore" ? tr("beyond_patches", { patches: [...patches].join(", ") }) : tr("beyond", { holes: holes.join(", ") });
  }

  /** Area and expected error of the patches, and the share that is within the tolerance. */
  sentences({ area, percent, expected_error: { mean, largest, within_percent: within, unknown_percent: part } }, tolerance) {
    const format = (x, power = 1) => this.app.measure.format(x, power), known = mean !== null;
    const expected = part > 0 ? "expected_in_part" : "expected";
    return {
      area: tr("invented", { area: format(area, 2), percent: digits(percent) }),
      error: known ? tr(expected, { mean: format(mean), largest: format(largest), part: digits(part) }) : tr("expected_unknown"),
      within: tolerance ? tr("within", { part: digits(within), tolerance: format(tolerance) }) : "",
    };
  }
}
