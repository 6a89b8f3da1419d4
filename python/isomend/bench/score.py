"""Scores of patches: distances between patch and true surface, in 1/1000 of the hole's diameter, and whether the hole is closed."""

import numpy as np

import isomend

from .cases import boundary, is_disc, spread
from .surfaces import components

# Samples on a patch.
SAMPLES = 20_000


class Reference:
    """A mesh as the true surface of a case."""

    def __init__(self, vertices, faces):
        self.vertices, self.faces = vertices, faces

    def nearest(self, points):
        """Points on the mesh itself, unchanged; no normals, as cases from meshes have no noise."""
        return points, None

    def distance(self, points):
        """Distances of points from the mesh."""
        return to_mesh(points, self.vertices, self.faces)


def to_mesh(points, vertices, faces):
    """Distances of points from a mesh."""
    return np.abs(isomend.signed_distance(points, vertices, faces))


def to_truth(case, points):
    """Distances of points from the true surface of a case."""
    if isinstance(case.truth, Reference):
        return case.truth.distance(points)
    return np.linalg.norm(points - case.truth.nearest(points)[0], axis=1)


def score(case, vertices, faces, patch):
    """Scores a patch (bool, one for each face): root mean square and largest distance, the larger of patch to truth and truth to mesh."""
    samples = spread(vertices, faces[patch], SAMPLES, np.random.default_rng(2))
    both = to_truth(case, samples), to_mesh(case.points, vertices, faces)
    return {
        "rms": max(1e3 * float(np.sqrt((d**2).mean())) / case.diameter for d in both),
        "max": max(1e3 * float(d.max()) / case.diameter for d in both),
        "faces": int(patch.sum()),
    }


def numbered(case, vertices, faces):
    """Faces of the input and of a result with indices of positions (32-bit) in place of vertices, and which faces of the result are new."""
    both = np.vstack([case.v, vertices]).astype(np.float32)
    number = np.unique(both, axis=0, return_inverse=True)[1].reshape(-1)
    own, faces = np.sort(number[: len(case.v)][case.f], axis=1), number[len(case.v) :][faces]
    face = np.unique(np.vstack([own, np.sort(faces, axis=1)]), axis=0, return_inverse=True)[1].reshape(-1)
    return number[: len(case.v)][case.f], faces, ~np.isin(face[len(own) :], face[: len(own)])


def marked(case, vertices, faces):
    """Which faces are new, by the positions of their corners, and whether the topology is the same as before the hole was cut."""
    _, faces, patch = numbered(case, vertices, faces)
    return patch, topology(faces) == topology(case.whole[1])


def marked_at_rim(case, vertices, faces):
    """As `marked`, for a mesh with further holes, which may be open or closed. Returns the new faces connected to the rim of the hole that
    was cut, and whether they are a disc, like the faces that were cut out, and all edges of them and of the rim have two faces."""
    own, faces, patch = numbered(case, vertices, faces)
    rim = np.sort(rim_of(case, own), axis=1)
    new = np.flatnonzero(patch)
    if len(new) == 0:
        return patch, False
    component = components(faces[new])
    patch[new] = np.isin(component, component[np.isin(faces[new], rim).any(axis=1)])
    edges, count = np.unique(edges_of(faces), axis=0, return_counts=True)
    wrong = set(map(tuple, edges[count != 2].tolist()))
    closed = wrong.isdisjoint(map(tuple, np.concatenate([edges_of(faces[patch]), rim]).tolist()))
    return patch, bool(closed and patch.any() and is_disc(faces[patch]))


def rim_of(case, own):
    """The boundary edges of the hole that was cut, without other holes; `own` are the input's faces with the indices of `numbered`."""
    _, whole, gone = case.whole
    used, first = np.unique(case.f, return_index=True)
    kept = np.full(whole.max() + 1, -1)
    kept[np.unique(whole[~gone])] = own.reshape(-1)[first]
    return kept[boundary(whole[gone])]


def edges_of(faces):
    """The three edges of each face, the smaller index first."""
    return np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)


def topology(faces):
    """The Euler characteristic, the number of edges with one face, and the number of edges with more than two faces."""
    edges, count = np.unique(edges_of(faces), axis=0, return_counts=True)
    return len(np.unique(faces)) - len(edges) + len(faces), int((count == 1).sum()), int((count > 2).sum())
