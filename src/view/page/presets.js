// The tasks in plain words: each sets parameters of a command. The first of a command is its defaults.

import { find } from "../../report/viewer/controls.js";
import { tr } from "./strings.js";

/** For each command its presets: values of parameters by their names; `edges` is a length in mean edges of the mesh; `capped` closes every hole flat. */
const PRESETS = {
  fill: [{ name: "continue" }, { name: "cap", capped: true }, { name: "draft", set: { finish: "none" } }],
  restore: [{ name: "renew" }, { name: "keep", set: { keep_shape: 0.5 } }, { name: "tight", set: { energy: "curvature-variation" } }],
  fair: [{ name: "smooth" }, { name: "fine", edges: { strength: 3 } }, { name: "strong", edges: { strength: 20 } }],
  repair: [{ name: "sound" }, { name: "print", set: { close_borders: true, drop_inside: true } }, { name: "block", set: { flat_base: true } }],
};

export class Presets {
  /** `taken` is called when one was chosen. */
  constructor(app, taken) {
    this.app = app;
    this.taken = taken;
    /** Whether the mesh is there, which some presets take lengths from. */
    this.ready = false;
    this.chosen = Object.fromEntries(Object.entries(PRESETS).map(([kind, [first]]) => [kind, first]));
  }

  /** Lets presets be chosen, once the mesh is there. */
  enable() {
    this.ready = true;
    this.show(this.app.steps.kind);
  }

  /** Shows those of a command. */
  show(kind) {
    find("#presets").replaceChildren(...PRESETS[kind].map((preset) => this.card(kind, preset)));
  }

  card(kind, preset) {
    const label = document.createElement("label"), input = document.createElement("input"), name = document.createElement("b"), hint = document.createElement("small");
    input.type = "radio";
    input.name = "preset";
    input.value = preset.name;
    input.checked = this.chosen[kind] === preset;
    input.disabled = !this.ready;
    name.textContent = tr("preset_" + preset.name);
    hint.textContent = tr("preset_" + preset.name + "_hint");
    input.addEventListener("change", () => this.take(kind, preset));
    label.append(input, name, hint);
    return label;
  }

  /** Sets the parameters of a preset, and those that it does not name to their defaults. */
  take(kind, preset) {
    const form = this.app.steps.forms[kind], edge = preset.edges ? this.app.meanEdge() : 0, set = { ...preset.set };
    for (const [name, edges] of Object.entries(preset.edges || {})) set[name] = Number((edges * edge).toPrecision(3));
    this.chosen[kind] = preset;
    form.reset();
    form.put(set);
    if (kind === "fill") this.app.holes.cap(Boolean(preset.capped));
    this.taken();
  }

  /** The defaults of a command. */
  reset(kind) {
    this.take(kind, PRESETS[kind][0]);
    this.leave(kind);
  }

  /** Chooses the first preset of a command without setting its parameters. */
  leave(kind) {
    this.chosen[kind] = PRESETS[kind][0];
    if (this.app.steps.kind === kind) this.show(kind);
  }
}
