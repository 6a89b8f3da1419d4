// The full picture of a large mesh, drawn in slices over several frames, so that a click meanwhile is seen soon. Until it is complete, a
// copy of the picture before it covers the canvas.

import { begun } from "./activity.js";

/** Milliseconds that a slice should take: a click waits for the one in progress. */
const SLICE = 12;
/** Milliseconds; a slice that was complete later than this after its start makes the next one smaller, one that was complete earlier larger. */
const LATE = 30, EARLY = 20;
/** Least part of the faces in a slice. */
const LEAST = 1 / 128;
/** Milliseconds without slices after a button or key is pressed, so that what it does is drawn first. */
const HELD = 200;

export class Still {
  constructor(viewer) {
    this.viewer = viewer;
    this.cover = Object.assign(document.createElement("canvas"), { hidden: true });
    this.cover.style.cssText = "position:absolute;inset:0;width:100%;height:100%;pointer-events:none";
    viewer.canvas.after(this.cover);
    /** Ends the work of the picture that is being drawn; null if there is none. */
    this.end = null;
    this.heldUntil = 0;
    for (const kind of ["pointerdown", "keydown"]) addEventListener(kind, () => { this.heldUntil = performance.now() + HELD; }, { capture: true, passive: true });
  }

  /** Begins the full picture; `cost` is the time in milliseconds that it takes as a whole. */
  begin(cost) {
    const { canvas } = this.viewer, { cover } = this;
    this.drop();
    this.end = begun("frame");
    [cover.width, cover.height] = [canvas.width, canvas.height];
    cover.getContext("2d").drawImage(canvas, 0, 0);
    cover.hidden = false;
    this.part = Math.min(1, SLICE / cost);
    this.slice(0);
  }

  /** Draws the slice that begins at a fraction of the faces, once the one before it is complete. */
  slice(from) {
    this.next = requestAnimationFrame(() => {
      const { viewer } = this, { gl } = viewer, now = performance.now();
      if (gl.isContextLost()) return this.drop();
      if (this.fence && gl.getSyncParameter(this.fence, gl.SYNC_STATUS) !== gl.SIGNALED) return this.slice(from);
      if (from === 1) return this.drop();
      if (this.fence) this.adapt(now - this.started);
      if (now < this.heldUntil) return this.slice(from);
      const to = from + this.part > 0.999 ? 1 : from + this.part;
      this.started = now;
      viewer.draw(false, null, null, { from, to });
      this.fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
      gl.flush();
      return this.slice(to);
    });
  }

  /** Makes the next slices smaller or larger, by the milliseconds that one took. */
  adapt(took) {
    this.viewer.gl.deleteSync(this.fence);
    this.fence = null;
    if (took > LATE) this.part = Math.max(LEAST, this.part * Math.max(0.5, LATE / took));
    else if (took < EARLY) this.part = Math.min(1, this.part * 1.25);
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

/** The part of ranges of `count` faces between two fractions. */
export function sliceOf(spans, count, { from: low, to: high }) {
  const first = Math.floor(count * low), end = Math.floor(count * high), found = [];
  let before = 0;
  for (const [from, to] of spans) {
    const start = Math.max(from, from + first - before), stop = Math.min(to, from + end - before);
    if (start < stop) found.push([start, stop]);
    before += to - from;
  }
  return found;
}
