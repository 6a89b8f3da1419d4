// The parameters of the commands, named as on the command line.

const ENERGIES = ["willmore", "curvature-variation"], VARIANTS = ["gauss-newton", "I", "II"], FINISHES = ["auto", "willmore", "none"];

/** A field: where it stands in the parameters, its option, what kind of value it holds, and what it does. */
const field = (path, flag, kind, hint, more = {}) => ({ path: path.split("."), flag, kind, hint, ...more });

/** The solve's fields, at a place in the parameters. */
const solve = (at) => [
  field(at + "voxel", "--voxel", "voxel", "voxel size, a length; empty is automatic"),
  field(at + "energy", "--energy", "choice", "what a patch makes small", { choices: ENERGIES }),
  field(at + "finish", "--finish", "choice", "how patches are finished on their own triangles", { choices: FINISHES }),
  field(at + "variant", "--variant", "choice", "the scheme of the flow's steps", { choices: VARIANTS }),
  field(at + "edge_ratio", "--edge-ratio", "number", "length of the patch's edges over that of the edges round the hole", { low: 0.05, high: 20, usual: "0.7" }),
  field(at + "steps", "--steps", "whole", "most steps of the flow on each grid", { low: 1, usual: "20" }),
  field(at + "time_step", "--time-step", "number", "time step of the flow, in voxels to the fourth power", { low: 0, usual: "straight to rest" }),
];

const FIELDS = {
  fill: [
    field("max_diameter", "--max-diameter", "number", "leave wider holes open", { low: 0, usual: "none" }),
    ...solve(""),
    field("surface", "--surface", "choice", "the mesh with its patches, or the level set alone", { choices: ["stitched", "whole"] }),
  ],
  restore: [
    field("keep_shape", "--keep-shape", "number", "how much of the damaged shape is kept, from 0 to 1", { low: 0, high: 1 }),
    ...solve("fill."),
  ],
  fair: [
    field("extent", "--strength", "strength", "features narrower than this length go", { usual: "eight mean edges" }),
    field("extent", "--time", "time", "or for a time of the flow, in length⁴", { usual: "by the strength" }),
    field("voxel", "--voxel", "voxel", "voxel size, a length; empty is automatic"),
    field("variant", "--variant", "choice", "the scheme of the flow's steps", { choices: VARIANTS }),
    field("edge_ratio", "--edge-ratio", "number", "length of the new edges over that of the mesh's", { low: 0.05, high: 20 }),
  ],
  repair: [
    field("weld", "--weld", "number", "merge vertices of the border that are no farther apart", { low: 0, usual: "the same place" }),
    field("debris", "--debris", "number", "take out components with less than this part of the largest one's area", { low: 0, high: 1, usual: "they stay" }),
    field("drop_inside", "--drop-inside", "flag", "take out components inside another one"),
    field("drop_unused", "--drop-unused", "flag", "drop vertices that no face uses"),
    field("clean", "--keep-duplicates", "not", "leave duplicate vertices and faces"),
    field("orient", "--keep-orientation", "not", "turn no faces over"),
    field("split", "--keep-non-manifold", "not", "leave edges with more than two faces"),
    field("crossings", "--keep-crossings", "not", "leave faces that cross others"),
    field("holes", "--keep-holes", "not", "leave the holes of the mesh open"),
    field("borders", "--close-borders", "flag", "close the outer borders of open sheets too"),
    field("fill.max_diameter", "--max-diameter", "number", "leave wider holes open", { low: 0, usual: "none" }),
    ...solve("fill."),
  ],
};

const valueAt = (params, path) => path.reduce((at, name) => at?.[name], params);

/** What a field shows of a value. */
function shownValue(kind, value) {
  if (kind === "flag") return Boolean(value);
  if (kind === "not") return value === false;
  if (kind === "voxel") return typeof value === "object" ? value?.length ?? "" : "";
  if (kind === "strength" || kind === "time") return typeof value === "object" ? value?.[kind] ?? "" : "";
  return value ?? "";
}

/** The form of a command's parameters. */
class Form {
  constructor(root, kind, defaults) {
    this.kind = kind;
    this.defaults = defaults;
    this.items = FIELDS[kind].filter(({ path }) => path.length === 1 || valueAt(defaults, path.slice(0, -1))).map((field) => this.item(root, field));
  }

  item(root, field) {
    const { flag, hint, kind, choices, usual, path } = field, id = `${this.kind}${flag}`, box = document.createElement("p");
    const label = document.createElement("label"), small = document.createElement("small");
    const input = document.createElement(kind === "choice" ? "select" : "input"), start = shownValue(kind, valueAt(this.defaults, path));
    const checks = kind === "flag" || kind === "not";
    input.id = label.htmlFor = id;
    label.textContent = flag;
    small.textContent = hint;
    small.id = id + "-hint";
    input.setAttribute("aria-describedby", small.id);
    if (kind === "choice") input.append(...choices.map((c) => new Option(c, c)));
    else input.type = checks ? "checkbox" : "text";
    if (!checks && kind !== "choice") {
      input.inputMode = "decimal";
      input.placeholder = kind === "voxel" ? "auto" : usual || "";
    }
    if (checks) input.checked = start;
    else input.value = start;
    box.className = "field " + kind;
    box.append(label, input, small);
    root.append(box);
    return { ...field, input, start };
  }

  /** The parameters; an error names the field that is wrong, and the field is shown. */
  read() {
    const params = structuredClone(this.defaults);
    for (const item of this.items) {
      const { input, kind, path } = item, last = path[path.length - 1], holder = valueAt(params, path.slice(0, -1));
      if (kind === "choice") holder[last] = input.value;
      else if (kind === "flag") holder[last] = input.checked;
      else if (kind === "not") holder[last] = !input.checked;
      else this.readNumber(item, holder, last);
    }
    return params;
  }

  readNumber({ input, kind, flag, path, low = 0, high = Infinity }, holder, last) {
    const usual = valueAt(this.defaults, path) ?? null;
    const text = input.value.trim(), value = numberIn(text), positive = ["voxel", "strength", "time"].includes(kind);
    const within = Number.isFinite(value) && value >= low && value <= high && !(positive && value <= 0);
    const right = !text || text === "auto" || within && (kind !== "whole" || Number.isInteger(value));
    input.setAttribute("aria-invalid", !right);
    if (!right) {
      input.focus();
      const range = high < Infinity ? `from ${low} to ${high}` : positive ? "greater than 0" : `of at least ${low}`;
      throw new Error(`${flag} must be a ${kind === "whole" ? "whole " : ""}number ${range}, or empty for the default`);
    }
    const empty = !text || text === "auto";
    if (kind === "voxel") holder[last] = empty ? "auto" : { length: value };
    else if (positive) { if (!empty) holder[last] = { [kind]: value }; }
    else holder[last] = empty ? usual : value;
  }

  /** Everything as it was. */
  reset() {
    for (const { input, kind, start } of this.items) {
      if (kind === "flag" || kind === "not") input.checked = start;
      else input.value = start;
      input.removeAttribute("aria-invalid");
    }
  }

  /** The options that differ from the defaults, as one would type them. */
  typed() {
    return this.items.filter(({ input, kind, start }) => kind === "flag" || kind === "not" ? input.checked !== start : String(input.value) !== String(start))
      .map(({ flag, input, kind }) => kind === "flag" || kind === "not" ? flag : `${flag} ${input.value.trim().replace(",", ".")}`);
  }
}
