// Which faces of a mesh are at the rims of its holes.

const placeKey = (p, i) => `${p[i]} ${p[i + 1]} ${p[i + 2]}`;

/** The holes by the places of their rim vertices; and the first coordinates of these, which are looked up faster. */
function rimVertices({ rims = [], rimIds }) {
  const ids = new Map(), first = new Set();
  rims.forEach((rim, k) => {
    for (let i = 0; i < rim.length; i += 3) {
      ids.set(placeKey(rim, i), rimIds[k]);
      first.add(rim[i]);
    }
  });
  return { ids, first };
}

/** The numbers of the holes at whose rims a face has a corner. */
export function holesAt(mesh, face) {
  const { positions: p, faces } = mesh, { ids, first } = mesh.rimVertices ??= rimVertices(mesh);
  const hole = (i) => first.has(p[i]) && ids.get(placeKey(p, i));
  return [0, 1, 2].map((k) => hole(3 * faces[3 * face + k])).filter(Boolean);
}
