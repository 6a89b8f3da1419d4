// The full picture of a large mesh, drawn in slices over several frames, so that a click meanwhile is seen soon. Until it is complete, a
// copy of the picture before it covers the canvas.

import { begun } from "./activity.js";

/** Milliseconds that a slice should take. */
const SLICE = 35;

export class Still {
  constructor(viewer) {
    this.viewer = viewer;
    this.cover = Object.assign(document.createElement("canvas"), { hidden: true });
    this.cover.style.cssText = "position:absolute;inset:0;width:100%;height:100%;pointer-events:none";
    viewer.canvas.after(this.cover);
    /** Ends the work of the picture that is being drawn; null if there is none. */
    this.end = null;
  }

  /** Begins the full picture; `cost` is the time in milliseconds that it takes as a whole. */
  begin(cost) {
    const { canvas } = this.viewer, { cover } = this;
    this.drop();
    this.end = begun("frame");
    [cover.width, cover.height] = [canvas.width, canvas.height];
    cover.getContext("2d").drawImage(canvas, 0, 0);
    cover.hidden = false;
    this.slice(0, Math.max(1, Math.ceil(cost / SLICE)));
  }

  /** Draws a slice once the one before it is drawn. */
  slice(at, of) {
    this.next = requestAnimationFrame(() => {
      const { viewer } = this, { gl } = viewer;
      if (gl.isContextLost()) return this.drop();
      if (this.fence && gl.getSyncParameter(this.fence, gl.SYNC_STATUS) !== gl.SIGNALED) return this.slice(at, of);
      if (at === of) return this.drop();
      gl.deleteSync(this.fence);
      viewer.draw(false, null, null, { at, of });
      this.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
      gl.flush();
      return this.slice(at + 1, of);
    });
  }

  /** Shows the canvas, and stops drawing what is not complete. Returns whether a picture was being drawn. */
  drop() {
    if (!this.end) return false;
    cancelAnimationFrame(this.next);
    this.viewer.gl.deleteSync(this.fence ?? null);
    this.fence = null;
    this.cover.hidden = true;
    this.end();
    this.end = null;
    return true;
  }
}

/** The part `at` of `of` equal parts of ranges of faces. */
export function sliceOf(spans, count, { at, of }) {
  const first = Math.floor(count * at / of), end = Math.floor(count * (at + 1) / of), found = [];
  let before = 0;
  for (const [from, to] of spans) {
    const low = Math.max(from, from + first - before), high = Math.min(to, from + end - before);
    if (low < high) found.push([low, high]);
    before += to - from;
  }
  return found;
}
