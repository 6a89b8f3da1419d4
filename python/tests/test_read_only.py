"""Arrays that meshes and results hand out are read-only: a change of them would change neither the mesh nor its files."""

import copy
import importlib
import importlib.util
import pickle

import numpy as np
import pytest
import shapes

import isomend


def arrays_of(value):
    """All arrays that the properties of a value hand out, by name."""
    for name in dir(type(value)):
        if name.startswith("_") or not isinstance(getattr(type(value), name), property):
            continue
        handed = getattr(value, name)
        if isinstance(handed, np.ndarray):
            yield name, handed
        elif isinstance(handed, dict) and name.endswith("_data"):
            yield from ((f"{name}[{key!r}]", array) for key, array in handed.items())


@pytest.fixture(scope="module")
def valued():
    vertices, faces = shapes.open_sphere(around=24, latitudes=12, top=3)
    points = {"heat": vertices[:, 2], "on": np.ones(len(vertices), bool), "normals": vertices}
    return isomend.Model(vertices, faces, point_data=points, cell_data={"scan": np.ones((len(faces), 2, 2), np.int16)})


def seamed():
    """A mesh with values of corners."""
    return isomend.read(
        b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\nf 1/1 3/3 2/2\nf 1/4 2/2 4/3\nf 1/1 4/4 3/2\n", format="obj"
    )


def test_all_arrays_of_meshes_and_results_are_read_only(valued):
    mended = valued.restore({"balls": [[0, 0, -1, 0.4]]})
    verdict, found = valued.check(), valued.inspect()
    handed = [*arrays_of(valued), *arrays_of(mended), *arrays_of(seamed()), *arrays_of(valued.sdf(voxel=0.2)), *arrays_of(pickle.loads(pickle.dumps(mended)))]
    handed += [("rim", hole.rim) for hole in found.holes]
    handed += [("defect", array) for kind in ("boundary_edge", "thin") for array in (verdict.defects[kind].faces, verdict.defects[kind].places)]
    names = {name for name, _ in handed}
    assert {"vertices", "faces", "is_patch", "sigma", "kept_vertices", "kept_faces", "values", "point_data['heat']", "cell_data['scan']"} <= names
    assert any(name.startswith("corner_data") for name in names)
    for name, array in handed:
        assert not array.flags.writeable, name
    before = mended.to_bytes("ply")
    for change in (lambda m: m.vertices.__imul__(2), lambda m: m.point_data["heat"].fill(0), lambda m: m.faces.sort()):
        with pytest.raises(ValueError, match="read-only"):
            change(mended)
    assert mended.to_bytes("ply") == before


def test_named_values_refuse_changes_and_their_copies_are_free(valued):
    for change in (
        lambda data: data.__setitem__("heat", 0), lambda data: data.pop("heat"), lambda data: data.update(heat=0),
        lambda data: data.clear(), lambda data: data.setdefault("a", 0), lambda data: data.__delitem__("heat"), lambda data: data.__ior__({}),
    ):  # fmt: skip
        with pytest.raises(TypeError, match=r"read-only; give changed values to isomend.Model\(vertices, faces, point_data="):
            change(valued.point_data)
    for free in (dict(valued.point_data), valued.point_data.copy(), valued.point_data | {}, copy.deepcopy(valued.point_data)):
        free["heat"] = 1 + free["heat"]
        assert type(free) is dict
    again = pickle.loads(pickle.dumps(valued.point_data))
    again["heat"] *= 2
    scaled = isomend.Model(2 * valued.vertices, valued.faces, point_data={**valued.point_data, "heat": again["heat"]})
    assert np.array_equal(scaled.point_data["heat"], 2 * valued.point_data["heat"])
    assert isomend.fill(scaled.vertices, scaled.faces, point_data=scaled.point_data).complete


def own_arrays(mesh):
    """The arrays of a mesh of another package; pyvista's faces are always read-only."""
    if hasattr(mesh, "vertex_attributes"):
        return [mesh.vertices, mesh.faces, *mesh.vertex_attributes.values(), *mesh.face_attributes.values()]
    parts = [values for data in (mesh.point_data, mesh.cell_data) for values in (data[name] for name in data.keys())]  # noqa: SIM118
    cells = [] if hasattr(mesh, "n_points") else [block.data for block in mesh.cells]
    return [mesh.points, *cells, *(array for part in parts for array in (part if isinstance(part, list) else [part]))]


@pytest.mark.parametrize("package", ["trimesh", "pyvista", "meshio"])
def test_meshes_of_other_packages_get_arrays_of_their_own(valued, package):
    package = importlib.import_module(package) if importlib.util.find_spec(package) else pytest.skip(f"no {package}")
    vertices, faces = np.array(valued.vertices), np.array(valued.faces)
    heat = {"heat": vertices[:, 2].copy(), "flow": vertices.copy()}
    if package.__name__ == "trimesh":
        mesh = package.Trimesh(vertices, faces, process=False, vertex_attributes=heat, face_attributes={"scan": np.ones(len(faces))})
    elif package.__name__ == "pyvista":
        mesh = package.PolyData.from_regular_faces(vertices, faces)
        mesh.point_data["heat"], mesh.point_data["flow"], mesh.cell_data["scan"] = *heat.values(), np.ones(len(faces))
    else:
        mesh = package.Mesh(vertices, [("triangle", faces)], point_data=heat, cell_data={"scan": [np.ones(len(faces))]})
    done = isomend.fill_mesh(mesh)
    for array in own_arrays(done):
        assert array.flags.writeable
        array[:] = array


def test_to_trimesh_gives_arrays_of_its_own(valued):
    pytest.importorskip("trimesh")
    mended = valued.fill()
    before = mended.vertices.copy(), mended.point_data["heat"].copy(), mended.cell_data["scan"].copy()
    mesh = mended.to_trimesh()
    for array in own_arrays(mesh):
        assert array.flags.writeable
        array[:] = 0
    for old, new in zip(before, (mended.vertices, mended.point_data["heat"], mended.cell_data["scan"])):
        assert np.array_equal(old, new)
    assert mended.is_patch.any() and not mended.faces.max() == 0
