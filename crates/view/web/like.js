// The group "Counterpart": the shape that holes are filled with. Also the switch for texels, and what a report says about counterparts.

import { all, find, number, numberIn } from "../../report/viewer/controls.js";
import { counts, has, tr } from "./strings.js";

/** The commands that offer a counterpart. */
const OFFERING = ["fill", "restore"];
/** The fields of the plane's point and normal. */
const POINT = ["#plane-px", "#plane-py", "#plane-pz"], NORMAL = ["#plane-nx", "#plane-ny", "#plane-nz"];
/** The formats that can hold texels of patches. */
const WITH_TEXELS = ["obj", "gltf", "glb"];

/** A word as a shell reads it. */
const quoted = (word) => /^[\w./:,=+@%-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`;

/** The regions of a report that were to be filled with the shape of a counterpart. */
const tested = (report) => (report?.regions || []).filter((region) => region.counterpart);

/** What a report says about counterparts, in a line; empty without one. */
export function counterpartLine(report) {
  const regions = tested(report), used = regions.filter((r) => r.counterpart.used), holes = (list) => list.flatMap((r) => r.holes);
  if (!regions.length) return "";
  const causes = [...new Set(regions.filter((r) => !r.counterpart.used).map((r) => r.counterpart.cause))];
  const refused = causes.map((cause) => {
    const of = regions.filter((r) => !r.counterpart.used && r.counterpart.cause === cause), name = "like_cause_" + cause;
    const numbers = holes(of).join(", "), count = holes(of).length;
    return tr("like_refused", { holes: tr(count === 1 ? "hole_of_number" : "holes_of_numbers", { numbers }), reason: has(name) ? tr(name) : of[0].counterpart.reason });
  });
  return [tr("like_used", { used: holes(used).length, holes: counts("hole", holes(regions).length) }), ...refused].join(" ");
}

/** The mirror plane of a report: point and normal, of a hole for which it was used if there is one; null without one. */
export function planeOf(report) {
  const regions = tested(report).filter((r) => r.counterpart.plane), found = regions.find((r) => r.counterpart.used) || regions[0];
  return found ? found.counterpart.plane : null;
}

export class Like {
  constructor(app) {
    this.app = app;
    this.paths = {};
    find("#like-kind").addEventListener("change", () => this.changed());
    for (const query of [...POINT, ...NORMAL]) find(query).addEventListener("input", () => this.app.plane.show());
    for (const button of all("[data-across]")) button.addEventListener("click", () => this.across(Number(button.dataset.across)));
    find("#like-file").addEventListener("focus", () => app.save.folder.list().catch(() => null));
    find("#like-take").addEventListener("click", () => this.take());
    find("#like").addEventListener("toggle", () => { this.reveal(); app.plane.show(); });
  }

  /** Reads from the program's parameters where the counterpart has its place in a command's parameters. */
  start(parameters) {
    for (const kind of OFFERING) {
      const path = (name) => parameters[kind].find((row) => row.name === name).path;
      this.paths[kind] = path("like");
    }
    this.changed();
  }

  get kind() {
    return find("#like-kind").value;
  }

  /** Moves the group into the form of a command, or hides it. */
  show(kind) {
    const group = find("#like-group"), offered = OFFERING.includes(kind), { texture, file } = this.app.model.state;
    group.hidden = !offered;
    if (offered) find(`#fields-${kind} > details`).before(group);
    find("#texels-field").hidden = !texture || !WITH_TEXELS.includes(file.format);
    this.app.plane.show();
  }

  /** Shows the fields of the chosen kind of counterpart. */
  changed() {
    const { kind } = this;
    if (kind === "plane" && !this.plane()) this.put(planeOf(this.report()) || this.middle(0));
    find("#like-plane").hidden = kind !== "plane";
    find("#like-template").hidden = kind !== "file";
    find("#like-hint").textContent = tr("like_hint_" + (kind || "none"));
    this.reveal();
    this.app.plane.show();
    this.app.steps.describe();
  }

  /** Scrolls the open group into view. */
  reveal() {
    if (this.app.showsJob() && find("#like").open) find("#like").scrollIntoView({ block: "nearest" });
  }

  /** Chooses no counterpart, and texels. */
  reset() {
    find("#like-kind").value = "";
    find("#texels").checked = true;
    this.changed();
  }

  /** The plane in the fields: point and normal; null if a number is missing or the normal is zero. */
  plane() {
    const [point, normal] = [POINT, NORMAL].map((fields) => fields.map((query) => numberIn(find(query).value)));
    return [...point, ...normal].every(Number.isFinite) && Math.hypot(...normal) > 0 ? [point, normal] : null;
  }

  /** The plane across an axis through the middle of the mesh. */
  middle(axis) {
    const [low, high] = this.app.model.state.bounds;
    return [low.map((x, k) => (x + high[k]) / 2), [0, 1, 2].map((k) => Number(k === axis))];
  }

  across(axis) {
    this.put(this.middle(axis));
    this.app.plane.show();
    this.app.steps.describe();
  }

  /** Fills in the fields of a plane, rounded to about a hundred-thousandth of the mesh's size. */
  put([point, normal]) {
    const size = this.app.model.state.scene.radius, places = Math.min(15, Math.max(0, 5 - Math.floor(Math.log10(size || 1))));
    const put = (fields, values, digits) => fields.forEach((query, k) => {
      find(query).value = number(Number(values[k].toFixed(digits)) + 0, { maximumFractionDigits: digits, useGrouping: false });
      find(query).removeAttribute("aria-invalid");
    });
    put(POINT, point, places);
    put(NORMAL, normal, 6);
  }

  /** The counterpart as the option `--like` has it; null without one. An error names what is missing, and its field gets the focus. */
  value() {
    const { kind } = this;
    if (kind === "plane") {
      const wrong = [...POINT, ...NORMAL].filter((query) => !Number.isFinite(numberIn(find(query).value)));
      for (const query of [...POINT, ...NORMAL]) find(query).setAttribute("aria-invalid", wrong.includes(query));
      if (wrong.length) this.refuse(wrong[0], "plane_numbers");
      if (!this.plane()) this.refuse(NORMAL[0], "plane_zero");
    }
    if (kind === "file" && !find("#like-file").value.trim()) this.refuse("#like-file", "name_template");
    return this.text();
  }

  /** The same without checks. */
  text() {
    const { kind } = this, file = find("#like-file").value.trim();
    if (kind === "plane") return "mirror:" + [...POINT, ...NORMAL].map((query) => find(query).value.trim().replace(",", ".")).join(",");
    if (kind === "file") return file.startsWith("mirror") ? "./" + file : file;
    return kind || null;
  }

  refuse(query, words) {
    find("#like").open = true;
    find(query).focus();
    throw new Error(tr(words));
  }

  /** Puts the counterpart into a command's parameters. */
  read(kind, params) {
    if (!this.paths[kind]) return;
    const path = [...this.paths[kind]], last = path.pop();
    path.reduce((at, name) => at[name], params)[last] = this.value();
  }

  /** Whether patches of a command get no texels of their own. */
  noTexture(kind) {
    return OFFERING.includes(kind) && !find("#texels-field").hidden && !find("#texels").checked;
  }

  /** The options as on the command line. */
  typed(kind) {
    if (!OFFERING.includes(kind)) return [];
    const text = this.text();
    return [text && `--like ${quoted(text)}`, this.noTexture(kind) && "--no-texture"].filter(Boolean);
  }

  /** The report of the last preview, or of the step that made the current mesh. */
  report() {
    const { steps, model } = this.app, preview = steps?.previews[steps.previews.length - 1];
    return (preview && model.find(preview.id) || model.current)?.report;
  }

  /** Shows what the last run says about counterparts, and the plane that it found. */
  update() {
    const report = this.report(), said = counterpartLine(report), isNew = said && said !== find("#like-said").textContent;
    find("#like-said").textContent = said;
    find("#like-take").hidden = !planeOf(report);
    if (isNew) this.reveal();
    this.app.plane.show();
  }

  /** The plane that the last run found, while it is the searched one; else null. */
  found() {
    return this.kind === "mirror" ? planeOf(this.report()) : null;
  }

  /** Makes the plane that was found the given one. */
  take() {
    const plane = planeOf(this.report());
    if (!plane) return;
    this.put(plane);
    find("#like-kind").value = "plane";
    this.changed();
    find("#like-kind").focus();
    this.app.say(tr("plane_taken"));
  }
}
