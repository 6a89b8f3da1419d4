"""Solids with sharp edges for scripts/shapes_with_edges.py: exact surfaces, two meshes of each solid, and the places of holes.

gmsh (OpenCASCADE) makes the solids and the exact normals. `clean` is gmsh's own mesh: edges of the solid are edges of the mesh.
`scanned` imitates a scan: marching cubes on the signed distance, remeshed without regard to sharp edges, and noise along the
normals. The solid's edges are then 0.2 to 0.4 of a mesh edge outside the mesh. Lengths are in millimetres."""

from dataclasses import dataclass

import gmsh
import igl
import make_data as data
import numpy as np
import pymeshlab
import pyvista as pv

SHARP = 25.0  # degrees between the normals of both sides: edges of the solid above this count as sharp
FACES_PER_TURN = 100  # triangles of the exact surface round a full circle; positions are corrected to the curved surface (see Truth)
KINDS = {
    "flat": "inside a flat side",
    "rim": "in one side, the rim along an edge",
    "convex": "across a convex edge",
    "concave": "across a concave edge",
    "curved": "across a curved edge",
    "two": "across two edges",
    "corner": "over a corner",
    "mixed": "over a corner, convex and concave",
    "round": "inside a round side",
    "fillet": "across a fillet",
    "fading": "over an edge that fades out",
}
# Kinds of sites with the hole's centre on a sharp edge, and on a corner; for other kinds it can be anywhere on the surface.
ON_EDGE, ON_CORNER = {"convex", "concave", "curved", "fading"}, {"corner", "mixed"}


@dataclass
class Site:
    """A hole to cut: its kind, a point near its centre, its radius over the mean edge."""

    kind: str
    at: tuple
    radius: float


@dataclass
class Solid:
    """A solid: `make()` builds it with gmsh's OpenCASCADE kernel; `edge` is the mean edge of the clean mesh, `noise` the noise of the
    scanned mesh over the mean edge."""

    make: object
    edge: float
    noise: float
    sites: list


# --- solids ---------------------------------------------------------------------------------------------------------


def wire(points):
    corners = [gmsh.model.occ.addPoint(*map(float, p)) for p in points]
    lines = [gmsh.model.occ.addLine(a, b) for a, b in zip(corners, corners[1:] + corners[:1])]
    return gmsh.model.occ.addCurveLoop(lines)


def extruded(profile, depth):
    """A polygon in x and z, extruded along y."""
    face = gmsh.model.occ.addPlaneSurface([wire([(x, 0, z) for x, z in profile])])
    gmsh.model.occ.extrude([(2, face)], 0, depth, 0)


def lofted(sections):
    gmsh.model.occ.addThruSections([wire(points) for points in sections], makeSolid=True, makeRuled=True)


def curves_at(inside):
    """Curves of the model whose bounding box has both ends inside, by the function `inside`."""
    gmsh.model.occ.synchronize()
    boxes = {tag: np.reshape(gmsh.model.getBoundingBox(1, tag), (2, 3)) for _, tag in gmsh.model.getEntities(1)}
    return [tag for tag, (low, high) in boxes.items() if inside(low) and inside(high)]


def box():
    gmsh.model.occ.addBox(0, 0, 0, 38, 27, 21)


def slotted_plate():
    plate = gmsh.model.occ.addBox(0, 0, 0, 58, 37, 13)
    slot = gmsh.model.occ.addBox(22, -1, 7.5, 11, 39, 9)
    gmsh.model.occ.cut([(3, plate)], [(3, slot)])


def bored_block():
    block = gmsh.model.occ.addBox(0, 0, 0, 42, 33, 23)
    bores = [gmsh.model.occ.addCylinder(16, 16, -1, 0, 0, 25, 8.5), gmsh.model.occ.addCylinder(34, 12, 12, 0, 0, 12, 5)]
    gmsh.model.occ.cut([(3, block)], [(3, bore) for bore in bores])


def cylinder():
    gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 34, 13)


def frustum():
    gmsh.model.occ.addCone(0, 0, 0, 0, 0, 24, 17, 9.5)


def tee():
    run = gmsh.model.occ.addCylinder(-24, 0, 0, 48, 0, 0, 11)
    branch = gmsh.model.occ.addCylinder(0, 0, 0, 30 * np.cos(np.radians(68)), 0, 30 * np.sin(np.radians(68)), 7.5)
    gmsh.model.occ.fuse([(3, run)], [(3, branch)])


def shaft():
    parts = [gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, 14, 12), gmsh.model.occ.addCylinder(0, 0, 14, 0, 0, 6, 8)]
    parts.append(gmsh.model.occ.addCone(0, 0, 20, 0, 0, 7, 8, 3.5))
    gmsh.model.occ.fuse([(3, parts[0])], [(3, part) for part in parts[1:]])


def button():
    ball = gmsh.model.occ.addSphere(0, 0, 0, 18)
    slab = gmsh.model.occ.addBox(-30, -30, -7, 60, 60, 17)
    gmsh.model.occ.intersect([(3, ball)], [(3, slab)])


def filleted_block():
    block = gmsh.model.occ.addBox(0, 0, 0, 41, 31, 22)
    edges = curves_at(lambda p: p[2] > 21.9)
    edges += [tag for tag in curves_at(lambda p: p[0] > 40.9) if tag not in edges and tag in curves_at(lambda p: p[1] > 30.9)]
    gmsh.model.occ.fillet([block], edges, [5.0])


def bracket():
    """An angle whose inner edge is rounded by 7 mm and whose outer one by 4 mm."""
    extruded([(0, 0), (36, 0), (36, 9), (10, 9), (10, 32), (0, 32)], 25)
    inner = curves_at(lambda p: abs(p[0] - 10) < 0.1 and abs(p[2] - 9) < 0.1)
    outer = curves_at(lambda p: abs(p[0]) < 0.1 and abs(p[2]) < 0.1)
    gmsh.model.occ.fillet([gmsh.model.getEntities(3)[0][1]], inner + outer, [7.0, 4.0])


def chamfered_block():
    block = gmsh.model.occ.addBox(0, 0, 0, 39, 28, 20)
    edges = curves_at(lambda p: p[2] > 19.9)
    sides = [tag for _, tag in gmsh.model.getEntities(2) if gmsh.model.getBoundingBox(2, tag)[2] > 19.9]
    gmsh.model.occ.chamfer([block], edges, sides * len(edges), [4.5])


def fading_ridge():
    """A roof whose ridge, 56 degrees at one end, is flat at the other."""
    lofted([[(x, 0, 0), (x, 30, 0), (x, 30, 16), (x, 15, top), (x, 0, 16)] for x, top in ((0, 24), (46, 16))])


def fading_valley():
    """A block with a groove that runs out: 53 degrees at one end."""
    lofted([[(x, 0, 0), (x, 34, 0), (x, 34, 20), (x, 17, bottom), (x, 0, 20)] for x, bottom in ((0, 11.5), (52, 20))])


def pentagon():
    angles = np.radians(90 + 72 * np.arange(5))
    extruded(list(zip(17 * np.cos(angles), 17 * np.sin(angles))), 27)


SOLIDS = {
    "box": Solid(box, 2.4, 0.02, [
        Site("flat", (19, 13, 21), 3.4), Site("rim", (12, 24, 21), 2.6), Site("convex", (20, 0, 21), 2.7),
        Site("convex", (38, 27, 9), 2.0), Site("corner", (38, 27, 21), 2.8)]),
    "angle": Solid(lambda: extruded([(0, 0), (36, 0), (36, 8), (10, 8), (6, 31), (-5, 31)], 26), 1.9, 0.01, [
        Site("concave", (10, 13, 8), 2.6), Site("convex", (36, 12, 8), 1.9), Site("two", (0.5, 13, 31), 4.0),
        Site("mixed", (10, 26, 8), 2.6), Site("flat", (16, 13, 0), 4.6), Site("rim", (31, 13, 8), 3.4)]),
    "slotted plate": Solid(slotted_plate, 2.1, 0.03, [
        Site("two", (27.5, 18, 7.5), 3.5), Site("two", (33, 20, 10.2), 2.2), Site("mixed", (33, 37, 7.5), 2.0),
        Site("corner", (58, 37, 13), 2.9), Site("flat", (9, 18, 13), 3.6), Site("rim", (15, 20, 13), 4.2),
        Site("convex", (22, 12, 13), 2.2)]),
    "bored block": Solid(bored_block, 1.9, 0.005, [
        Site("curved", (24.5, 16, 23), 2.5), Site("curved", (29, 12, 23), 1.7), Site("round", (7.5, 16, 11), 3.0),
        Site("rim", (16, 27.6, 23), 2.1), Site("flat", (30, 33, 10), 4.2), Site("convex", (42, 20, 0), 3.1)]),
    "cylinder": Solid(cylinder, 2.0, 0.02, [
        Site("round", (13, 0, 17), 4.0), Site("curved", (0, 13, 34), 3.0), Site("rim", (0, -9, 34), 2.9),
        Site("rim", (-13, 0, 30), 2.6), Site("flat", (0, 0, 0), 3.7)]),
    "frustum": Solid(frustum, 2.1, 0.04, [
        Site("round", (0, 13.2, 12), 3.3), Site("curved", (17, 0, 0), 2.7), Site("curved", (0, -9.5, 24), 2.1),
        Site("rim", (-15.5, 0, 4.5), 2.8)]),
    "wedge": Solid(lambda: extruded([(0, 0), (44, 0), (44, 6), (0, 27)], 30), 2.3, 0.02, [
        Site("two", (44, 15, 3), 2.1), Site("convex", (0, 14, 27), 3.1), Site("corner", (0, 30, 27), 2.7),
        Site("flat", (20, 15, 17.45), 4.4), Site("rim", (24, 26, 15.5), 2.7), Site("convex", (44, 22, 6), 1.3)]),
    "tee": Solid(tee, 1.9, 0.01, [
        Site("curved", (10, 0, 11), 2.3), Site("curved", (3.8, 7.5, 8), 2.7), Site("round", (-14, 0, -11), 4.0),
        Site("round", (8.5, 7.5, 21), 2.3), Site("curved", (-24, 0, -11), 2.6)]),
    "pentagon": Solid(pentagon, 2.0, 0.03, [
        Site("convex", (0, 13, 17), 2.6), Site("convex", (0, 0, -13.75), 2.4), Site("corner", (0, 27, 17), 2.6),
        Site("flat", (0, 27, 0), 4.4), Site("rim", (-12.5, 5, 11), 2.4)]),
    "stairs": Solid(
        lambda: extruded([(0, 0), (42, 0), (42, 7), (29, 7), (29, 15), (15, 15), (15, 22.5), (0, 22.5)], 28), 1.8, 0.015, [
        Site("concave", (29, 10, 7), 2.7), Site("concave", (15, 18, 15), 1.7), Site("convex", (29, 18, 15), 2.5),
        Site("two", (29, 10, 11), 3.0), Site("mixed", (29, 28, 7), 2.6), Site("mixed", (15, 0, 15), 2.0),
        Site("corner", (29, 28, 15), 2.4), Site("rim", (35.5, 18, 7), 4.1)]),
    "filleted block": Solid(filleted_block, 1.7, 0.01, [
        Site("fillet", (14, 31, 22), 4.0), Site("fillet", (41, 31, 7), 3.2), Site("fillet", (40, 30, 21), 4.4),
        Site("fillet", (41, 13, 22), 2.2), Site("flat", (20, 13, 22), 3.8), Site("curved", (39.5, 29.5, 0), 2.2),
        Site("convex", (20, 0, 0), 2.8)]),
    "bracket": Solid(bracket, 1.8, 0.02, [
        Site("fillet", (12, 13, 11), 4.4), Site("fillet", (12, 19, 11), 2.4), Site("fillet", (1, 12, 1), 3.2),
        Site("convex", (36, 12, 9), 2.1), Site("rim", (31, 13, 9), 3.3), Site("curved", (12, 25, 11), 2.3)]),
    "chamfered block": Solid(chamfered_block, 1.8, 0.02, [
        Site("convex", (20, 4.5, 20), 1.6), Site("two", (36.8, 14, 17.8), 3.2), Site("corner", (34.5, 23.5, 20), 1.5),
        Site("corner", (39, 0, 0), 2.8), Site("flat", (19, 14, 20), 3.6)]),
    "ridge": Solid(fading_ridge, 1.9, 0.01, [
        Site("fading", (30.5, 15, 18.7), 4.4), Site("fading", (26, 15, 19.5), 6.6), Site("convex", (7, 15, 23), 2.7),
        Site("convex", (25, 0, 16), 2.4)]),
    "valley": Solid(fading_valley, 2.2, 0.02, [
        Site("fading", (31, 17, 16.6), 4.0), Site("fading", (27, 17, 16), 6.0), Site("concave", (8, 17, 12.8), 2.7)]),
    "button": Solid(button, 2.0, 0.02, [
        Site("curved", (15, 0, 10), 2.6), Site("curved", (0, 16.6, -7), 3.2), Site("round", (0, -18, 0), 3.2),
        Site("rim", (-16.5, 0, 7), 2.6)]),
    "shaft": Solid(shaft, 1.6, 0.01, [
        Site("curved", (0, 8, 14), 1.6), Site("curved", (0, -8, 20), 1.9), Site("two", (10, 0, 14), 2.3),
        Site("round", (-12, 0, 7), 3.2), Site("curved", (12, 0, 0), 2.8)]),
}


# --- the exact surface ----------------------------------------------------------------------------------------------


def unit(v):
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-300)


def crossed(v, f):
    """Normals of triangles, with twice the area as length."""
    return np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]])


class Truth:
    """The surface of a solid: triangles with corners on the surface, the exact normals there, and the solid's side of each triangle.

    A point of a triangle is moved to the curved surface by half of its displacement onto the corners' tangent planes, weighted by its
    barycentric coordinates (Boubekeur and Alexa, "Phong tessellation", 2008, eq. 2 with alpha = 1/2). This is exact for
    quadratic height functions; on a cylinder the remaining error is 3e-6 of its radius at 100 triangles a turn."""

    def __init__(self, v, f, normals, side):
        self.v, self.f, self.normals, self.side = v, f, normals, side

    def near(self, point, radius):
        """The triangles near a point: their bounding boxes are within `radius` of it along every axis."""
        corners = self.v[self.f]
        inside = ((corners.min(axis=1) < point + radius) & (corners.max(axis=1) > point - radius)).all(axis=1)
        return Truth(self.v, np.ascontiguousarray(self.f[inside]), self.normals[inside], self.side[inside])

    def lifted(self, face, weights):
        """The points with these barycentric coordinates, moved to the curved surface, and the unit normals there."""
        corners, normals = self.v[self.f[face]], self.normals[face]
        flat = np.einsum("nk,nkd->nd", weights, corners)
        heights = np.einsum("nkd,nkd->nk", flat[:, None] - corners, normals)
        return flat - np.einsum("nk,nkd->nd", weights * heights, normals) / 2, unit(np.einsum("nk,nkd->nd", weights, normals))

    def nearest(self, p):
        """Nearest points of the surface, with their unit normals and their sides of the solid."""
        _, face, foot = igl.point_mesh_squared_distance(np.ascontiguousarray(p), self.v, self.f)
        corners = self.v[self.f[face]]
        opposite = np.stack([np.cross(corners[:, k - 2] - foot, corners[:, k - 1] - foot) for k in range(3)], axis=1)
        weights = np.linalg.norm(opposite, axis=2)
        weights /= np.maximum(weights.sum(axis=1, keepdims=True), 1e-300)
        point, normal = self.lifted(face, weights)
        return point, normal, self.side[face]

    def spread(self, count, rng):
        """Random points on the surface, spread evenly by area, with their normals."""
        area = np.linalg.norm(crossed(self.v, self.f), axis=1)
        face = rng.choice(len(self.f), count, p=area / area.sum())
        a, b = np.sqrt(rng.random(count)), rng.random(count)
        return self.lifted(face, np.stack([1 - a, a * (1 - b), a * b], axis=1))[0]

    def creases(self):
        """Edges between two sides of the solid: their ends, and the angle in degrees, negative if concave."""
        half = np.concatenate([self.f[:, [0, 1]], self.f[:, [1, 2]], self.f[:, [2, 0]]])
        face, start = np.tile(np.arange(len(self.f)), 3), np.repeat(np.arange(3), len(self.f))
        keys = np.sort(half, axis=1)
        order = np.lexsort(keys.T)
        keys, half, face, start = keys[order], half[order], face[order], start[order]
        pair = np.flatnonzero((keys[1:] == keys[:-1]).all(axis=1))
        pair = pair[self.side[face[pair]] != self.side[face[pair + 1]]]
        one, two = (unit(sum(self.normals[face[k], (start[k] + s) % 3] for s in (0, 1))) for k in (pair, pair + 1))
        ends = self.v[half[pair]]
        angle = np.degrees(np.arccos(np.clip((one * two).sum(axis=1), -1, 1)))
        turn = (np.cross(one, two) * (ends[:, 1] - ends[:, 0])).sum(axis=1)
        return ends, np.where(turn < 0, -angle, angle)


def triangles():
    """gmsh's mesh of the model: vertices, triangles (counterclockwise seen from outside), corner normals, sides."""
    tags, coordinates, _ = gmsh.model.mesh.getNodes()
    number = np.full(int(tags.max()) + 1, -1)
    number[tags.astype(int)] = np.arange(len(tags))
    faces, normals, sides = [], [], []
    for dimension, side in gmsh.model.getEntities(2):
        at, _, parameters = gmsh.model.mesh.getNodes(dimension, side, includeBoundary=True, returnParametricCoord=True)
        own = np.zeros((len(tags), 3))
        own[number[at.astype(int)]] = np.reshape(gmsh.model.getNormal(side, parameters), (-1, 3))
        f = number[np.reshape(gmsh.model.mesh.getElements(dimension, side)[2][0], (-1, 3)).astype(int)]
        faces.append(f)
        normals.append(own[f])
        sides.append(np.full(len(f), side))
    v, f, n = coordinates.reshape(-1, 3), np.concatenate(faces), np.concatenate(normals)
    used, f = np.unique(f, return_inverse=True)
    v, f = v[used], f.reshape(-1, 3)
    # gmsh orients each side separately: orient them consistently, then outwards (positive enclosed volume).
    oriented = igl.bfs_orient(f)[0]
    if np.linalg.det(v[oriented]).sum() < 0:
        oriented = oriented[:, ::-1]
    flat = crossed(v, oriented)
    turned = (crossed(v, f) * flat).sum(axis=1) < 0
    f[turned], n[turned] = f[turned][:, ::-1], n[turned][:, ::-1]
    n *= np.sign(np.einsum("nkd,nd->nk", n, flat))[:, :, None]
    return v, f, unit(n), np.concatenate(sides)


def scanned(truth, edge, noise, seed):
    """The scanned mesh: marching cubes on the signed distance, remeshed without features; `noise` along normals, over the mean edge."""
    cell = 0.6 * edge
    low, high = truth.v.min(axis=0) - 3 * cell, truth.v.max(axis=0) + 3 * cell
    shape = np.ceil((high - low) / cell).astype(int) + 1
    nodes = np.stack(np.meshgrid(*(low[k] + cell * np.arange(shape[k]) for k in range(3)), indexing="ij"), axis=-1)
    nodes = np.ascontiguousarray(nodes.transpose(2, 1, 0, 3).reshape(-1, 3))
    kind = igl.SignedDistanceType.SIGNED_DISTANCE_TYPE_PSEUDONORMAL
    distance = igl.signed_distance(nodes, truth.v, truth.f, sign_type=kind)[0]
    grid = pv.ImageData(dimensions=shape, spacing=(cell,) * 3, origin=low)
    surface = grid.contour([0.0], scalars=distance, compute_normals=False).triangulate().clean(tolerance=1e-9)
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.array(surface.points, float), surface.faces.reshape(-1, 4)[:, 1:]))
    length = pymeshlab.PureValue(edge)
    meshes.meshing_isotropic_explicit_remeshing(iterations=8, targetlen=length, featuredeg=180.0, checksurfdist=False)
    v, f = meshes.current_mesh().vertex_matrix().copy(), meshes.current_mesh().face_matrix().astype(np.int64)
    if np.linalg.det(v[f]).sum() < 0:
        f = f[:, ::-1].copy()
    # Wrong signs next to sharp edges leave small closed components, which are removed.
    component = data.components(f)
    v, f = data.cut(v, f, component != np.bincount(component).argmax())
    normals = np.zeros_like(v)
    for k in range(3):
        np.add.at(normals, f[:, k], crossed(v, f))
    mean = np.linalg.norm(v[f] - v[np.roll(f, 1, axis=1)], axis=2).mean()
    return v + unit(normals) * noise * mean * np.random.default_rng(seed).standard_normal((len(v), 1)), f


def sampled(name, seed):
    """The exact surface, the clean and the scanned mesh of a solid, and its sites, all rotated so that nothing is aligned with the axes."""
    solid = SOLIDS[name]
    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Verbosity", 0)
    gmsh.option.setNumber("General.NumThreads", 1)
    gmsh.option.setNumber("Mesh.RandomSeed", seed)
    gmsh.model.add(name)
    solid.make()
    gmsh.model.occ.synchronize()
    meshes = []
    for edge, turn in ((0.6 * solid.edge, FACES_PER_TURN), (solid.edge, 0)):
        gmsh.option.setNumber("Mesh.MeshSizeMax", edge)
        gmsh.option.setNumber("Mesh.MeshSizeMin", edge if turn == 0 else 0)
        gmsh.option.setNumber("Mesh.MeshSizeFromCurvature", turn)
        gmsh.model.mesh.clear()
        gmsh.model.mesh.generate(2)
        meshes.append(triangles())
    gmsh.finalize()
    v, f, normals, side = meshes[0]
    truth = Truth(np.ascontiguousarray(v @ data.TURN.T), np.ascontiguousarray(f, np.int64), normals @ data.TURN.T, side)
    clean = np.ascontiguousarray(meshes[1][0] @ data.TURN.T), np.ascontiguousarray(meshes[1][1], np.int64)
    sites = [Site(s.kind, data.TURN @ np.array(s.at, float), s.radius * solid.edge) for s in solid.sites]
    return truth, {"clean": clean, "scanned": scanned(truth, solid.edge, solid.noise, seed)}, sites
