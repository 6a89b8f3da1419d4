// The forms of the commands' parameters, built from the program's tables: name, unit and description of each.

import { find, numberIn } from "../../report/viewer/controls.js";
import { has, tr } from "./strings.js";

export const KINDS = ["fill", "restore", "fair", "repair"];
/** The parameters that are always visible; the others are folded away. */
const FIRST = {
  fill: ["edge_ratio", "max_diameter", "grain"], restore: ["keep_shape", "edge_ratio", "apart", "grain"], fair: ["strength"], repair: ["debris", "wall", "close_borders", "flat_base"],
};
const OWN_UNIT = "the mesh's unit";

/** Whether a parameter belongs to its command's form. Holes and crease ends are chosen in their lists, counterparts in their group. */
const inForm = (row) => row.path.length > 0 && !row.library_only && !["holes", "groups", "pairs", "like"].includes(row.kind);

const valueAt = (params, path) => path.reduce((at, name) => at?.[name], params);

/** Sets the value at a path. */
function putAt(params, path, value) {
  const step = (at, name) => (at[name] && typeof at[name] === "object" ? at[name] : (at[name] = {}));
  path.slice(0, -1).reduce(step, params)[path[path.length - 1]] = value;
}

/** The fields of a row: one, or for a list of words a box for each word. */
const fieldsOf = (row) => (row.kind !== "words" ? [row] : row.choices.map(({ name, sentence }) => ({
  ...row, kind: "word", word: name, name: `${row.name}_${name}`, option: `${row.option} ${name}`, sentence, details: "" })));

/** Whether a field is a box to tick. */
const isBox = ({ kind }) => kind === "flag" || kind === "word";

/** A value as its field shows it. */
function shownValue({ kind, sets, word }, value) {
  if (kind === "word") return value.includes(word);
  if (kind === "flag") return value === sets;
  if (kind === "voxel") return typeof value === "object" ? value?.length ?? "" : "";
  return value ?? "";
}

/** Whether a field holds a number. */
const isNumber = (row) => !isBox(row) && row.kind !== "choice";

/** What is wrong with the number in a field, or nothing. */
function troubleWith({ input, kind, flag, low, high, open, allowed }) {
  const text = input.value.trim(), value = numberIn(text), least = open ? value > low : value >= low, most = high === null || (open ? value < high : value <= high);
  const isRight = !text || text === "auto" || Number.isFinite(value) && least && most && (kind !== "whole" || Number.isInteger(value));
  return isRight ? "" : tr("must_be", { flag, allowed });
}

/** Whether two values of a field are equal; numbers are, with a decimal point as with a comma. */
export function sameValue(a, b) {
  const [x, y] = [a, b].map((value) => numberIn(String(value)));
  return Number.isFinite(x) && Number.isFinite(y) ? x === y : String(a) === String(b);
}

/** The form of a command's parameters. */
export class Form {
  constructor(root, kind, rows, defaults) {
    this.kind = kind;
    this.defaults = defaults;
    this.more = document.createElement("details");
    this.more.append(Object.assign(document.createElement("summary"), { textContent: tr("advanced") }));
    const order = (row) => (FIRST[kind].indexOf(row.name) + 1 || 99), sorted = rows.filter(inForm).flatMap(fieldsOf).sort((a, b) => order(a) - order(b));
    this.items = sorted.map((row) => this.item(FIRST[kind].includes(row.name) ? root : this.more, row));
    root.append(this.more);
  }

  item(root, row) {
    const { kind, path } = row, flag = "--" + row.option, id = this.kind + flag.replace(" ", "-"), box = document.createElement("div");
    const label = document.createElement("label"), small = document.createElement("small"), holder = document.createElement("span");
    const input = document.createElement(kind === "choice" ? "select" : "input"), start = shownValue(row, valueAt(this.defaults, path));
    input.id = label.htmlFor = id;
    label.textContent = has("p_" + row.name) ? tr("p_" + row.name) : flag;
    small.append((has("s_" + row.name) ? tr("s_" + row.name) : row.sentence.replaceAll("`", "")) + " ", Object.assign(document.createElement("code"), { textContent: flag }));
    small.title = row.details.replaceAll("`", "");
    small.id = id + "-hint";
    input.setAttribute("aria-describedby", small.id);
    if (kind === "choice") input.append(...row.choices.map(({ name }) => new Option(has("c_" + name) ? tr("c_" + name) : name, name)));
    else input.type = isBox(row) ? "checkbox" : "text";
    if (isNumber(row)) {
      input.inputMode = "decimal";
      const usual = row.usual.replaceAll("`", "");
      input.placeholder = has("u_" + row.name) ? tr("u_" + row.name) : usual;
      input.title = usual;
    }
    if (isBox(row)) input.checked = start;
    else input.value = start;
    holder.className = "with-unit";
    holder.append(input);
    if (row.unit === OWN_UNIT) holder.append(Object.assign(document.createElement("span"), { className: "unit" }));
    box.className = "field " + (isBox(row) ? "flag" : kind);
    box.append(label, holder, small);
    root.append(box);
    return { ...row, flag, input, start };
  }

  /** Reads the parameters. An error names the invalid field, and the field gets the focus. */
  read() {
    const params = structuredClone(this.defaults), given = new Set();
    for (const item of this.items) {
      const { input, kind, path, sets, word } = item;
      if (kind === "choice") putAt(params, path, input.value);
      else if (kind === "flag") putAt(params, path, input.checked ? sets : !sets);
      else if (kind === "word") putAt(params, path, [...valueAt(params, path).filter((other) => other !== word), ...(input.checked ? [word] : [])]);
      else this.readNumber(item, params);
      if (isBox(item) ? input.checked : input.value.trim()) given.add(item.name);
      if (given.has(item.name) && given.has(item.excludes)) this.refuse(input, tr("exclude", { a: item.flag, b: `--${item.excludes.replaceAll("_", "-")}` }));
    }
    return params;
  }

  readNumber(item, params) {
    const { input, kind, path } = item, trouble = troubleWith(item), value = numberIn(input.value);
    if (trouble) this.refuse(input, trouble);
    input.removeAttribute("aria-invalid");
    if (!Number.isNaN(value)) putAt(params, path, kind === "voxel" ? { length: value } : value);
  }

  /** What is wrong with the value of a field, or nothing; the field is marked. */
  troubleOf(input) {
    const item = this.items.find((other) => other.input === input), trouble = item && isNumber(item) ? troubleWith(item) : "";
    if (item) input.setAttribute("aria-invalid", Boolean(trouble));
    return trouble;
  }

  refuse(input, words) {
    if (this.more.contains(input)) this.more.open = true;
    input.setAttribute("aria-invalid", true);
    input.focus();
    throw new Error(words);
  }

  /** Resets all fields to their defaults. */
  reset() {
    for (const { input, start, ...item } of this.items) {
      if (isBox(item)) input.checked = start;
      else input.value = start;
      input.removeAttribute("aria-invalid");
    }
  }

  /** All values as they stand in the fields, by the names of the parameters. */
  values() {
    return Object.fromEntries(this.items.map(({ name, input, ...item }) => [name, isBox(item) ? input.checked : input.value]));
  }

  /** Sets parameters by their names. */
  put(values) {
    for (const { name, input, ...item } of this.items) {
      if (!(name in values)) continue;
      if (isBox(item)) input.checked = values[name];
      else input.value = values[name];
    }
  }

  /** The options that differ from the defaults, as on the command line. */
  typed() {
    return this.items.filter(({ input, start, ...item }) => isBox(item) ? input.checked !== start : !sameValue(input.value, start))
      .map(({ flag, input, ...item }) => isBox(item) ? flag : `${flag} ${input.value.trim().replace(",", ".")}`);
  }
}

/** Builds the forms of all commands. */
export function formsIn(parameters, defaults) {
  const forms = {};
  for (const kind of KINDS) {
    const box = document.createElement("div");
    box.id = "fields-" + kind;
    find("#fields").append(box);
    forms[kind] = new Form(box, kind, parameters[kind], defaults[kind]);
  }
  return forms;
}
