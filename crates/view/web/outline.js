// The outline of a section: the intersection of a plane with the mesh as polylines; their length, area and SVG.

import { cross, dot, minus, times } from "../../report/viewer/camera.js";

/** The polylines in which a plane (normal and distance) intersects a mesh: the points of each, and whether it is closed. */
export function sectionLines({ mesh: { positions: p }, corners }, [x, y, z, w]) {
  const ends = new Map(), next = new Map();
  const side = (v) => x * p[3 * v] + y * p[3 * v + 1] + z * p[3 * v + 2] - w >= 0;
  // The intersection with an edge, the same for both of its faces.
  const met = (a, b) => {
    const [low, high] = a < b ? [a, b] : [b, a], key = low * (p.length / 3) + high;
    if (!ends.has(key)) {
      const at = (v) => [p[3 * v], p[3 * v + 1], p[3 * v + 2]], from = at(low), to = at(high), d = dot([x, y, z], from) - w, e = dot([x, y, z], to) - w;
      ends.set(key, from.map((value, k) => value + (to[k] - value) * d / (d - e)));
    }
    return key;
  };
  for (let f = 0; f < corners.length; f += 3) {
    const sides = [0, 1, 2].map((k) => side(corners[f + k]));
    if (sides[0] === sides[1] && sides[1] === sides[2]) continue;
    let from = null, to = null;
    for (let k = 0; k < 3; k++) {
      const a = k, b = (k + 1) % 3;
      if (sides[a] && !sides[b]) from = met(corners[f + a], corners[f + b]);
      if (!sides[a] && sides[b]) to = met(corners[f + a], corners[f + b]);
    }
    if (!next.has(from)) next.set(from, []);
    next.get(from).push(to);
  }
  const lines = [], reached = new Set([...next.values()].flat());
  // Open lines start at points where no other line ends.
  for (const start of [...[...next.keys()].filter((key) => !reached.has(key)), ...next.keys()]) {
    while (next.get(start)?.length) {
      const points = [ends.get(start)];
      let at = next.get(start).pop();
      while (at !== start && next.get(at)?.length) {
        points.push(ends.get(at));
        at = next.get(at).pop();
      }
      if (at !== start) points.push(ends.get(at));
      lines.push({ points, closed: at === start });
    }
  }
  return lines;
}

/** Two perpendicular directions in a plane: right and up. */
export function planeAxes(normal) {
  const up = Math.abs(normal[2]) > 0.9 ? [0, 1, 0] : [0, 0, 1], right = cross(up, normal), size = Math.hypot(...right) || 1;
  const across = times(right, 1 / size);
  return [across, cross(normal, across)];
}

/** The total length of the lines, and the area inside the closed ones. */
export function lineSizes(lines, [right, up]) {
  let length = 0, area = 0;
  for (const { points, closed } of lines) {
    for (let i = 0; i < points.length - (closed ? 0 : 1); i++) {
      const a = points[i], b = points[(i + 1) % points.length];
      length += Math.hypot(...minus(b, a));
      if (closed) area += (dot(a, right) * dot(b, up) - dot(b, right) * dot(a, up)) / 2;
    }
  }
  return { length, area: Math.abs(area) };
}

/** The lines as an SVG drawing, with the unit of length if SVG knows it. */
export function svgOf(lines, [right, up], unit) {
  const flat = lines.map(({ points, closed }) => ({ closed, points: points.map((p) => [dot(p, right), -dot(p, up)]) }));
  const all = flat.flatMap(({ points }) => points), low = [Infinity, Infinity], high = [-Infinity, -Infinity];
  for (const point of all) for (const k of [0, 1]) {
    low[k] = Math.min(low[k], point[k]);
    high[k] = Math.max(high[k], point[k]);
  }
  const size = [0, 1].map((k) => high[k] - low[k] || 1), known = ["mm", "cm", "in"].includes(unit) ? unit : "", number = (v) => Number(v.toPrecision(7));
  const path = flat.map(({ points, closed }) => "M" + points.map((p) => p.map(number).join(",")).join("L") + (closed ? "Z" : "")).join("");
  return `<svg xmlns="http://www.w3.org/2000/svg" width="${number(size[0])}${known}" height="${number(size[1])}${known}" ` +
    `viewBox="${[...low, ...size].map(number).join(" ")}"><path d="${path}" fill="none" stroke="black" stroke-width="${number(Math.max(...size) / 800)}"/></svg>\n`;
}
