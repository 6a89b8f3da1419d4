"""Make the seeds of the fuzz targets: small files of every format, in fuzz/corpus/TARGET.

    cargo build --release && python3 scripts/fuzz_seeds.py [--isomend PROGRAM] [FOLDER]

Some files are made here; isomend converts them to every format that it writes. The output is the same on every run. It needs
only Python."""

import argparse
import base64
import json
import lzma
import random
import struct
import subprocess
import tempfile
import zlib
from math import cos, pi, sin
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
FORMATS = ["ply", "obj", "stl", "gltf", "glb", "vtk", "vtp", "off", "3mf", "usda", "usdz"]
TEXT = ["ply", "stl", "vtk"]


# --- meshes ---------------------------------------------------------------------------------------------------------


def bowl(rings=3, around=6):
    """A ball without its top: points and faces."""
    points, faces = [(0.0, 0.0, -1.0)], []
    for ring in range(1, rings + 1):
        latitude = pi * (ring / (rings + 1.5) - 0.5)
        for i in range(around):
            angle = 2 * pi * (i + 0.5 * ring) / around
            points.append((cos(angle) * cos(latitude), sin(angle) * cos(latitude), sin(latitude)))
    at = lambda ring, i: 1 + (ring - 1) * around + i % around
    faces += [(0, at(1, i + 1), at(1, i)) for i in range(around)]
    for ring in range(1, rings):
        for i in range(around):
            a, b, c, d = at(ring, i), at(ring, i + 1), at(ring + 1, i), at(ring + 1, i + 1)
            faces += [(a, b, c), (b, d, c)]
    return points, faces


def ply():
    """A coloured bowl with normals, texture coordinates, a further value on each vertex, and a number on each face."""
    points, faces = bowl()
    names = "x y z nx ny nz s t".split()
    lines = ["ply", "format ascii 1.0", "comment TextureFile skin.png", f"element vertex {len(points)}"]
    lines += [f"property float {n}" for n in names] + [f"property uchar {n}" for n in ("red", "green", "blue")]
    lines += ["property double heat", f"element face {len(faces)}", "property list uchar int vertex_indices"]
    lines += ["property short part", "end_header"]
    number = lambda v: repr(struct.unpack("<f", struct.pack("<f", v))[0])
    for i, p in enumerate(points):
        values = [*p, *p, (p[0] + 1) / 2, (p[1] + 1) / 2]
        lines.append(" ".join([*map(number, values), f"{i} {3 * i} {255 - i}", repr(p[0] / 3)]))
    lines += [f"3 {a} {b} {c} {i % 3}" for i, (a, b, c) in enumerate(faces)]
    return "\n".join(lines) + "\n"


def ply_lists():
    """A big-endian PLY with a polygon, lists of other types, texture coordinates of corners, and an element that isomend does not read."""
    head = ("ply\nformat binary_big_endian 1.0\nelement vertex 5\nproperty double x\nproperty double y\nproperty double z\n"
            "element face 2\nproperty list uchar uint vertex_indices\nproperty list uchar float texcoord\n"
            "element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header\n").encode()
    body = b"".join(struct.pack(">3d", *p) for p in ((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 0.5, 1)))
    for face in ((0, 1, 2, 3), (0, 1, 4)):
        body += struct.pack(f">B{len(face)}I", len(face), *face)
        body += struct.pack(f">B{2 * len(face)}f", 2 * len(face), *[0.125 * v for v in range(2 * len(face))])
    return head + body + struct.pack(">2i", 0, 4)


PLY_STRIPS = """ply
format ascii 1.0
element vertex 5
property float x
property float y
property float z
element tristrips 1
property list int int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
1 1 0
0 2 0
7 0 1 2 3 -1 2 4
"""

OBJ = """mtllib skin.mtl other.mtl
o box
v 0 0 0 1 0.5 0.25
v 1 0 0 1 0.5 0.25
v 1 1 0 1 0 0
v 0 1 0 0 0 1
v 0 0 1.5e0
v -1 0.25 \\
  .5
vt 0 0
vt 1 0
vt 0.5 1
vn 0 0 1
vn 0 0 -1
s 1
g low left
usemtl red
f 1/1/1 2/2/1 3/3/1 4/1/1
usemtl blue
g high
f -6//2 -5//2 -2//2
f 1 2 5 # no more
l 1 2 3
p 4
f 2/2 3/3 5/1
f 1 4 6
newmtl red
Kd 1 0.5 0.25
d 0.5
Ns 30
map_Kd -s 1 1 1 skin.png
newmtl blue
Tr 0.25
Pr 0.5
Pm 1
"""

STL = """solid two
facet normal 0 0 1
outer loop
vertex 0 0 0
vertex 1 0 0
vertex 0 1 0
endloop
endfacet
facet normal 0 0 1
  outer loop
    vertex 1 0 0
    vertex 1 1e0 0
    vertex 0 1 0
  endloop
endfacet
endsolid two
"""


# --- VTK ------------------------------------------------------------------------------------------------------------

VTK_POLYGONS = """# vtk DataFile Version 3.0
two kinds of cells
ASCII
DATASET POLYDATA
POINTS 6 float
0 0 0 1 0 0 1 1 0 0 1 0 0 0 1 1 0 1
POLYGONS 2 9
4 0 1 2 3
3 0 1 4
TRIANGLE_STRIPS 1 5
4 0 1 4 5
CELL_DATA 3
SCALARS part int 1
LOOKUP_TABLE default
1 2 3
POINT_DATA 6
SCALARS heat double 1
LOOKUP_TABLE own
0 1 2 3 4 5
LOOKUP_TABLE own 2
0 0 0 1 1 1 1 1
NORMALS n float
0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 0 1
TEXTURE_COORDINATES uv 2 float
0 0 1 0 1 1 0 1 0 0 1 1
VECTORS wind float
1 0 0 1 0 0 1 0 0 1 0 0 1 0 0 1 0 0
COLOR_SCALARS paint 3
0 0 1 1 0 0 0 1 0 0 1 1 1 0 1 1 1 0
FIELD more 1
pressure%20a 2 6 unsigned_char
1 2 3 4 5 6 7 8 9 10 11 12
"""

VTK_CELLS = """# vtk DataFile Version 2.0
cells of several kinds
ASCII
DATASET UNSTRUCTURED_GRID
POINTS 5 double
0 0 0 1 0 0 1 1 0 0 1 0 0.5 0.5 1
CELLS 3 13
4 0 1 2 3
3 0 1 4
3 1 2 4
CELL_TYPES 3
9 5 5
CELL_DATA 3
SCALARS a unsigned_short
LOOKUP_TABLE default
1 2 3
"""

VTK_NEW = """# vtk DataFile Version 5.1
offsets and connectivity
ASCII
DATASET POLYDATA
POINTS 4 float
0 0 0 1 0 0 1 1 0 0 1 0
METADATA
INFORMATION 0

POLYGONS 3 6
OFFSETS vtktypeint64
0 3 6
CONNECTIVITY vtktypeint64
0 1 2 0 2 3
"""

VTK_VOLUME = """# vtk DataFile Version 3.0
a volume
ASCII
DATASET STRUCTURED_POINTS
DIMENSIONS 3 2 2
ORIGIN 0 0.5 -1
SPACING 1 0.5 0.25
POINT_DATA 12
SCALARS d float 1
LOOKUP_TABLE default
-1 0 1 2 3 4 5 6 7 8 9 1e1
"""


def vtk_binary():
    """A binary legacy file with point and cell data."""
    points = struct.pack(">12f", 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0)
    cells = struct.pack(">8i", 3, 0, 1, 2, 3, 0, 2, 3)
    parts = [b"# vtk DataFile Version 3.0\nbinary\nBINARY\nDATASET POLYDATA\nPOINTS 4 float\n", points, b"\nPOLYGONS 2 8\n",
             cells, b"\nPOINT_DATA 4\nSCALARS q short 2\nLOOKUP_TABLE default\n", struct.pack(">8h", *range(8)),
             b"\nCOLOR_SCALARS rgb 3\n", bytes(range(12)), b"\n"]
    return b"".join(parts)


def blocks(data, pack, size=64):
    """VTK's compressed blocks with their header of 32-bit numbers."""
    parts = [data[i : i + size] for i in range(0, len(data), size)]
    packed = [pack(p) for p in parts]
    head = [len(parts), size, len(parts[-1]) % size, *map(len, packed)]
    return struct.pack(f"<{len(head)}I", *head), b"".join(packed)


def vtk_xml(kind, how):
    """Poly data or a volume in XML; `how` is ascii, binary, raw, base64, zlib or lzma."""
    packs = {"zlib": (zlib.compress, "vtkZLibDataCompressor"),
             "lzma": (lambda d: lzma.compress(d, lzma.FORMAT_XZ, preset=0), "vtkLZMADataCompressor")}
    appended = b""

    def array(name, code, values, components=1):
        nonlocal appended
        vtk = {"f": "Float32", "d": "Float64", "q": "Int64", "i": "Int32", "B": "UInt8"}[code]
        head = f'<DataArray type="{vtk}" Name="{name}" NumberOfComponents="{components}" '
        data = struct.pack(f"<{len(values)}{code}", *values)
        whole = struct.pack("<I", len(data)) + data
        if how == "ascii":
            return head + 'format="ascii">' + " ".join(map(str, values)) + "</DataArray>"
        if how in ("raw", "base64"):
            at = len(appended)
            appended += whole if how == "raw" else base64.b64encode(whole)
            return head + f'format="appended" offset="{at}"/>'
        text = base64.b64encode(whole) if how == "binary" else b"".join(map(base64.b64encode, blocks(data, packs[how][0])))
        return head + f'format="binary">\n{text.decode()}\n</DataArray>'

    if kind == "PolyData":
        points, faces = bowl(2, 4)
        flat = [c for p in points for c in p]
        body = f'<PolyData>\n<Piece NumberOfPoints="{len(points)}" NumberOfPolys="{len(faces)}">\n<PointData Scalars="heat">\n'
        body += array("heat", "d", [p[0] for p in points]) + array("rgb", "B", list(range(3 * len(points))), 3)
        body += "\n</PointData>\n<CellData>\n" + array("part", "i", list(range(len(faces))))
        body += "\n</CellData>\n<Points>\n" + array("Points", "f", flat, 3) + "\n</Points>\n<Polys>\n"
        body += array("connectivity", "q", [v for f in faces for v in f])
        body += array("offsets", "q", [3 * (i + 1) for i in range(len(faces))]) + "\n</Polys>\n</Piece>\n</PolyData>\n"
    else:
        body = '<ImageData WholeExtent="0 2 1 2 0 3" Origin="1 2 3" Spacing="0.5 1 2">\n<Piece Extent="0 2 1 2 0 3">\n'
        body += "<PointData>\n" + array("d", "f", [0.25 * i - 2 for i in range(24)])
        body += "\n</PointData>\n</Piece>\n</ImageData>\n"
    compressor = f' compressor="{packs[how][1]}"' if how in packs else ""
    text = f'<?xml version="1.0"?>\n<VTKFile type="{kind}" version="0.1" byte_order="LittleEndian"{compressor}>\n{body}'.encode()
    if appended:
        encoding = "raw" if how == "raw" else "base64"
        text += f'<AppendedData encoding="{encoding}">\n_'.encode() + appended + b"\n</AppendedData>\n"
    return text + b"</VTKFile>\n"


# --- glTF -----------------------------------------------------------------------------------------------------------


def gltf(binary):
    """Two nodes with one mesh, a strip without indices, a sparse accessor, materials, colours and texture coordinates."""
    points, faces = bowl(2, 4)
    n = len(points)
    arrays = [
        (struct.pack(f"<{3 * n}f", *[c for p in points for c in p]), 5126, "VEC3", n, {"min": [-1, -1, -1], "max": [1, 1, 1]}),
        (struct.pack(f"<{2 * n}H", *[round(32767 * (c + 1)) for p in points for c in p[:2]]), 5123, "VEC2", n, {"normalized": True}),
        (bytes((7 * i) % 256 for i in range(4 * n)), 5121, "VEC4", n, {"normalized": True}),
        (struct.pack(f"<{3 * len(faces)}H", *[v for f in faces for v in f]), 5123, "SCALAR", 3 * len(faces), {}),
        (struct.pack("<H", 1), None, None, None, None),
        (struct.pack("<3f", 2, 2, 2), None, None, None, None),
    ]
    data, views, accessors = b"", [], []
    for body, component, kind, count, more in arrays:
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": len(body)})
        if component:
            accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": count, "type": kind, **more})
        data += body + b"\0" * (-len(body) % 4)
    sparse = {"count": 1, "indices": {"bufferView": 4, "componentType": 5123}, "values": {"bufferView": 5}}
    accessors.append({"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "sparse": sparse,
                      "min": [-1, -1, -1], "max": [2, 2, 2]})
    full = {"attributes": {"POSITION": 0, "TEXCOORD_0": 1, "COLOR_0": 2}, "indices": 3, "material": 0}
    root = {
        "asset": {"version": "2.0", "extras": {"of": "seeds"}},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"name": "root", "children": [1, 2], "scale": [0.5, 2, 0.5]},
                  {"mesh": 0, "translation": [-3, 0.5, 0], "rotation": [0, 0.6, 0, 0.8]},
                  {"mesh": 0, "matrix": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 4, 0, 0, 1]}],
        "meshes": [{"primitives": [full, {"attributes": {"POSITION": 4}, "mode": 5}]}],
        "materials": [{"name": "skin"}],
        "buffers": [{"byteLength": len(data)}],
        "bufferViews": views,
        "accessors": accessors,
    }
    if not binary:
        root["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
        return json.dumps(root).encode()
    text = json.dumps(root).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data))
    return head + struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data


# --- options --------------------------------------------------------------------------------------------------------

OPTIONS = [
    "voxel = 0.08\nquiet = true\ncolour = 'ff0000'\n\n[fill]\nholes = [2]\n\n[restore]\nvoxel = 0.5\n",
    "[restore]\noutput = 'out.ply'\nball = [[0, 0, -1, 0.3], [0, -1.0, 0, 3e-1]]\nbox = [0, 0, 0, 1, 1, 1]\n"
    "[fill]\noutput = '-'\nto = 'stl'\nbridge = ['1+2']\nascii = false\n",
    "# of all commands\nthreads = 2\njson = \"r.json\"\n[fair]\ntime = 1e-3\nkeep-open = [1, 2]\n[sdf]\nvoxel = \"auto\"\nband = 'full'\n",
    "fill = { voxel = 'auto', energy = 'curvature-variation', max-diameter = +1_000.5, verbose = false }\n",
]


def files(program, folder):
    """All seed files, by format: lists of extensions and bytes."""
    made = [("ply", ply().encode()), ("ply", ply_lists()), ("ply", PLY_STRIPS.encode()), ("obj", OBJ.encode()),
            ("stl", STL.encode()), ("gltf", gltf(False)), ("glb", gltf(True)), ("vtk", vtk_binary())]
    made += [("vtk", text.encode()) for text in (VTK_POLYGONS, VTK_CELLS, VTK_NEW)]
    made += [("vtp", vtk_xml("PolyData", how)) for how in ("ascii", "binary", "raw", "base64", "zlib", "lzma")]
    volumes = [("vti", vtk_xml("ImageData", how)) for how in ("ascii", "raw", "zlib", "lzma")] + [("vtk", VTK_VOLUME.encode())]
    source = folder / "seed.ply"
    source.write_text(ply())
    for suffix in FORMATS:
        for text in ([], ["--ascii"])[: 2 if suffix in TEXT else 1]:
            target = folder / f"out.{suffix}"
            # No hole is this narrow, so all holes stay open.
            command = [program, "fill", source, "-o", target, "-q", "--max-diameter", "1e-9", *text]
            subprocess.run(command, check=True)
            made.append((suffix, target.read_bytes()))
    target = folder / "out.vti"
    subprocess.run([program, "sdf", source, "-o", target, "-q", "--voxel", "0.4"], check=True)
    return made, volumes + [("vti", target.read_bytes())]


# Two objects with colours; the second consists of two instances of the first.
MODEL = """<?xml version="1.0"?>
<model unit="inch" xmlns="c" xmlns:m="m"><resources><m:colorgroup id="4"><m:color color="#FF0000"/><m:color color="#00FF0080"/></m:colorgroup>
<object id="1" name="a" pid="4" pindex="0"><mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/><vertex x="0" y="1" z="0"/></vertices>
<triangles><triangle v1="0" v2="1" v3="2" pid="4" p1="0" p2="1" p3="1"/></triangles></mesh></object>
<object id="2"><components><component objectid="1"/><component objectid="1" transform="-1 0 0 0 1 0 0 0 1 3 0 0"/></components></object>
</resources><build><item objectid="2"/></build></model>"""


def streams():
    """Streams of EXT_meshopt_compression, each behind three bytes that choose mode and filter, stride and number of elements."""
    # 16 elements of 8 bytes: differences that are 0, of 2 bits, of 4 bits, and whole bytes.
    planes = b"\0" + b"\x01" + bytes([0x1b] * 4 + [200] * 4) + b"\x02" + bytes([0x2f] * 8 + [77] * 8) + b"\x03" + bytes(range(16)) + b"\0" * 4
    points = [bytes([form, 0, 16]) + b"\xa0" + planes + bytes(24) + bytes([9, 8, 7, 6, 5, 4, 127, 0]) for form in (0, 3, 6, 9)]
    # A triangle of new vertices, some at its edges, one of each explicit kind.
    table = bytes([0, 0x10, 0x01, 0x12] + [0] * 12)
    triangles = b"\xe1" + bytes([0xF0, 0x10, 0x21, 0x0D, 0x0E, 0x1F, 0xF1, 0xFE, 0xFF]) + bytes([6, 0x1F, 8, 0xFF, 4, 2, 6]) + table
    indices = b"\xd1" + bytes([0, 4, 12, 0x85, 1, 9]) + bytes(4)
    return [*points, bytes([1, 0, 9]) + triangles, bytes([1, 1, 9]) + triangles, bytes([2, 1, 1]) + b"\xd1" + bytes(3) + bytes(4), bytes([2, 0, 2]) + indices]


# A mesh of 30 triangles in streams of KHR_draco_mesh_compression, encoded by draco3d 1.5.7: sequential connectivity, Edgebreaker with its
# standard traversal and by valences, and with normals and texture coordinates that have seams.
SEQUENTIAL = (
    "RFJBQ08CAgEAAAAeGQEAAQIAAgMDAgQDBAUFBAYFBgcHBggHCAkBCgsBCwICCwwCDAQGDQ4GDggKDxAKEAsLEBELEQwMERIMEg0NEhMNEw4PFBUPFRAQFRYQ"
    "FhERFhcRFxISFxgSGBMBAQAJAwAAAgABAQED/wfBEgORAv//D2kDtQH//xvc3Nz//xe1AbUB/4tpA2kDWQ933Nz//yPc//8X3APc3P//D9zctQH/B9wiyIA0"
    "gvjbuc1s85Lvc9XlSCsAyPRRRvG7RxDHpckN+1EhcQAAAAD/AwAAAAAAAAAAAAAAAAAAAABwQQo="
)
STANDARD = (
    "RFJBQ08CAgEBAAAAGR4AHgUBHRABCu/TPV2frmlVnyr/AREB/wAAAQAJAwAAAgEBAQEE/wf1IkUEaQP//xO1Ady1Af//D9wDaQMD3P//C5ECB9z/j9y1Af//"
    "l9z//yPc//8b3APc3P8DtQEcEhpMK4bbHn7JWsLV7lQC16XFP+HL0I8iNcxvswAAAAD/AwAAAAAAAAAAAAAAAAAAAABwQQo="
)
VALENCE = (
    "RFJBQ08CAgEBAAAAGR4AHgUBHRABCu/TPV2frmlVnyr/AREB/wABAQAJAwAAAgEBAQEH/wf1IkEEaQP//xO1Ady1Af//D9wDkQID3P//C5ECA9zc/4/ctQH/"
    "/5fc//8j3P//G9wD3Nz/A7UBHSTWVCYNzQdWK7TwfKRU80HzJDd8NvYBY+T04R+BAAAAAP8DAAAAAAAAAAAAAAAAAAAAAHBBCg=="
)
SEAMS = (
    "RFJBQ08CAgEBAAAAGR4CHgUBHRABCu/TPV2frmlVnyr/AREPBLV9coDqBBhe2oYD/wABAAEAAQEAAQAJAwAAAgEBCQMAAQMBAwkCAAICBAEBAQf/B/UikQLc"
    "/wPc/wfctQG1AbUB//8P3NyRArUB3P//C9wH3P+HtQHctQFpA////////+vc/wO1AR1BJkN5rKi0ACN0G9sYejiy8BaKpYbBpTSuLcrPvBDABADe8IEM1QNk"
    "II4AAAAAAAD/AwAAAAAAAAAAAAAAAAAAAABwQQoGAwEBBf8BZSAdAUEP////60EPJLQPPAxfG0bsZhKEKdkQ004fARPv9CRp63pPPD7yl1rPbcj4X/8AAAB/"
    "AAAA/wKbRggFAQEACwslAkUEA4kI3R3NDEUEJQILg0frsSqOdpfIH4EBAggQYHsyDOPKgK8vDmhHp+N8E0fGWt98j9MfwP9/k+cyQL3TH3f9BTAAKwAOqDtY"
    "zIdoAxoAAAAKA/wuhAAAAAD/AwAAAAAAAAAAAAAAAABACg=="
)


def draco():
    """Streams of KHR_draco_mesh_compression, each behind a byte that chooses the attributes."""
    plain = [b"\0" + base64.b64decode(stream) for stream in (SEQUENTIAL, STANDARD, VALENCE)]
    return [*plain, b"\3" + base64.b64decode(SEAMS)]


# Prims with transforms, references and variants, and a mesh with values, a hole and subsets.
USD = """#usda 1.0
(
    metersPerUnit = 0.001
    upAxis = "Z"
)
def Xform "A" (references = [@mesh.usd@</B>, </B> (offset = 1)]) {
    double3 xformOp:translate.timeSamples = { 1: (0, 0, 5), 2: (0, 0, 9), }
    float3 xformOp:rotateXYZ = (10, 20, 30)
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ"]
}
def "B" (variants = { string shape = "a" } prepend variantSets = "shape") {
    variantSet "shape" = { "a" {
        def Mesh "M" {
            int[] faceVertexCounts = [4, 3, 3]
            int[] faceVertexIndices = [0, 1, 3, 2, 0, 4, 1, 1, 4, 3]
            point3f[] points = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0), (0.5, 0.5, 1)]
            int[] holeIndices = [2]
            uniform token orientation = "leftHanded"
            normal3f[] normals = [(0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1), (0, 0, 1)] (interpolation = "vertex")
            texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1)] (interpolation = "faceVarying")
            int[] primvars:st:indices = [0, 1, 2, 0, 1, 2, 0, 1, 2, 0]
            color3f[] primvars:displayColor = [(1, 0.5, 0)] (interpolation = "constant")
            float[] primvars:w = [1, 2, 3, 4, 5, 6] (elementSize = 2
                interpolation = "uniform")
            def GeomSubset "s" { uniform token elementType = "face"; int[] indices = [0]; rel material:binding = </L/Red> }
        }
    } }
}
"""
# A stage with the same kinds of content, in the binary format, as OpenUSD 26.11 wrote it.
USD_BINARY = (
    "UFhSLVVTREMACAAAAAAAALEKAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAPyp8dJNYlA/AQAAAAAAAAAF"
    "AAAABAAAAAAAAAALAAAADAAAAA0AAAAOAAAAIAEAAAAAAAAAAAAAAAIAAAAAAAAAAAAAAAAAAAAAAPA/AAAAAAAAAAACAAAAAAAAABAAAAARAAAAAQAAAAAAAAATAAAAAQAAAAAAAAAV"
    "AAAAIAEAAAAAAAAAAQAAAAEAAAAAAAAAAQAAAAIAAAACAAAAAAAAABgAAAAaAAAAAQAAAAAAAAAdAAAAAwAAAAAAAAAgAAAAIQAAACIAAAABAAAAAAAAACMAAAADAAAAAAAAACUAAAAR"
    "AAAAJgAAAAEAAAAAAAAAJwAAAAkAAAAAAAAAIAAAACEAAAAiAAAAKAAAACkAAAAqAAAAKwAAACwAAAAtAAAAAQAAAAAAAAAuAAAAIAEAAAAAAAAAMAAAAAQAAAAAAAAAMgAAADMAAAA0"
    "AAAANQAAAAEAAAAAAAAAAwAAAAgAAAAAAAAABAAAAAQAAAAEAAAABAAAAAQAAAAEAAAABAAAAAQAAAADAAAAAAAAAAAAAAABAAAAAgAAACAAAAAAAAAAFgAAAAAAAAAAYgEAAABFRAEA"
    "NQAC/gIAUP4C/gL+BAAAAAAAAAAAAAAAAQAAAAIAAAADAAAAAwEAAAAAAAAABQAAAAAAAwAAAAAAAAAAAEhCAAAAAAAAAAAAAExCAAAAAAAAAAAAAEhCAACAPwAAAAAAAAAAAwAAAAAA"
    "AAAAAExCAAAAAAAAAAAAAFBCAAAAAAAAAAAAAExCAACAPwAAAAAAAAAAEgAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAACAPwAAAAAAAIA/AAAAAAAAAAAAAIA/AACAPwAAAAAAAABAAAAA"
    "AAAAAAAAAABAAACAPwAAAAAAAEBAAAAAAAAAAAAAAEBAAACAPwAAAAAAAIBAAAAAAAAAAAAAAIBAAACAPwAAAAAAAKBAAAAAAAAAAAAAAKBAAACAPwAAAAAAAMBAAAAAAAAAAAAAAMBA"
    "AACAPwAAAAAAAOBAAAAAAAAAAAAAAOBAAACAPwAAAAAAAABBAAAAAAAAAAAAAABBAACAPwAAAAAIAAAAAAAAAAAAAAAAAAA/AACAPgAAAD4AAAA/AACAPgAAgD4AAAA/AACAPgAAwD4A"
    "AAA/AACAPgAAAD8AAAA/AACAPgAAID8AAAA/AACAPgAAQD8AAAA/AACAPgAAYD8AAAA/AACAPgQAAAAAAAAAAAAAAAAAAAAAAIA/AAAAAAAAgD8AAIA/AAAAAAAAgD8gAAAAAAAAABIA"
    "AAAAAAAAAFMBAAAAAQEAgAD9/f39/f39EgAAAAAAAAB0AgAAAAAAAD8AAEA/FQAAAAAAAAAA8AMBAAAAEREREQEA//////////8SAAAAAAAAAGkSAAAAAAAAAADwAAEAAABBEARBAAD+"
    "/v7+/gABAAAAAAAAABAAAAAAAAAAAgAAAAAAAAAlAAAAJgAAACAAAAAAAAAAAgAAAAAAAAAAAAAAAADwPwAAAAAAAABAsAQAAAAAMAAIAAAAAAAAAAIAAAAAAAAAAAAFAAAAF0AAAAkA"
    "AAAXQEoAAAAAAAAA5gIAAAAAAABDAgAAAAAAAAD0bjstKQAAWgB1cEF4aXMAbWV0ZXJzUGVyVW5pdABXAHByaW1DaGlsZHJlbgBkZWZhdWx0UHJpbQBzcGVjaWZpZXIAWGZvcm0AdHlw"
    "ZU5hbWUAWABMb29rcwBDb3B5AFYAcmVmZXJlbmNlcwB4Zm9ybU9wOnRyYW5zbGF0ZTpjFAD1H09yZGVyAHByb3BlcnRpZXMAUmVkAE1hdGVyaWFsAHNoYXBlAHZhcmlhbnRTZXSRAAYT"
    "AHZOYW1lcwBhJQCUbGVjdGlvbgBiEwAFNQARe08AVD19AFRhDAD6DWF9AE1lc2gAcG9pbnRzAGZhY2VWZXJ0ZXhDb3URAEBJbmRpzAAkVGI8ACRifcUABtkABRIA8RByb3RhdGVaAFN0"
    "cmlwAHN1YmRpdmlzaW9uU2NoZW1lXwHwAXZhcnM6ZGlzcGxheUNvbG8IAQMWAEd3aG9sJQA4dGFiDwAmc3RAAENzdDppmwD1AGhhbGYAR2VvbVN1YnNldEcBEEIhAJFuZ0FQSQBhcGmB"
    "APAAYXMAZWxlbWVudFR5cGUAIQAA3QBgZmFtaWx5UwEjAG2EASA6Yh0AZG5nAHRva3kBYWJpbGl0eS4BBBsCZQBpbnRbXTYAAHMAwgB0YXJnZXRQYXRoc2EBYDNmW10AY+oAAQoAMXVu"
    "aUICkWludGVycG9sYbgBAX0BQG9yZDItAAGRAbBhcnlpbmcAZmxvYWQAEXahAVIAbm9uZRQAggBkb3VibGUzowDwAFtdAHRpbWVTYW1wbGVzAAMAAAAAAAAAAQAAABUAAAAYAAAAPQAA"
    "AAAAAABCAAAAAAAAAABSAAAAAFUBAPMfFQAVVBUVVBUBAwECAQEC/AkD9AQMAQIC6wQI9Az0DPQEJ+H4LQLRLwPOL9E2+QMAYC/RL9EvEEUBAAAAAAAAACACAAEAMAtAWAcAQQAJAGAI"
    "ADEpAAUIACELQAcAQQAqQAkJADELQGwIADEpAIQIADEjAK0IADMpAL0IABEUCAAxC0DJCAAxKQDVCAAxIQDiCAAxLQDyCABAKQACAQkAMCkAHwcAQwALQA4QABMiCAATLggAE0IIABNO"
    "CAATeggAEy84ABGGEAAxIACTCAAzKQA2GAABDwBDACxAOBAAEzoIABGrGQAzA4C3CAAT3wgAEvMIACOgOygAERkZATEDgDEIADMiAD0YABFAEAAzGIBwCAAToAgAEz4gABM/CAAggAMJ"
    "ADAYgEEHAEMAC0BCCAAR6BgAQBSAEAQRADADoEMHAEMAC0BECAARMhgAMwigZAgAE0UYABNGCACVAAC0QgAACEBHEABznAAAABdASBAAEYg4ADMLgJgIAICoBAAAAAAuAH4AAAAAAAAA"
    "hgAAAAAAAAAA8HQBAAAAAQVFVFURVFVUEVVUUFBUVVVUVUVVFRRUBUVFRVFVVQUA/AX5BQL3BQX2BQb1BQbyD/EQ8AUM7hPtBQ7rBQwF6QUT5hvjHuEeAuAeA98eBN4bB90eBtwcCdsm"
    "2SYC2CYD1yrULdEeEtAxzTECzBsZyzbJOMc64h/FOuIgxDgFwyYAAAAAAAAAJgAAAAAAAAAlAAAAAAAAAADwEwEAAABRBEAVVVEVAEQAAAIg4AYDBvIFAwbpHwPnBQMG7QcwAAAAAAAA"
    "AADwHv////9VVEUUUVVRUVUFAQQI4x0H+w4CwgJEvAIrzwEUOLgC9/0CAQJWoP4B/icAAAAAAAAAAPAVAAAAAFFVVRRRQQEAFAT/BP3+BPwO9AX6Af4BAf4BAf8B/wH+JgAAAAAAAAAV"
    "AAAAAAAAAABwAQAAABEAQAcAkAAQBAAC9woC/SkAAAAAAAAAAPAXAwAAAFVQVVVBEABFBQUABQQFBgICBPwGBQUFBAAABAQEBAQEBAQbAAAAAAAAAADwCQAAAAAFUBUQAEABAAAAB/8F"
    "//wE/PsH+QYAAAAAAAAAVE9LRU5TAAAAAAAAAAAAAPAEAAAAAAAAWwIAAAAAAABTVFJJTkdTAAAAAAAAAAAASwcAAAAAAAAUAAAAAAAAAEZJRUxEUwAAAAAAAAAAAABfBwAAAAAAAJ8B"
    "AAAAAAAARklFTERTRVRTAAAAAAAAAP4IAAAAAAAAlgAAAAAAAABQQVRIUwAAAAAAAAAAAAAAlAkAAAAAAACkAAAAAAAAAFNQRUNTAAAAAAAAAAAAAAA4CgAAAAAAAHkAAAAAAAAA"
)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="?", type=Path, default=ROOT / "fuzz/corpus")
    parser.add_argument("--isomend", type=Path, default=ROOT / "target/release/isomend")
    arguments = parser.parse_args()
    seeds = {name: [] for name in "obj ply stl gltf meshopt draco vtk vtk_xml off threemf usd rewrite fill work mask toml".split()}
    target_of = {"glb": "gltf", "3mf": "threemf", "usda": "usd", "usdz": "usd", "vtp": "vtk_xml", "vti": "vtk_xml"}
    with tempfile.TemporaryDirectory() as folder:
        meshes, volumes = files(arguments.isomend.resolve(), Path(folder))
    for suffix, data in meshes + volumes:
        seeds[target_of.get(suffix, suffix)].append(data)
    seeds["rewrite"] = [data for _, data in meshes]
    seeds["threemf"] += [MODEL.encode()]
    seeds["meshopt"] = streams()
    seeds["draco"] = draco()
    seeds["usd"] += [USD.encode(), base64.b64decode(USD_BINARY)]
    seeds["toml"] = [text.encode() for text in OPTIONS]
    chance = random.Random(1)
    for name in ("fill", "work", "mask"):
        # These targets decode any bytes to a mesh and options.
        seeds[name] = [chance.randbytes(size) for size in (8, 16, 32, 64, 64, 128, 128, 256, 256, 512)]
    for name, entries in seeds.items():
        place = arguments.folder / name
        place.mkdir(parents=True, exist_ok=True)
        for i, data in enumerate(entries):
            (place / f"seed-{i:02}").write_bytes(data)
        print(f"{name:8} {len(entries):3} seeds, the largest of {max(map(len, entries))} bytes")


if __name__ == "__main__":
    main()
