"""`restore` and `fair` on arrays, meshes and paths; messages on masks; short forms of results and reports."""

import json
import pickle

import numpy as np
import pytest
import shapes

import isomend


@pytest.fixture(scope="module")
def ball():
    vertices, faces = shapes.closed_sphere()
    return vertices, faces, vertices[faces].mean(axis=1)[:, 2] > 0.9


def same(a, b):
    return a.vertices.tobytes() == b.vertices.tobytes() and a.faces.tobytes() == b.faces.tobytes()


def test_a_mesh_or_a_path_stands_in_place_of_vertices_and_faces(ball, tmp_path):
    vertices, faces, mark = ball
    model = isomend.Model(vertices, faces)
    path = tmp_path / "ball.ply"
    model.write(path)
    restored = isomend.restore(vertices, faces, mark)
    for mesh in (model, (vertices, faces), [vertices, faces], path, str(path)):
        assert same(isomend.restore(mesh, mark), restored)
        assert same(isomend.restore(mesh, mark=mark), restored)
    again = isomend.restore(restored, restored.is_patch)
    assert again.report["removed_faces"] >= restored.is_patch.sum()
    part = isomend.fair(vertices, faces, mark, strength=0.4)
    for mesh in (model, (vertices, faces), path):
        assert same(isomend.fair(mesh, mark, strength=0.4), part)
        assert same(isomend.fair(mesh, mark=mark, strength=0.4), part)
    assert same(isomend.fair(model, strength=0.4), isomend.fair(vertices, faces, strength=0.4))


def test_a_mesh_of_another_package_stands_there_too(ball):
    trimesh = pytest.importorskip("trimesh")
    vertices, faces, mark = ball
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    assert same(isomend.restore(mesh, mark), isomend.restore(vertices, faces, mark))
    assert same(isomend.fair(mesh, mark, strength=0.4), isomend.fair(vertices, faces, mark, strength=0.4))


def test_what_is_missing_or_of_another_type_is_named(ball):
    vertices, faces, mark = ball
    with pytest.raises(isomend.ParameterError, match=r"needs a mask: restore\(vertices, faces, mark\), or restore\(mesh, mark\)"):
        isomend.restore(vertices, faces)
    with pytest.raises(isomend.ParameterError, match="needs a mask"):
        isomend.restore(isomend.Model(vertices, faces))
    with pytest.raises(TypeError, match="faces are missing"):
        isomend.restore(vertices, mark=mark)
    with pytest.raises(isomend.ParameterError, match="point_data"):
        isomend.restore((vertices, faces), mark, point_data={"a": vertices[:, 0]})
    with pytest.raises(isomend.FileError, match="none.ply"):
        isomend.fair("none.ply", mark)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (lambda mark: mark[:5], r"the mask has 5 marks for \d+ faces, the shape \(5,\)"),
        (lambda mark: {"faces": mark[:5]}, r"'faces' of the mask has 5 marks for \d+ faces, the shape \(5,\)"),
        (lambda mark: {"faces": np.zeros((4, 3), bool)}, r"'faces' of the mask must .* its shape is \(4, 3\)"),
        (lambda mark: {"faces": np.array([0.5])}, "'faces' of the mask must be of the type bool, .* float64"),
        (lambda mark: {"faces": [10**6]}, "'faces' of the mask names face 1000000"),
        (lambda mark: mark[:, None], r"the mask must .* its shape is \(\d+, 1\)"),
    ],
)
def test_errors_of_masks_name_the_key_and_the_shape(ball, given, said):
    vertices, faces, mark = ball
    for mesh in ((vertices, faces), isomend.Model(vertices, faces)):
        with pytest.raises(isomend.ParameterError, match=said):
            isomend.restore(mesh, given(mark))


def test_results_and_reports_print_in_one_short_line(ball):
    vertices, faces, _ = ball
    kept = vertices[faces].mean(axis=1)[:, 2] < 0.8
    filled = isomend.fill(vertices, faces[kept])
    text = repr(filled)
    assert text.startswith(f"<isomend.Mended of {len(filled.vertices)} vertices and {len(filled.faces)} faces, ")
    assert text.endswith(f"{filled.is_patch.sum()} of them new: 1 hole closed>")
    assert repr(isomend.fill(vertices, faces[kept], keep_open=[1])).endswith("0 of them new: 1 hole left open>")
    report = filled.report
    assert repr(report).startswith("<isomend report of fill: complete, 1 closed; keys: command, version")
    assert len(repr(report)) < 500 and "\n" not in repr(report)
    assert isinstance(report, dict) and json.loads(json.dumps(report)) == report
    assert pickle.loads(pickle.dumps(report)) == report and repr(pickle.loads(pickle.dumps(report))) == repr(report)
    verdict = isomend.check(vertices, faces[kept])
    assert repr(verdict.report).startswith("<isomend report of check: not sound; keys: ")
    assert repr(isomend.inspect(vertices, faces).report).startswith("<isomend report of inspect; keys: ")
    compared = isomend.compare((vertices, faces), filled)
    assert repr(compared).startswith("<isomend.Comparison: A to B at most ") and len(repr(compared)) < 200
    rows = str(compared).splitlines()
    assert rows[0].startswith(f"A: {len(vertices)} vertices, {len(faces)} faces, area ") and rows[3].split()[:3] == ["A", "to", "B"]
    assert rows[-1].startswith("kept in B bit for bit: ") and str(pickle.loads(pickle.dumps(compared))) == str(compared)
    hole = isomend.inspect(vertices, faces[kept]).holes[0]
    assert repr(hole).startswith(f"Hole(id=1, rim=<{hole.edges} vertices>, edges={hole.edges}, ") and "array" not in repr(hole)
    defect = verdict.defects["boundary_edge"]
    assert f"count={hole.edges}, faces=<{len(defect.faces)} faces>, places=<1 places>" in repr(defect)
