// The tolerance band: distances of the surface from a reference, with a histogram and limits that the user sets.

import { digits, find, numberIn } from "../../report/viewer/controls.js";
import { tr } from "./strings.js";

/** The colourings that have a tolerance band. */
export const BANDED = ["distance", "deviation"];
const BINS = 60;
/** Colours of vertices below, within and above the band, and of vertices that did not move. */
const BAND_COLOURS = { below: [43, 108, 176], within: [76, 160, 96], above: [192, 47, 47], still: [185, 190, 198] };
const BAR = "http://www.w3.org/2000/svg";

export class Band {
  constructor(app) {
    this.app = app;
    this.values = null;
    find("#deviation").addEventListener("click", () => app.attempt("#measure-trouble", async () => {
      app.display.offer();
      if (![...find("#colour").options].some((option) => option.value === "deviation")) throw new Error(tr("no_deviation"));
      await app.display.setColour("deviation");
    }));
    for (const query of ["#band-low", "#band-high"]) find(query).addEventListener("change", () => {
      for (const field of ["#band-low", "#band-high"].map(find)) field.setAttribute("aria-invalid", Boolean(field.value.trim()) && !Number.isFinite(numberIn(field.value)) || this.isInverted());
      if (BANDED.includes(app.display.colour)) app.display.setColour(app.display.colour);
    });
  }

  /** The name of the reference file of deviations; empty for the mesh before the step. */
  get reference() {
    return find("#reference").value.trim();
  }

  /** Whether the lower limit is above the upper one. */
  isInverted() {
    return numberIn(find("#band-low").value) > numberIn(find("#band-high").value);
  }

  /** The limits of the band; null if none is set. */
  limits() {
    const [low, high] = ["#band-low", "#band-high"].map((query) => numberIn(find(query).value));
    if (!Number.isFinite(low) && !Number.isFinite(high) || this.isInverted()) return null;
    return [Number.isFinite(low) ? low : -Infinity, Number.isFinite(high) ? high : Infinity];
  }

  /** Shows the distribution of distances; null clears it. */
  take(values) {
    this.values = values;
    this.draw();
  }

  /** The colour of each vertex: below, within or above the band, or not moved. */
  colours(values) {
    const [low, high] = this.limits(), colours = new Uint8Array(4 * values.length);
    values.forEach((x, i) => colours.set([...BAND_COLOURS[x === 0 || !Number.isFinite(x) ? "still" : x < low ? "below" : x > high ? "above" : "within"], 255], 4 * i));
    return colours;
  }

  /** Draws the histogram, red outside of the band, and the fraction within the band. */
  draw() {
    const { values } = this, svg = find("#histogram"), set = this.limits(), limits = set || [-Infinity, Infinity], format = (x) => this.app.measure.format(x);
    if (!values?.length) {
      svg.replaceChildren();
      find("#band-said").textContent = "";
      return;
    }
    let [least, most, sum, within, count] = [Infinity, -Infinity, 0, 0, 0];
    for (const x of values) {
      // Vertices that the step kept have distance 0 and do not count.
      if (!Number.isFinite(x) || x === 0) continue;
      least = Math.min(least, x);
      most = Math.max(most, x);
      sum += x * x;
      count++;
      if (x >= limits[0] && x <= limits[1]) within++;
    }
    const wide = most - least || 1, bins = new Uint32Array(BINS);
    for (const x of values) if (Number.isFinite(x) && x !== 0) bins[Math.min(BINS - 1, Math.floor((x - least) / wide * BINS))]++;
    const top = Math.max(...bins, 1);
    svg.replaceChildren(...Array.from(bins, (n, i) => {
      const bar = document.createElementNS(BAR, "rect"), middle = least + (i + 0.5) * wide / BINS, high = n ? Math.max(1, 66 * n / top) : 0;
      for (const [name, value] of Object.entries({ x: 5 * i, y: 70 - high, width: 4.4, height: high })) bar.setAttribute(name, value);
      if (middle < limits[0] || middle > limits[1]) bar.setAttribute("class", "out");
      return bar;
    }));
    find("#band-said").textContent = count
      ? tr(set ? "band_said" : "band_unset", { least: format(least), most: format(most), rms: format(Math.sqrt(sum / count)), part: digits(100 * within / count), sigma: format(Math.sqrt(sum / count)) })
      : tr("band_none");
  }
}
