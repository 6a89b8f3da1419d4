"""How near a patch comes to the truth. Distances are in 1/1000 of the hole's diameter."""

import numpy as np

import isomend

from .cases import boundary, is_disc, spread
from .surfaces import pieces

SAMPLES = 20_000


class Reference:
    """A mesh as the truth."""

    def __init__(self, vertices, faces):
        self.vertices, self.faces = vertices, faces

    def nearest(self, points):
        """Points that lie on the mesh, as they are; their normals are not asked for."""
        return points, None

    def distance(self, points):
        """Distances of points from the mesh."""
        return to_mesh(points, self.vertices, self.faces)


def to_mesh(points, vertices, faces):
    """Distances of points from a mesh."""
    return np.abs(isomend.signed_distance(points, vertices, faces))


def to_truth(case, points):
    """Distances of points from the truth of a case."""
    if isinstance(case.truth, Reference):
        return case.truth.distance(points)
    return np.linalg.norm(points - case.truth.nearest(points)[0], axis=1)


def score(case, vertices, faces, patch):
    """Root mean square and largest distances of a patch (bool, one for each face), the larger of patch to truth and truth to mesh."""
    samples = spread(vertices, faces[patch], SAMPLES, np.random.default_rng(2))
    both = to_truth(case, samples), to_mesh(case.points, vertices, faces)
    return {
        "rms": max(1e3 * float(np.sqrt((d**2).mean())) / case.diameter for d in both),
        "max": max(1e3 * float(d.max()) / case.diameter for d in both),
        "faces": int(patch.sum()),
    }


def numbered(case, vertices, faces):
    """Faces of the input and of a result with one number for each position; and which faces of the result are not the input's."""
    both = np.vstack([case.v, vertices]).astype(np.float32)
    number = np.unique(both, axis=0, return_inverse=True)[1].reshape(-1)
    own, faces = np.sort(number[: len(case.v)][case.f], axis=1), number[len(case.v) :][faces]
    face = np.unique(np.vstack([own, np.sort(faces, axis=1)]), axis=0, return_inverse=True)[1].reshape(-1)
    return number[: len(case.v)][case.f], faces, ~np.isin(face[len(own) :], face[: len(own)])


def marked(case, vertices, faces):
    """Which faces are not the input's, by the positions of their corners; whether the hole is closed with the truth's topology."""
    _, faces, patch = numbered(case, vertices, faces)
    return patch, topology(faces) == topology(case.whole[1])


def marked_at_rim(case, vertices, faces):
    """The same of a mesh with other holes, which may be open or closed: the new faces connected to the rim of the hole that was cut;
    whether these are one disc, as what was cut out, and all their edges and those of the rim have two faces."""
    own, faces, patch = numbered(case, vertices, faces)
    rim = np.sort(rim_of(case, own), axis=1)
    new = np.flatnonzero(patch)
    if len(new) == 0:
        return patch, False
    piece = pieces(faces[new])
    patch[new] = np.isin(piece, piece[np.isin(faces[new], rim).any(axis=1)])
    edges, count = np.unique(edges_of(faces), axis=0, return_counts=True)
    wrong = set(map(tuple, edges[count != 2].tolist()))
    closed = wrong.isdisjoint(map(tuple, np.concatenate([edges_of(faces[patch]), rim]).tolist()))
    return patch, bool(closed and patch.any() and is_disc(faces[patch]))


def rim_of(case, own):
    """The boundary edges of the hole that was cut, without those of other holes; `own` are the input's faces in other numbers."""
    _, whole, gone = case.whole
    used, first = np.unique(case.f, return_index=True)
    kept = np.full(whole.max() + 1, -1)
    kept[np.unique(whole[~gone])] = own.reshape(-1)[first]
    return kept[boundary(whole[gone])]


def edges_of(faces):
    """The three edges of each face, the smaller number first."""
    return np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)


def topology(faces):
    """The Euler characteristic, and how many edges have one, two and more faces."""
    edges, count = np.unique(edges_of(faces), axis=0, return_counts=True)
    return len(np.unique(faces)) - len(edges) + len(faces), int((count == 1).sum()), int((count > 2).sum())
