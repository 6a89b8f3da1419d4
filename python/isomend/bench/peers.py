"""Hole filling with other programs: MeshLib, libigl, MeshLab, MeshFix. Each is imported on first use."""

import time

import numpy as np


def triangulate(case, longest, smooth):
    """Fills the holes with MeshLib, with edges up to `longest`; returns vertices, faces, which faces are new, seconds."""
    from meshlib import mrmeshnumpy, mrmeshpy

    mesh = mrmeshnumpy.meshFromFacesVerts(case.f.astype(np.int32), case.v.astype(np.float32))
    start = time.perf_counter()
    rims = list(mesh.topology.findHoleRepresentiveEdges())
    settings = mrmeshpy.StitchHolesNicelySettings() if case.bridge else mrmeshpy.FillHoleNicelySettings()
    settings.triangulateOnly = False
    settings.smoothCurvature = smooth
    settings.subdivideSettings.maxEdgeLen = longest
    settings.subdivideSettings.maxEdgeSplits = 200_000
    settings.triangulateParams.metric = mrmeshpy.getUniversalMetric(mesh)
    if case.bridge:
        new = [mrmeshpy.stitchHolesNicely(mesh, rims[0], rims[1], settings)]
    else:
        new = [mrmeshpy.fillHoleNicely(mesh, rim, settings) for rim in rims]
    seconds = time.perf_counter() - start
    v, f = mrmeshnumpy.getNumpyVerts(mesh).astype(float), mrmeshnumpy.getNumpyFaces(mesh.topology).astype(np.int64)
    v[: len(case.v)] = case.v
    patch = np.zeros(len(f), bool)
    for faces in new:
        marks = mrmeshnumpy.getNumpyBitSet(faces)[: len(f)]
        patch[: len(marks)] |= marks
    return v, f, patch, seconds


def mean_edge(v, f):
    return np.linalg.norm(v[f] - v[np.roll(f, 1, axis=1)], axis=2).mean()


def fair(case, v, f, k, solves):
    """k-harmonic positions of the new vertices by libigl, with all other vertices fixed. Returns all vertices (none if the solve fails) and
    seconds."""
    import igl

    start = time.perf_counter()
    v = v.copy()
    known = len(case.v)
    near = np.zeros(len(v), bool)
    near[known:] = True
    # Only the new vertices and the vertices within six edges of them are solved for.
    for _ in range(6):
        near[f[near[f].any(axis=1)]] = True
    crop = np.ascontiguousarray(f[near[f].any(axis=1)])
    used, local = np.unique(crop, return_inverse=True)
    crop = local.reshape(-1, 3).astype(np.int64)
    fixed = np.flatnonzero(used < known).astype(np.int64)
    p = v[used]
    for _ in range(solves):
        p = igl.harmonic(np.ascontiguousarray(p), crop, fixed, np.ascontiguousarray(p[fixed]), k)
        if not np.isfinite(p).all():
            return None, time.perf_counter() - start
    v[used[used >= known]] = p[used >= known]
    return v, time.perf_counter() - start


def triangulated(case, aim, smooth):
    """Fills the holes with MeshLib so that the patch's mean edge is about `aim`. In real meshes, whose edges differ in length, the limit of
    the edge length is corrected three times."""
    longest = aim / 0.75
    for _ in range(3 if hasattr(case, "centre") else 0):
        v, f, patch, _ = triangulate(case, longest, False)
        longest *= aim / mean_edge(v, f[patch])
    return triangulate(case, longest, smooth)


def by_meshlib(case, aim):
    return triangulated(case, aim, True)


def by_libigl(case, aim, k=3, solves=1):
    """k-harmonic fairing of MeshLib's triangulation. Each of several solves uses the positions of the previous one."""
    v, f, patch, seconds = triangulated(case, aim, False)
    moved, more = fair(case, v, f, k, solves)
    return (v if moved is None else moved), f, patch, seconds + more


def by_meshlab(case, aim):
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(case.v, case.f))
    start = time.perf_counter()
    longest = pymeshlab.PureValue(aim / 0.75)
    meshes.meshing_close_holes(maxholesize=100_000, selfintersection=False, refinehole=True, refineholeedgelen=longest)
    seconds = time.perf_counter() - start
    mesh = meshes.current_mesh()
    return mesh.vertex_matrix(), mesh.face_matrix().astype(np.int64), None, seconds


def by_meshfix(case, aim):
    import pymeshfix

    fix = pymeshfix.PyTMesh()
    fix.load_array(case.v, case.f.astype(np.int32))
    start = time.perf_counter()
    fix.fill_small_boundaries(0, True)
    seconds = time.perf_counter() - start
    v, f = fix.return_arrays()
    return np.asarray(v, float), np.asarray(f, np.int64), None, seconds


# For each program its title, the packages that it needs, and a function of the case and the mean edge length of isomend's patch that
# returns vertices, faces, which faces are new (None if the program does not report them), and seconds.
TOOLS = {
    "meshlib": ("MeshLib", ("meshlib",), by_meshlib),
    "libigl2": ("MeshLib + libigl, k = 2", ("meshlib", "igl"), lambda case, aim: by_libigl(case, aim, 2)),
    "libigl3": ("MeshLib + libigl, k = 3", ("meshlib", "igl"), by_libigl),
    "libigl10": ("MeshLib + libigl, k = 3 × 10", ("meshlib", "igl"), lambda case, aim: by_libigl(case, aim, 3, 11)),
    "meshlab": ("MeshLab", ("pymeshlab",), by_meshlab),
    "meshfix": ("MeshFix", ("pymeshfix",), by_meshfix),
}
