"""What results carry in the meshes of other packages: texture coordinates across seams, expected errors of each run, remarks."""

import json
import logging

import numpy as np
import pytest
import shapes

import isomend


def seamed_ball():
    """A ball with a hole at its top, whose rim crosses a seam of the texture: vertices, faces, texture coordinates."""
    vertices, faces = shapes.open_sphere()
    u = np.arctan2(vertices[:, 1], vertices[:, 0]) / (2 * np.pi) % 1
    across = np.ptp(u[faces], axis=1) > 0.5
    # Faces across the seam use copies of its right side, with coordinates beyond a whole turn.
    right = np.unique(faces[across][u[faces[across]] < 0.5])
    copies = np.arange(len(vertices))
    copies[right] = len(vertices) + np.arange(len(right))
    turned = faces.copy()
    turned[across] = copies[faces[across]]
    uv = np.column_stack([np.append(u, u[right] + 1), np.append(vertices[:, 2], vertices[right, 2]) / 2 + 0.5])
    return np.vstack([vertices, vertices[right]]), turned, uv


SEAM = "patches without texture coordinates, because their rims cross seams of the texture: 1 of 1"


def textured(trimesh):
    vertices, faces, uv = seamed_ball()
    return trimesh.Trimesh(vertices, faces, process=False, visual=trimesh.visual.TextureVisuals(uv=uv))


def is_near_the_rim(uv, whole, kept):
    """Whether texture coordinates are whole, and new vertices have coordinates of the rim, which is the highest ring."""
    rim = {tuple(row) for row in uv[uv[:, 1] == uv[:, 1].max()]}
    return np.isfinite(whole).all() and np.array_equal(whole[:kept], uv) and {tuple(row) for row in whole[kept:]} <= rim


def test_texture_coordinates_across_a_seam_are_whole_and_said_in_trimesh(caplog):
    trimesh = pytest.importorskip("trimesh")
    mesh = textured(trimesh)
    kept = len(mesh.vertices)
    with caplog.at_level(logging.WARNING, logger="isomend"):
        done, report = isomend.fill_mesh(mesh, return_report=True)
    assert len(done.vertices) > kept + 100 and is_near_the_rim(mesh.visual.uv, done.visual.uv, kept)
    said = report["notes"]
    assert said[0] == SEAM and said[1].startswith("uv: ") and "of the nearest vertex of the rim" in said[1] and len(said) == 2
    assert [record.getMessage() for record in caplog.records] == said
    assert json.loads(done.metadata["isomend_report"])["notes"] == said
    whole = isomend.read(done.export(file_type="glb"))
    assert np.isfinite(whole.point_data["TEXCOORD_0"]).all() and len(whole.faces) == len(done.faces)
    # Values of a result have a mark where there are none: NaN.
    result = isomend.as_model(mesh).fill()
    assert np.isnan(result.point_data["uv"][kept:]).any() and result.notes == [SEAM]
    as_trimesh = result.to_trimesh()
    assert is_near_the_rim(mesh.visual.uv, as_trimesh.vertex_attributes["uv"], kept)
    assert json.loads(as_trimesh.metadata["isomend_report"])["notes"] == said


def test_texture_coordinates_of_a_patch_are_from_the_chart_with_most_of_its_rim():
    """Two charts far from each other in the texture: faces of the patch would run across all between them."""
    trimesh = pytest.importorskip("trimesh")
    vertices, faces = shapes.open_sphere()
    other = vertices[faces].mean(axis=1)[:, 1] > 0.2
    shared = faces.copy()
    shared[other] += len(vertices)
    used, turned = np.unique(shared, return_inverse=True)
    both = np.vstack([vertices, vertices])[used]
    uv = both[:, :2] + 100.0 * (used >= len(vertices))[:, None]
    mesh = trimesh.Trimesh(both, turned.reshape(-1, 3), process=False, visual=trimesh.visual.TextureVisuals(uv=uv))
    done = isomend.fill_mesh(mesh).visual.uv
    assert np.array_equal(done[: len(uv)], uv) and len(done) > len(uv) + 100
    assert done[len(uv):].max() < 1 and len(np.unique(done[len(uv):], axis=0)) > 20


def test_texture_coordinates_of_a_file_are_whole_in_trimesh(tmp_path):
    pytest.importorskip("trimesh")
    vertices, faces, uv = seamed_ball()
    model = isomend.Model(vertices, faces, point_data={"uv": uv})
    for ending in ("glb", "ply", "vtp", "usda"):
        model.write(tmp_path / f"ball.{ending}")
        done = isomend.read(tmp_path / f"ball.{ending}").fill().to_trimesh()
        values = [array for array in done.vertex_attributes.values() if array.shape[1:] == (2,)]
        assert len(values) == 1 and np.isfinite(values[0]).all(), ending
        assert json.loads(done.metadata["isomend_report"])["notes"][0] == SEAM, ending


def test_texture_coordinates_across_a_seam_are_whole_in_pyvista_and_meshio():
    vertices, faces, uv = seamed_ball()
    pyvista = pytest.importorskip("pyvista")
    mesh = pyvista.PolyData.from_regular_faces(vertices, faces)
    mesh.point_data["Texture Coordinates"] = uv
    done, report = isomend.fill_mesh(mesh, return_report=True)
    assert is_near_the_rim(uv, np.asarray(done.point_data["Texture Coordinates"]), len(vertices)) and len(report["notes"]) == 2
    meshio = pytest.importorskip("meshio")
    done = isomend.fill_mesh(meshio.Mesh(vertices, [("triangle", faces)], point_data={"uv": uv}))
    assert is_near_the_rim(uv, done.point_data["uv"], len(vertices))
    assert len(json.loads(done.info["isomend_report"])["notes"]) == 2


def test_a_texture_that_goes_through_is_no_remark():
    trimesh = pytest.importorskip("trimesh")
    vertices, faces = shapes.open_sphere()
    visual = trimesh.visual.TextureVisuals(uv=vertices[:, :2])
    done, report = isomend.fill_mesh(trimesh.Trimesh(vertices, faces, process=False, visual=visual), return_report=True)
    assert report["notes"] == [] and np.isfinite(done.visual.uv).all() and len(np.unique(done.visual.uv[len(vertices):], axis=0)) > 100


def test_a_mesh_faired_as_a_whole_has_no_texture():
    trimesh = pytest.importorskip("trimesh")
    vertices, faces = shapes.closed_sphere()
    visual = trimesh.visual.TextureVisuals(uv=vertices[:, :2])
    done = isomend.fair_mesh(trimesh.Trimesh(vertices, faces, process=False, visual=visual), strength=0.3)
    assert done.is_watertight and done.visual.kind != "texture"


def cube_without_a_face():
    """A cube of twelve triangles without one: its patch is a triangle between vertices of the rim."""
    faces = [[0, 2, 1], [0, 3, 2], [4, 5, 6], [4, 6, 7], [0, 1, 5], [0, 5, 4], [1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6], [3, 0, 4]]
    square = [[0, 0], [1, 0], [1, 1], [0, 1]]
    return np.array([[*corner, z] for z in (0, 1) for corner in square], float), np.array(faces)


def test_expected_errors_are_there_when_none_is_known():
    """0 for the mesh's own vertices, -1 where unknown."""
    trimesh = pytest.importorskip("trimesh")
    cube = trimesh.Trimesh(*cube_without_a_face(), process=False)
    assert isomend.fill_mesh(cube).vertex_attributes["isomend_sigma"].tolist() == [0] * 8
    assert isomend.fill(cube).to_trimesh().vertex_attributes["isomend_sigma"].tolist() == [0] * 8
    ball = trimesh.Trimesh(*shapes.closed_sphere(), process=False)
    faired = isomend.fair_mesh(ball, strength=0.3)
    assert (faired.vertex_attributes["isomend_sigma"] == -1).all() and len(faired.vertices) > 100


def test_expected_errors_of_an_earlier_run_stay():
    trimesh = pytest.importorskip("trimesh")
    vertices, faces = shapes.open_ends()
    once = isomend.fill_mesh(trimesh.Trimesh(vertices, faces, process=False), holes=[1])
    errors = once.vertex_attributes["isomend_sigma"]
    twice = isomend.fill_mesh(once, holes=[1])
    assert twice.is_watertight and (errors > 0).sum() > 100
    assert np.array_equal(twice.vertex_attributes["isomend_sigma"][: len(errors)], errors)
    third = isomend.restore_mesh(twice, {"balls": [[[0, 1, 0], 0.2]]}).vertex_attributes["isomend_sigma"]
    assert np.isin(errors[errors > 0], third).all() and (third > 0).sum() > (errors > 0).sum()
