// Saving and downloading meshes, reports, recipes and masks.

import { copy } from "../../report/viewer/point.js";
import { find } from "../../report/viewer/controls.js";
import { Folder } from "./folder.js";
import { askBlob, askJson } from "./net.js";
import { counts, tr } from "./strings.js";

export class Save {
  constructor(app) {
    this.app = app;
    this.folder = new Folder(app);
    find("#save").addEventListener("click", () => this.save());
    find("#download").addEventListener("click", () => this.download());
    // A name that is typed says the format, and is not the file that was to be replaced.
    find("#save-path").addEventListener("input", () => {
      find("#overwrite").checked = false;
      const typed = /\.([^./]+)$/.exec(find("#save-path").value.trim())?.[1].toLowerCase(), { formats } = this.app.model.state;
      if (find("#save-kind").value === "mesh" && formats.some((f) => f.extension === typed)) find("#save-format").value = typed;
      this.app.deliver?.offerPaint();
    });
    find("#save-path").addEventListener("keydown", (event) => event.key === "Enter" && this.save());
    find("#save-kind").addEventListener("change", () => this.suggest());
    find("#save-format").addEventListener("change", () => this.suggest());
    find("#copy-recipe").addEventListener("click", async () => app.say(tr(await copy(find("#recipe").textContent) ? "recipe_copied" : "copy_by_hand")));
  }

  start({ file, formats }) {
    find("#root").textContent = file.root;
    find("#save-format").replaceChildren(...formats.map((f) => new Option(`${f.name} (.${f.extension})`, f.extension)));
    const own = /\.([^.]+)$/.exec(file.name)?.[1].toLowerCase();
    if (formats.some((f) => f.extension === own)) find("#save-format").value = own;
    this.suggest();
  }

  /** Suggests a file name for the chosen kind of file, in the folder of the present name; a name that was typed only gets another ending. */
  suggest() {
    const kind = find("#save-kind").value, stem = this.app.model.state.file.name.replace(/\.[^.]*$/, "");
    const ends = { mesh: `_mended.${find("#save-format").value}`, report: "_report.html", recipe: "_recipe.sh", mask: "_mask.txt" };
    find("#save-format-label").hidden = kind !== "mesh";
    find("#deliver").hidden = kind === "mask";
    this.app.deliver?.offerPaint();
    const field = find("#save-path"), [, folder, name] = /^(.*?)([^/]*)$/.exec(field.value);
    if (name && name !== this.suggested) {
      field.value = folder + name.replace(/(\.[^.]*)?$/, ends[kind].replace(/^[^.]*/, ""));
    } else {
      this.suggested = stem + ends[kind];
      field.value = folder + this.suggested;
    }
  }

  async save() {
    find("#saved").textContent = "";
    await this.app.attempt("#save-trouble", async () => {
      const kind = find("#save-kind").value, path = find("#save-path").value.trim();
      if (!path) throw new Error(tr("type_name"));
      const { path: where, bytes, patches, piece, files = [], notes = [], warnings = [] } = await this.write(kind, path, find("#overwrite").checked);
      find("#overwrite").checked = false;
      find("#saved").textContent = tr("saved", { where: files.join(", ") || where, bytes: counts("byte", bytes), others: [patches, piece].filter(Boolean).map((name) => `, ${name}`).join("") });
      if (notes.length) find("#saved").textContent += ` ${notes.map((note) => note[0].toUpperCase() + note.slice(1)).join(". ")}.`;
      find("#save-trouble").textContent = warnings.join(" ");
    });
  }

  async write(kind, path, overwrite) {
    const sent = { path, overwrite, kind };
    if (kind === "mask") {
      sent.mask = this.app.marks();
      if (!sent.mask.length) throw new Error(tr("no_mask"));
    } else {
      sent.deliver = this.app.deliver.wanted();
    }
    try {
      return await askJson("save", sent);
    } catch (error) {
      if (error.exists) error.message = tr("exists_already", { name: error.exists });
      throw error;
    }
  }

  /** Saves a file through the browser on the user's computer; returns its name. */
  hand(blob, ending) {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = (this.app.model.state.file.name.replace(/\.[^.]*$/, "") || "view") + ending;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
    return link.download;
  }

  /** Downloads the chosen kind of file to the user's computer instead of saving it in the folder. */
  async download() {
    await this.app.attempt("#save-trouble", async () => {
      find("#saved").textContent = "";
      const kind = find("#save-kind").value, ends = { report: "_report.html", recipe: "_recipe.sh", mask: "_mask.txt" }, { current } = this.app.model.state;
      if (kind === "mesh") return this.downloadMesh(current);
      if (kind === "report") return this.downloaded(this.hand(await askBlob(`report/${current}?${this.app.deliver.query()}`), ends.report));
      const text = kind === "recipe" ? await this.recipeText() : this.maskText();
      return this.downloaded(this.hand(new Blob([text], { type: "text/plain" }), ends[kind]));
    });
  }

  /** Downloads the mesh and the files that are handed over with it. */
  async downloadMesh(current) {
    const extension = find("#save-format").value, { deliver, model } = this.app, wanted = deliver.wanted(), format = model.state.formats.find((f) => f.extension === extension);
    const from = `download/${current}?format=${extension}&${deliver.query()}`, files = [["mesh", extension], ...["patches", "piece"].filter((name) => wanted[name]).map((name) => [name, format[name]])];
    const names = [];
    for (const [file, end] of files) {
      names.push(this.hand(await askBlob(`${from}&file=${file}`), `_mended${file === "mesh" ? "" : "_" + file}.${end}`));
      this.downloaded(names.join(", "));
    }
  }

  /** The recipe as a script; refused if it reads mask files, since a download is one file only. */
  async recipeText() {
    const { shell, masks } = await askJson("recipe?" + this.app.deliver.query());
    if (masks.length) throw new Error(tr("recipe_has_masks"));
    return shell;
  }

  downloaded(name) {
    find("#saved").textContent = tr("downloaded", { name });
  }

  /** The numbers of the marked faces, one per line. */
  maskText() {
    const runs = this.app.marks(), lines = [];
    if (!runs.length) throw new Error(tr("no_mask"));
    for (const [first, end] of runs) for (let f = first; f < end; f++) lines.push(f);
    return lines.join("\n") + "\n";
  }

  /** Shows the recipe: the commands that repeat the session. */
  async recipe() {
    await this.app.attempt("#save-trouble", async () => {
      const { shell } = await askJson("recipe?" + this.app.deliver.query());
      find("#recipe").textContent = shell;
    });
  }
}
