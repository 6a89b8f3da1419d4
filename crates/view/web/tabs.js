// Other tabs of the browser with the same page: they share steps, choices and masks. Each says when another one is opened, and when the mesh
// is changed in another one.

import { isPending } from "../../report/viewer/activity.js";
import { tr } from "./strings.js";

export class Tabs {
  constructor(app) {
    this.app = app;
    const channel = new BroadcastChannel("isomend" + location.pathname);
    channel.addEventListener("message", ({ data }) => {
      if (data === "opened") channel.postMessage("open");
      app.say(tr("other_tab"));
    });
    channel.postMessage("opened");
  }

  /** Shows the state that the program has announced, and says so if another tab has changed it: this one has sent nothing. */
  async changed() {
    const { app } = this, before = app.model.state.current, isOwn = isPending("request");
    await app.refresh();
    if (!isOwn && app.model.state.current !== before) app.say(tr("changed_in_other_tab", { label: app.steps.labelOf(app.model.current) }));
  }
}
