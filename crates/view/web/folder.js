// The folder of the files: its meshes as suggestions, new folders.

import { find } from "../../report/viewer/controls.js";
import { askJson } from "./net.js";
import { tr } from "./strings.js";

export class Folder {
  constructor(app) {
    this.app = app;
    find("#folder-new").addEventListener("click", () => this.ask(find("#folder-row").hidden));
    find("#folder-make").addEventListener("click", () => this.make());
    find("#folder-name").addEventListener("keydown", (event) => {
      if (event.key === "Enter") this.make();
      if (event.key === "Escape") this.ask(false);
    });
  }

  /** Lists the meshes in the folder as suggestions. */
  async list() {
    const { files } = await askJson("files");
    find("#files").replaceChildren(...files.map((name) => new Option(name, name)));
  }

  /** Shows or hides the field for the name of a new folder. */
  ask(shown) {
    find("#folder-row").hidden = !shown;
    find("#folder-new").setAttribute("aria-expanded", shown);
    find(shown ? "#folder-name" : "#folder-new").focus();
  }

  /** Makes a folder, and suggests to save in it. */
  make() {
    find("#saved").textContent = "";
    return this.app.attempt("#save-trouble", async () => {
      const name = find("#folder-name").value.trim();
      if (!name) throw new Error(tr("type_folder"));
      const { path } = await askJson("folder", { path: name });
      find("#save-path").value = `${path.replaceAll("\\", "/")}/${find("#save-path").value.replace(/^.*\//, "")}`;
      find("#folder-name").value = "";
      this.ask(false);
      find("#saved").textContent = tr("folder_made", { path });
    });
  }
}
