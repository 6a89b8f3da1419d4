"""Meshes of other packages."""

import json
import subprocess
import sys

import numpy as np
import pytest
import shapes

import isomend


@pytest.fixture(scope="module")
def colours(sphere):
    return np.full((len(sphere[0]), 4), (200, 30, 10, 255), np.uint8)


def test_trimesh(sphere, filled, colours):
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.Trimesh(*sphere, process=False, vertex_attributes={"heat": sphere[0][:, 2]}, metadata={"name": "ball"})
    done = isomend.fill_mesh(mesh)
    assert type(done) is trimesh.Trimesh and done.is_watertight and done.metadata["name"] == "ball"
    assert done.vertices.tobytes() == filled.vertices.tobytes()
    assert done.vertex_attributes["heat"].shape == (len(done.vertices),)
    assert np.array_equal(done.face_attributes["isomend_patch"], filled.is_patch)
    assert not mesh.is_watertight
    painted = trimesh.Trimesh(*sphere, process=False, vertex_colors=colours)
    assert (isomend.fill_mesh(painted).visual.vertex_colors == colours[0]).all()
    faces = trimesh.Trimesh(*sphere, process=False, face_colors=np.full((len(sphere[1]), 4), 99, np.uint8))
    kept = isomend.fill_mesh(faces).visual.face_colors[: len(sphere[1])]
    assert (kept == 99).all()
    uv = np.column_stack([sphere[0][:, 0], sphere[0][:, 1]])
    textured = trimesh.Trimesh(*sphere, process=False, visual=trimesh.visual.TextureVisuals(uv=uv))
    assert isomend.fill_mesh(textured).visual.uv[: len(uv)].tobytes() == uv.tobytes()


def test_pyvista(sphere, filled):
    pyvista = pytest.importorskip("pyvista")
    mesh = pyvista.PolyData.from_regular_faces(sphere[0].astype(np.float32), sphere[1])
    mesh.point_data["heat"] = sphere[0][:, 2]
    mesh.cell_data["scan"] = np.full(mesh.n_cells, 3)
    mesh.field_data["name"] = ["ball"]
    mesh.set_active_scalars("heat")
    done = isomend.fill_mesh(mesh, threads=1)
    assert type(done) is pyvista.PolyData and done.n_open_edges == 0 and done.points.dtype == np.float32
    assert done.points[: mesh.n_points].tobytes() == mesh.points.tobytes()
    assert done.active_scalars_name == "heat" and list(done.field_data["name"]) == ["ball"]
    assert (done.cell_data["scan"][: mesh.n_cells] == 3).all()
    assert done.cell_data["isomend_patch"].sum() == filled.is_patch.sum()
    quads = pyvista.Plane(i_resolution=8, j_resolution=8)
    assert isomend.fill_mesh(quads).n_cells == 128
    with pytest.raises(isomend.MeshError, match="lines"):
        isomend.fill_mesh(mesh.merge(pyvista.Line()).extract_surface(algorithm=None))
    with pytest.raises(isomend.MeshError, match="no faces"):
        isomend.fill_mesh(pyvista.PolyData())


def test_the_accessor_of_pyvista(sphere, filled):
    pyvista = pytest.importorskip("pyvista")
    if not hasattr(pyvista, "register_dataset_accessor"):
        pytest.skip("this pyvista has no accessors")
    mesh = pyvista.PolyData.from_regular_faces(*sphere)
    assert mesh.isomend.inspect().holes[0].edges == 48
    done = mesh.isomend.fill(voxel="auto")
    assert done.points.tobytes() == filled.vertices.tobytes()
    again = done.isomend.restore(np.asarray(done.cell_data["isomend_patch"]) == 1)
    assert again.n_open_edges == 0
    assert done.isomend.fair(strength=0.2).n_cells > 0


def test_meshio(sphere, filled):
    meshio = pytest.importorskip("meshio")
    vertices, faces = sphere
    blocks = [("triangle", faces[:100]), ("triangle", faces[100:])]
    data = {"scan": [np.zeros(100, int), np.ones(len(faces) - 100, int)]}
    mesh = meshio.Mesh(vertices, blocks, point_data={"heat": vertices[:, 2]}, cell_data=data)
    done = isomend.fill_mesh(mesh)
    assert type(done) is meshio.Mesh and [len(block.data) for block in done.cells[:2]] == [100, len(faces) - 100]
    assert done.points.tobytes() == filled.vertices.tobytes()
    assert [values.sum() for values in done.cell_data["isomend_patch"]] == [0, 0, filled.is_patch.sum()]
    assert (done.cell_data["scan"][1] == 1).all() and len(done.point_data["heat"]) == len(done.points)
    with pytest.raises(isomend.MeshError, match="quad"):
        isomend.fill_mesh(meshio.Mesh(vertices, [("quad", [[0, 1, 2, 3]])]))


OPEN3D = """
import sys; sys.path[:0] = {path!r}
import numpy as np, open3d, isomend, shapes
vertices, faces = shapes.open_sphere()
mesh = open3d.geometry.TriangleMesh(
    open3d.utility.Vector3dVector(vertices), open3d.utility.Vector3iVector(faces.astype(np.int32)))
mesh.compute_vertex_normals()
mesh.paint_uniform_color((0.25, 0.5, 0.75))
done = isomend.fill_mesh(mesh)
assert type(done) is type(mesh) and done.is_watertight()
assert np.asarray(done.vertices).tobytes() == isomend.fill(vertices, faces).vertices.tobytes()
assert np.allclose(np.asarray(done.vertex_colors), (0.25, 0.5, 0.75), atol=1e-6)
normals = np.asarray(done.vertex_normals)
assert np.abs((normals * np.asarray(done.vertices)).sum(axis=1) - 1).max() < 0.02
"""


def test_open3d(tmp_path):
    """In a process of its own: its libraries do not go with those of others everywhere."""
    there = subprocess.run([sys.executable, "-c", "import open3d"], capture_output=True, text=True)
    if there.returncode:
        pytest.skip(f"open3d cannot be imported: {there.stderr.strip().splitlines()[-1:]}")
    code = OPEN3D.format(path=[str(path) for path in sys.path[:1]] + [str(__import__("pathlib").Path(__file__).parent)])
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_what_is_no_mesh_is_refused():
    with pytest.raises(TypeError, match=r"builtins.dict is no mesh of trimesh"):
        isomend.fill_mesh({})


def test_pyvista_meshes_of_several_kinds_of_cells(sphere):
    pyvista = pytest.importorskip("pyvista")
    mixed = pyvista.Plane(i_resolution=8, j_resolution=8).clip(normal=(1, 0.3, 0), origin=(0.01, 0, 0))
    if isinstance(mixed, pyvista.PolyData):
        done, report = isomend.fill_mesh(mixed, return_report=True)
        assert done.is_all_triangles and done.n_cells > 32
        assert report["command"] == "fill"
        assert json.loads(done.field_data["isomend_report"][0])["command"] == "fill"
    with pytest.raises(TypeError, match="extract_surface"):
        isomend.fill_mesh(pyvista.PolyData.from_regular_faces(*sphere).cast_to_unstructured_grid())
