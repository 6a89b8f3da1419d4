// Presets of the commands: each sets several parameters. A command's first preset is the one that the page begins with.

import { find } from "../../report/viewer/controls.js";
import { sameValue } from "./fields.js";
import { tr } from "./strings.js";

/**
 * The presets of each command. `set` holds values of parameters, `edges` lengths in mean edges of the mesh; `capped` closes every
 * hole flat that is to be filled.
 */
const PRESETS = {
  fill: [{ name: "continue" }, { name: "cap", capped: true }, { name: "draft", set: { finish: "none" } }],
  restore: [{ name: "renew" }, { name: "keep", set: { keep_shape: 0.5 } }, { name: "tight", set: { energy: "curvature-variation" } }],
  fair: [{ name: "smooth" }, { name: "fine", edges: { strength: 3 } }, { name: "strong", edges: { strength: 20 } }],
  repair: [{ name: "print", set: { close_borders: true, drop_inside: true } }, { name: "sound" }, { name: "solid", set: { solid: true } }, { name: "block", set: { flat_base: true } }],
};

/** The preset that stands for a command's defaults: it sets nothing. */
const plainOf = (kind) => PRESETS[kind].find(({ set, edges, capped }) => !set && !edges && !capped);

export class Presets {
  /** `taken` is called after a preset was chosen. */
  constructor(app, taken) {
    this.app = app;
    this.taken = taken;
    /** Whether the mesh is loaded; some presets need its mean edge. */
    this.ready = false;
    this.chosen = Object.fromEntries(Object.entries(PRESETS).map(([kind, [first]]) => [kind, first]));
  }

  /** Sets the parameters of the presets that the page begins with. */
  start() {
    for (const [kind, { set = {} }] of Object.entries(this.chosen)) this.app.steps.forms[kind].put(set);
  }

  /** Enables the presets, once the mesh is loaded. */
  enable() {
    this.ready = true;
    this.show(this.app.steps.kind);
  }

  /** Shows the presets of a command. */
  show(kind) {
    find("#presets").replaceChildren(...PRESETS[kind].map((preset) => this.pill(kind, preset)));
    find("#preset-hint").textContent = tr("preset_" + this.chosen[kind].name + "_hint");
  }

  /** Chooses a preset by its name, without changing parameters. */
  choose(kind, name) {
    this.chosen[kind] = PRESETS[kind].find((preset) => preset.name === name) || this.chosen[kind];
  }

  pill(kind, preset) {
    const label = document.createElement("label"), input = document.createElement("input"), name = document.createElement("span");
    input.type = "radio";
    input.name = "preset";
    input.value = preset.name;
    input.checked = this.chosen[kind] === preset;
    input.disabled = !this.ready;
    name.textContent = tr("preset_" + preset.name);
    label.title = tr("preset_" + preset.name + "_hint");
    input.addEventListener("change", () => this.take(kind, preset));
    label.append(input, name);
    return label;
  }

  /** Sets the parameters of a preset, and all others to their defaults. */
  take(kind, preset) {
    const form = this.app.steps.forms[kind], edge = preset.edges ? this.app.meanEdge() : 0, set = { ...preset.set };
    for (const [name, edges] of Object.entries(preset.edges || {})) set[name] = Number((edges * edge).toPrecision(3));
    this.chosen[kind] = preset;
    find("#preset-hint").textContent = tr("preset_" + preset.name + "_hint");
    form.reset();
    form.put(set);
    if (kind === "repair") this.app.verdict.share();
    if (kind === "repair") this.app.bottom.wanted = preset.name === "print";
    if (kind === "fill" || kind === "restore") this.app.like.reset();
    this.changed(kind);
  }

  /** Updates the page after another preset of a command is chosen. */
  changed(kind) {
    if (kind === "fill") this.app.holes.changed();
    this.taken();
  }

  /** Whether the chosen preset of a fill closes holes flat. */
  get caps() {
    return Boolean(this.chosen.fill.capped);
  }

  /** What a command would run with: the name of the preset, and the values of the form. */
  settings(kind) {
    return { kind, preset: this.chosen[kind].name, values: this.app.steps.forms[kind].values() };
  }

  /** Sets what [settings] returned. */
  restore({ kind, preset, values }) {
    this.choose(kind, preset);
    this.app.steps.forms[kind].put(values);
    if (kind === "repair") this.app.verdict.share();
    if (this.app.steps.kind === kind) this.show(kind);
    this.changed(kind);
  }

  /** Selects the preset of a command's defaults if a value that the chosen one sets has been changed. */
  follow(kind) {
    const { set = {} } = this.chosen[kind], values = this.app.steps.forms[kind].values();
    if (Object.entries(set).some(([name, value]) => !sameValue(values[name], value))) this.leave(kind);
  }

  /** Resets a command to its defaults. */
  reset(kind) {
    this.take(kind, plainOf(kind));
    this.leave(kind);
  }

  /** Selects the preset of a command's defaults without changing parameters. */
  leave(kind) {
    this.chosen[kind] = plainOf(kind);
    if (this.app.steps.kind === kind) this.show(kind);
  }
}
