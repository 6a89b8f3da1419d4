"""Meshes of trimesh, PyVista, meshio and Open3D: filled, repaired, restored and faired, with their values kept."""

import importlib
import json
import subprocess
import sys
from importlib.metadata import entry_points

import numpy as np
import pytest
import shapes

import isomend


def test_functions_take_meshes_and_files_in_place_of_arrays(sphere, filled, tmp_path):
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.Trimesh(*sphere, process=False)
    path = tmp_path / "sphere.obj"
    isomend.Model(*sphere).repair(skip=["holes"]).write(path)
    for given in (mesh, path, str(path), isomend.Model(*sphere), sphere):
        assert isomend.fill(given).faces.tolist() == filled.faces.tolist()
        assert len(isomend.inspect(given).holes) == len(filled.holes) and not isomend.check(given)
        assert isomend.repair(given).complete
    with pytest.raises(isomend.ParameterError, match="belong to vertices and faces"):
        isomend.fill(mesh, point_data={"a": sphere[0][:, 0]})
    with pytest.raises(TypeError, match="no mesh of"):
        isomend.check(7)


def test_a_result_becomes_a_trimesh_mesh(sphere, filled):
    pytest.importorskip("trimesh")
    mesh = filled.to_trimesh()
    assert mesh.is_watertight and mesh.vertices.tobytes() == filled.vertices.tobytes()
    assert np.array_equal(mesh.face_attributes["isomend_patch"], filled.is_patch)
    assert np.array_equal(mesh.vertex_attributes["isomend_sigma"], np.nan_to_num(filled.sigma, nan=-1))
    assert json.loads(mesh.metadata["isomend_report"])["holes"] == filled.report["holes"]


@pytest.fixture(scope="module")
def colours(sphere):
    return np.full((len(sphere[0]), 4), (200, 30, 10, 255), np.uint8)


def test_a_trimesh_mesh_is_filled(sphere, filled, colours):
    trimesh = pytest.importorskip("trimesh")
    mesh = trimesh.Trimesh(*sphere, process=False, vertex_attributes={"heat": sphere[0][:, 2]}, metadata={"name": "ball"})
    done = isomend.fill_mesh(mesh)
    assert type(done) is trimesh.Trimesh and done.is_watertight and done.metadata["name"] == "ball"
    assert done.vertices.tobytes() == filled.vertices.tobytes()
    assert done.vertex_attributes["heat"].shape == (len(done.vertices),)
    assert np.array_equal(done.face_attributes["isomend_patch"], filled.is_patch)
    assert np.array_equal(done.vertex_attributes["isomend_sigma"], np.nan_to_num(filled.sigma, nan=-1))
    assert not mesh.is_watertight
    painted = trimesh.Trimesh(*sphere, process=False, vertex_colors=colours)
    assert (isomend.fill_mesh(painted).visual.vertex_colors == colours[0]).all()
    faces = trimesh.Trimesh(*sphere, process=False, face_colors=np.full((len(sphere[1]), 4), 99, np.uint8))
    kept = isomend.fill_mesh(faces).visual.face_colors[: len(sphere[1])]
    assert (kept == 99).all()
    uv = np.column_stack([sphere[0][:, 0], sphere[0][:, 1]])
    textured = trimesh.Trimesh(*sphere, process=False, visual=trimesh.visual.TextureVisuals(uv=uv))
    assert isomend.fill_mesh(textured).visual.uv[: len(uv)].tobytes() == uv.tobytes()


def test_a_pyvista_mesh_is_filled(sphere, filled):
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
    errors = done.point_data["isomend_sigma"]
    assert (errors[: mesh.n_points] == 0).all() and errors.max() > 0
    quads = pyvista.Plane(i_resolution=8, j_resolution=8)
    assert isomend.fill_mesh(quads).n_cells == 128
    with pytest.raises(isomend.MeshError, match="lines"):
        isomend.fill_mesh(mesh.merge(pyvista.Line()).extract_surface(algorithm=None))
    with pytest.raises(isomend.MeshError, match="no faces"):
        isomend.fill_mesh(pyvista.PolyData())


def test_the_pyvista_accessor_fills_restores_and_fairs(sphere, filled):
    pyvista = pytest.importorskip("pyvista")
    if not hasattr(pyvista, "register_dataset_accessor"):
        pytest.skip("this pyvista has no accessors")
    # PyVista finds the accessor by itself if the package is installed; on the path alone it must be imported.
    if not entry_points(group="pyvista.accessors", name="isomend"):
        importlib.import_module("isomend._pyvista")
    mesh = pyvista.PolyData.from_regular_faces(*sphere)
    assert mesh.isomend.inspect().holes[0].edges == 48
    done = mesh.isomend.fill(voxel="auto")
    assert done.points.tobytes() == filled.vertices.tobytes()
    again = done.isomend.restore(np.asarray(done.cell_data["isomend_patch"]) == 1)
    assert again.n_open_edges == 0
    assert done.isomend.fair(strength=0.2).n_cells > 0


def test_a_meshio_mesh_is_filled(sphere, filled):
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
closed, report = isomend.repair_mesh(mesh, return_report=True)
assert closed.is_watertight() and report["complete"] and isomend.as_model(closed).check()
ball = dict(balls=[[[0, 0, -1], 0.4]])
assert isomend.restore_mesh(closed, ball).is_watertight() and isomend.fair_mesh(closed, ball, strength=0.3).is_watertight()
assert isomend.fair_mesh(closed, strength=0.3).is_watertight()
"""


def test_an_open3d_mesh_is_filled_repaired_restored_and_faired(tmp_path):
    """In a separate process, because its libraries conflict with others on some systems."""
    there = subprocess.run([sys.executable, "-c", "import open3d"], capture_output=True, text=True)
    if there.returncode:
        pytest.skip(f"open3d cannot be imported: {there.stderr.strip().splitlines()[-1:]}")
    code = OPEN3D.format(path=[str(path) for path in sys.path[:1]] + [str(__import__("pathlib").Path(__file__).parent)])
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_objects_that_are_no_mesh_are_refused():
    with pytest.raises(TypeError, match=r"builtins.dict is no mesh of trimesh"):
        isomend.fill_mesh({})


def test_pyvista_cells_are_triangulated_and_unstructured_grids_refused(sphere):
    pyvista = pytest.importorskip("pyvista")
    mixed = pyvista.Plane(i_resolution=8, j_resolution=8).clip(normal=(1, 0.3, 0), origin=(0.01, 0, 0))
    if isinstance(mixed, pyvista.PolyData):
        done, report = isomend.fill_mesh(mixed, return_report=True)
        assert done.is_all_triangles and done.n_cells > 32
        assert report["command"] == "fill"
        assert json.loads(done.field_data["isomend_report"][0])["command"] == "fill"
    with pytest.raises(TypeError, match="extract_surface"):
        isomend.fill_mesh(pyvista.PolyData.from_regular_faces(*sphere).cast_to_unstructured_grid())


def pierced():
    """A ball with a hole and turned faces, pierced by a small ball: vertices, faces, and whether each face is of the small ball."""
    vertices, faces = shapes.open_sphere(around=24, latitudes=12, top=2)
    small, of_small = shapes.closed_sphere()
    turned = faces.copy()
    turned[:40] = turned[:40, ::-1]
    every = np.vstack([turned, of_small + len(vertices)])
    return np.vstack([vertices, 0.3 * small + (0.0, 0.0, -1.0)]), every, np.arange(len(every)) >= len(faces)


def test_repair_restore_and_fair_keep_the_data_of_trimesh():
    trimesh = pytest.importorskip("trimesh")
    vertices, faces, _ = pierced()
    mesh = trimesh.Trimesh(vertices, faces, process=False, vertex_attributes={"heat": vertices[:, 2]}, metadata={"name": "ball"})
    mended, report = isomend.repair_mesh(mesh, return_report=True)
    assert type(mended) is trimesh.Trimesh and mended.is_watertight and mended.is_winding_consistent
    assert report["command"] == "repair" and report["complete"] and mended.metadata["name"] == "ball"
    assert json.loads(mended.metadata["isomend_report"])["steps"] == report["steps"]
    assert mended.vertices.tobytes() == isomend.repair(vertices, faces).vertices.tobytes()
    ball = trimesh.Trimesh(*shapes.closed_sphere(), process=False, vertex_colors=np.full((len(shapes.closed_sphere()[0]), 4), 77, np.uint8))
    mark = ball.triangles_center[:, 2] > 0.8
    restored = isomend.restore_mesh(ball, mark)
    assert restored.is_watertight and restored.face_attributes["isomend_patch"].any() and (restored.visual.vertex_colors == 77).all()
    assert json.loads(restored.metadata["isomend_report"])["command"] == "restore"
    part = isomend.fair_mesh(ball, mark, strength=0.3)
    assert part.is_watertight and (part.visual.vertex_colors == 77).all()
    # Fairing the whole mesh replaces all faces, so that no colours are known.
    whole, report = isomend.fair_mesh(ball, strength=0.3, return_report=True)
    assert whole.is_watertight and report["command"] == "fair" and whole.face_attributes["isomend_patch"].all()
    with pytest.raises(isomend.EmptyMaskError):
        isomend.restore_mesh(ball, np.zeros(len(ball.faces), bool))
    model = isomend.as_model(ball)
    assert model.check() and model.point_data["vertex_colors"].shape[1] == 4
    assert isomend.compare(ball, restored).a_to_b.max < 0.01


def test_repair_restore_and_fair_work_on_pyvista(sphere):
    pyvista = pytest.importorskip("pyvista")
    vertices, faces, _ = pierced()
    mesh = pyvista.PolyData.from_regular_faces(vertices, faces)
    mesh.point_data["heat"] = vertices[:, 2]
    mended, report = isomend.repair_mesh(mesh, return_report=True)
    assert type(mended) is pyvista.PolyData and mended.n_open_edges == 0 and mended.is_manifold
    assert report["complete"] and len(mended.point_data["heat"]) == mended.n_points
    assert json.loads(mended.field_data["isomend_report"][0])["command"] == "repair"
    ball = pyvista.PolyData.from_regular_faces(*shapes.closed_sphere())
    mark = ball.cell_centers().points[:, 2] > 0.8
    assert isomend.restore_mesh(ball, mark).n_open_edges == 0
    assert isomend.fair_mesh(ball, mark, strength=0.3).n_open_edges == 0
    assert isomend.as_model(ball).check().sound and not isomend.as_model(pyvista.PolyData.from_regular_faces(*sphere)).check()
    if hasattr(pyvista, "register_dataset_accessor"):
        importlib.import_module("isomend._pyvista")
        assert not mesh.isomend.check() and mesh.isomend.repair().isomend.check().sound


def test_repair_restore_and_fair_keep_the_blocks_of_meshio():
    """Blocks of cells are kept, although a repair removes and turns cells."""
    meshio = pytest.importorskip("meshio")
    vertices, faces, small = pierced()
    blocks = [("triangle", faces[~small]), ("triangle", faces[small])]
    data = {"ball": [np.zeros((~small).sum(), int), np.ones(small.sum(), int)]}
    mesh = meshio.Mesh(vertices, blocks, cell_data=data, point_data={"heat": vertices[:, 2]}, info={"name": "balls"})
    mended, report = isomend.repair_mesh(mesh, return_report=True)
    assert type(mended) is meshio.Mesh and shapes.is_closed(np.concatenate([block.data for block in mended.cells]))
    assert [set(values.tolist()) for values in mended.cell_data["ball"][:2]] == [{0}, {1}]
    assert [values.sum() for values in mended.cell_data["isomend_patch"][:2]] == [0, 0] and "isomend_block" not in mended.cell_data
    assert report["lost_faces"] > 0 and mended.cell_data["isomend_patch"][2].all()
    assert mended.info["name"] == "balls" and mesh.info == {"name": "balls"}
    assert json.loads(mended.info["isomend_report"])["steps"] == report["steps"]
    ball = meshio.Mesh(shapes.closed_sphere()[0], [("triangle", shapes.closed_sphere()[1])])
    restored = isomend.restore_mesh(ball, {"balls": [[[0, 0, 1], 0.5]]})
    assert [len(block.data) > 0 for block in restored.cells] == [True, True]
    whole = isomend.fair_mesh(ball, strength=0.3)
    assert len(whole.cells[0].data) == 0 and shapes.is_closed(whole.cells[1].data)
    assert json.loads(whole.info["isomend_report"])["command"] == "fair"
