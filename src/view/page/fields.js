// The forms of the commands' parameters, made from the tables that the program has of them.

import { numberIn } from "../../report/viewer/controls.js";

export const KINDS = ["fill", "restore", "fair", "repair"];

/** The parameters of a command that stand in its form: holes are chosen in their list. */
const inForm = (row) => row.path.length > 0 && !row.library_only && !["holes", "groups", "pairs"].includes(row.kind);

const valueAt = (params, path) => path.reduce((at, name) => at?.[name], params);

/** Puts a value at a path. */
function putAt(params, path, value) {
  const step = (at, name) => (at[name] && typeof at[name] === "object" ? at[name] : (at[name] = {}));
  path.slice(0, -1).reduce(step, params)[path[path.length - 1]] = value;
}

/** What a field shows of a value. */
function shownValue({ kind, sets }, value) {
  if (kind === "flag") return value === sets;
  if (kind === "voxel") return typeof value === "object" ? value?.length ?? "" : "";
  return value ?? "";
}

/** The form of a command's parameters. */
export class Form {
  constructor(root, kind, rows, defaults) {
    this.kind = kind;
    this.defaults = defaults;
    this.items = rows.filter(inForm).map((row) => this.item(root, row));
  }

  item(root, row) {
    const { kind, path } = row, flag = "--" + row.option, id = this.kind + flag, box = document.createElement("p");
    const label = document.createElement("label"), small = document.createElement("small");
    const input = document.createElement(kind === "choice" ? "select" : "input"), start = shownValue(row, valueAt(this.defaults, path));
    input.id = label.htmlFor = id;
    label.textContent = flag;
    small.textContent = row.sentence.replaceAll("`", "");
    small.title = row.details.replaceAll("`", "");
    small.id = id + "-hint";
    input.setAttribute("aria-describedby", small.id);
    if (kind === "choice") input.append(...row.choices.map(({ name }) => new Option(name, name)));
    else input.type = kind === "flag" ? "checkbox" : "text";
    if (kind !== "flag" && kind !== "choice") {
      input.inputMode = "decimal";
      input.title = row.unit && `in ${row.unit}`;
      input.placeholder = row.usual.replaceAll("`", "");
    }
    if (kind === "flag") input.checked = start;
    else input.value = start;
    box.className = "field " + kind;
    box.append(label, input, small);
    root.append(box);
    return { ...row, flag, input, start };
  }

  /** The parameters; an error names the field that is wrong, and the field is shown. */
  read() {
    const params = structuredClone(this.defaults), given = new Set();
    for (const item of this.items) {
      const { input, kind, path, sets } = item;
      if (kind === "choice") putAt(params, path, input.value);
      else if (kind === "flag") putAt(params, path, input.checked ? sets : !sets);
      else this.readNumber(item, params);
      if (kind === "flag" ? input.checked : input.value.trim()) given.add(item.name);
      if (given.has(item.name) && given.has(item.excludes)) this.refuse(input, `${item.flag} and --${item.excludes.replaceAll("_", "-")} exclude each other`);
    }
    return params;
  }

  readNumber({ input, kind, flag, path, low, high, open, allowed }, params) {
    const text = input.value.trim(), value = numberIn(text), empty = !text || text === "auto";
    const least = open ? value > low : value >= low, most = high === null || (open ? value < high : value <= high);
    const right = empty || Number.isFinite(value) && least && most && (kind !== "whole" || Number.isInteger(value));
    input.setAttribute("aria-invalid", !right);
    if (!right) this.refuse(input, `${flag} must be ${allowed}, or empty for the default`);
    if (!empty) putAt(params, path, kind === "voxel" ? { length: value } : value);
  }

  refuse(input, words) {
    input.setAttribute("aria-invalid", true);
    input.focus();
    throw new Error(words);
  }

  /** Everything as it was. */
  reset() {
    for (const { input, kind, start } of this.items) {
      if (kind === "flag") input.checked = start;
      else input.value = start;
      input.removeAttribute("aria-invalid");
    }
  }

  /** The options that differ from the defaults, as one would type them. */
  typed() {
    return this.items.filter(({ input, kind, start }) => kind === "flag" ? input.checked !== start : String(input.value) !== String(start))
      .map(({ flag, input, kind }) => kind === "flag" ? flag : `${flag} ${input.value.trim().replace(",", ".")}`);
  }
}
