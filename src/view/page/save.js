// Saving: meshes, reports, recipes and masks.

import { copy } from "../../report/viewer/point.js";
import { find } from "../../report/viewer/controls.js";
import { askJson } from "./net.js";

export class Save {
  constructor(app) {
    this.app = app;
    find("#save").addEventListener("click", () => this.save());
    find("#save-path").addEventListener("keydown", (event) => event.key === "Enter" && this.save());
    find("#save-kind").addEventListener("change", () => this.suggest());
    find("#save-format").addEventListener("change", () => this.suggest());
    find("#copy-recipe").addEventListener("click", async () => app.say(await copy(find("#recipe").textContent) ? "The recipe is copied." : "Copy it by hand."));
  }

  start({ file, formats }) {
    find("#root").textContent = file.root;
    find("#save-format").replaceChildren(...formats.map((f) => new Option(`${f.name} (.${f.extension})`, f.extension)));
    const own = /\.([^.]+)$/.exec(file.name)?.[1].toLowerCase();
    if (formats.some((f) => f.extension === own)) find("#save-format").value = own;
    this.suggest();
  }

  /** A name for what is chosen. */
  suggest() {
    const kind = find("#save-kind").value, stem = this.app.model.state.file.name.replace(/\.[^.]*$/, "");
    const ends = { mesh: `_mended.${find("#save-format").value}`, report: "_report.html", recipe: "_recipe.sh", mask: "_mask.txt" };
    find("#save-format-label").hidden = kind !== "mesh";
    find("#save-path").value = stem + ends[kind];
  }

  async save() {
    find("#saved").textContent = "";
    await this.app.attempt("#save-trouble", async () => {
      const kind = find("#save-kind").value, path = find("#save-path").value.trim();
      if (!path) throw new Error("type a file name below the folder named above");
      const { path: where, bytes } = await this.write(kind, path, find("#overwrite").checked);
      find("#saved").textContent = `Saved ${where} (${bytes.toLocaleString("en")} bytes).`;
    });
  }

  async write(kind, path, overwrite) {
    const sent = { path, overwrite, kind };
    if (kind === "mask") {
      sent.mask = this.app.marks();
      if (!sent.mask.length) throw new Error("nothing is marked: there is no mask to save");
    }
    try {
      return await askJson("save", sent);
    } catch (error) {
      if (error.status === 409 && !overwrite) error.message += error.message.includes("replace") ? "" : ". Tick “replace a file that is there” to write over it";
      throw error;
    }
  }

  /** The command lines that redo the session. */
  async recipe() {
    await this.app.attempt("#save-trouble", async () => {
      const { shell } = await askJson("recipe");
      find("#recipe").textContent = shell;
    });
  }
}
