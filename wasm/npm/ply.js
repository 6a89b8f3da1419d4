// Meshes as arrays to and from binary PLY files.

const HEAD = (vertices, faces) => `ply
format binary_little_endian 1.0
element vertex ${vertices}
property double x
property double y
property double z
element face ${faces}
property list uchar uint vertex_indices
end_header
`;

/** A mesh as a PLY file: positions and faces are flat arrays with three numbers each. */
export function toPly({ positions, faces }) {
  for (const [name, array] of Object.entries({ positions, faces })) {
    if (!array || array.length % 3) throw new TypeError(`${name} must have three numbers for each ${name === "faces" ? "face" : "vertex"}`);
  }
  const [vertices, triangles] = [positions.length / 3, faces.length / 3];
  const head = new TextEncoder().encode(HEAD(vertices, triangles));
  const bytes = new Uint8Array(head.length + 24 * vertices + 13 * triangles);
  bytes.set(head);
  const view = new DataView(bytes.buffer);
  let at = head.length;
  for (let i = 0; i < positions.length; i++, at += 8) view.setFloat64(at, positions[i], true);
  for (let i = 0; i < faces.length; i++) {
    if (!Number.isInteger(faces[i]) || faces[i] < 0 || faces[i] >= vertices) {
      throw new RangeError(`face ${Math.floor(i / 3)} has the vertex ${faces[i]}, but there are ${vertices}, numbered from 0`);
    }
    if (i % 3 === 0) view.setUint8(at++, 3);
    view.setUint32(at, faces[i], true);
    at += 4;
  }
  return bytes;
}

const SIZES = { char: 1, uchar: 1, short: 2, ushort: 2, int: 4, uint: 4, float: 4, double: 8 };
const READ = {
  char: "getInt8", uchar: "getUint8", short: "getInt16", ushort: "getUint16", int: "getInt32", uint: "getUint32", float: "getFloat32", double: "getFloat64",
};

/** The elements of a header: name, number and properties. */
function elementsOf(lines) {
  const elements = [];
  for (const line of lines) {
    const [word, ...rest] = line.trim().split(/\s+/);
    if (word === "element") elements.push({ name: rest[0], count: Number(rest[1]), properties: [] });
    if (word === "property") elements.at(-1).properties.push({ name: rest.at(-1), types: rest[0] === "list" ? rest.slice(1, 3) : [rest[0]] });
  }
  return elements;
}

/** Positions and faces of a binary PLY file that the program wrote. Other values of vertices and faces are skipped. */
export function fromPly(bytes) {
  const end = "end_header\n";
  const head = new TextDecoder("latin1").decode(bytes.subarray(0, 1 << 16));
  const length = head.indexOf(end) + end.length;
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const mesh = { positions: new Float64Array(), faces: new Uint32Array() };
  let at = length;
  const number = (type) => {
    const value = view[READ[type]](at, true);
    at += SIZES[type];
    return value;
  };
  for (const { name, count, properties } of elementsOf(head.slice(0, length).split("\n"))) {
    if (name === "vertex") mesh.positions = new Float64Array(3 * count);
    if (name === "face") mesh.faces = new Uint32Array(3 * count);
    for (let i = 0; i < count; i++) {
      for (const { name: property, types } of properties) {
        const values = types.length === 1 ? [number(types[0])] : Array.from({ length: number(types[0]) }, () => number(types[1]));
        const axis = ["x", "y", "z"].indexOf(property);
        if (name === "vertex" && axis >= 0) mesh.positions[3 * i + axis] = values[0];
        if (name === "face" && property.startsWith("vertex_ind")) mesh.faces.set(values, 3 * i);
      }
    }
  }
  return mesh;
}
