"""Report pages, pictures, the display in notebooks, and pickled results."""

import base64
import pickle
import re
import subprocess

import numpy as np
import pytest
import shapes
from conftest import DATA

import isomend

PNG = b"\x89PNG\r\n\x1a\n"


def shown(result):
    """The picture that a notebook shows."""
    text = result._repr_html_()
    return base64.b64decode(re.search(r'src="data:image/png;base64,([^"]+)"', text)[1])


def timeless(page):
    """A page without the command line, the output's name and the times."""
    page = re.sub(r'<pre id="command-line">.*?</pre>', "", page, flags=re.S)
    page = re.sub(r"<dt>(output|seconds)</dt><dd>.*?</dd>", "", page)
    return re.sub(r"<td>[\d.]+</td></tr>", "", page)


def test_the_command_line_draws_the_same_pictures_and_pages(tmp_path, program):
    drawn = ["--report", "theirs.html", "--picture", "theirs.png", "-q"]
    scan = DATA / "island.ply"
    for command, made in (("inspect", lambda model: model.inspect()), ("check", lambda model: model.check())):
        subprocess.run([program, command, scan, *drawn], cwd=tmp_path, capture_output=True)
        result = made(isomend.read(scan))
        assert shown(result) == (tmp_path / "theirs.png").read_bytes()
        assert timeless(result.page()) == timeless((tmp_path / "theirs.html").read_text())
        assert f"isomend.{command}(…)" in result.page()


@pytest.mark.parametrize("command", ["fill", "repair", "restore", "fair"])
def test_results_are_drawn_as_they_are_written(tmp_path, command):
    ball = {"balls": [[[0, 0, -1], 0.6]]}
    model = isomend.read(DATA / "sphere.ply")
    marks = {"restore": (ball,), "fair": (ball,)}.get(command, ())
    done = getattr(model, command)(*marks)
    done.write(tmp_path / "a.ply", report=tmp_path / "a.html", picture=tmp_path / "a.png")
    page = (tmp_path / "a.html").read_text()
    assert f"isomend.{command}(…)" in page and str(tmp_path / "a.ply") in page
    assert f"isomend.{command}(…)" in done.page() and "in memory" in done.page()
    # The written mesh has new vertices rounded to 32-bit floats, which changes the picture hardly at all.
    written = (tmp_path / "a.png").read_bytes()
    assert written.startswith(PNG) and abs(len(shown(done)) - len(written)) < 2000


def test_the_command_line_draws_the_same_picture_of_a_fill(tmp_path, program, sphere, filled):
    isomend.Model(*sphere).write(tmp_path / "a.obj")
    words = ["fill", "a.obj", "-o", "b.obj", "--picture", "theirs.png", "--report", "theirs.html", "-q"]
    subprocess.run([program, *words], cwd=tmp_path, check=True)
    assert filled.picture() == (tmp_path / "theirs.png").read_bytes()
    filled.write(tmp_path / "own.obj", picture=tmp_path / "own.png")
    assert (tmp_path / "own.png").read_bytes() == (tmp_path / "theirs.png").read_bytes()


def test_a_restored_region_is_drawn_with_the_damage_before():
    """The left panel shows the dent, which the result does not have."""
    vertices, faces = shapes.closed_sphere()
    dented = vertices.copy()
    dented[vertices[:, 2] > 0.9] *= 0.5
    mark = (vertices[faces][:, :, 2] > 0.8).any(axis=1)
    with_dent, without = isomend.restore(dented, faces, mark), isomend.restore(vertices, faces, mark)
    assert with_dent.picture() != without.picture()


def test_conversions_are_drawn(tmp_path, sphere):
    isomend.Model(*sphere).write(tmp_path / "a.ply")
    isomend.convert(tmp_path / "a.ply", tmp_path / "b.stl", report=tmp_path / "b.html", picture=tmp_path / "b.png")
    assert (tmp_path / "b.png").read_bytes() == isomend.read(tmp_path / "a.ply").inspect().picture()
    assert "isomend.convert(…)" in (tmp_path / "b.html").read_text()


def test_files_of_pages_and_pictures_are_checked(tmp_path, filled):
    isomend.Model(filled.vertices, filled.faces).write(tmp_path / "in.ply")
    again = isomend.read(tmp_path / "in.ply").fill()
    for files, error, what in (
        ({"report": tmp_path / "a.txt"}, isomend.ParameterError, "end its name in .html"),
        ({"picture": tmp_path / "a.jpg"}, isomend.ParameterError, "end its name in .png"),
        ({"picture": tmp_path / "none" / "a.png"}, isomend.FileError, "no folder"),
    ):
        with pytest.raises(error, match=what):
            again.write(tmp_path / "a.ply", **files)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["in.ply"]


def test_notebooks_show_text_if_drawing_fails(sphere, monkeypatch):
    found = isomend.inspect(*sphere)

    def fails(self):
        raise isomend.MeshError("no")

    monkeypatch.setattr(isomend.Inspection, "picture", fails)
    assert found._repr_html_() == "<p>isomend.Inspection of &lt;isomend.Model of 865 vertices and 1680 faces&gt; with 1 hole</p>"


def textured(folder):
    """An OBJ file of a ball with a hole: texture coordinates with a seam, two materials, a texture."""
    vertices, faces = shapes.open_sphere(around=24, latitudes=12, top=3)
    corners = vertices[faces].reshape(-1, 3)
    angles = np.arctan2(corners[:, 1], corners[:, 0]).reshape(-1, 3)
    # Faces across the seam get coordinates beyond half a turn.
    angles[(np.ptp(angles, axis=1) > np.pi)[:, None] & (angles < 0)] += 2 * np.pi
    uv = np.column_stack([angles.ravel() / (2 * np.pi), corners[:, 2]])
    lines = ["mtllib a.mtl", *(f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()), *(f"vt {u!r} {v!r}" for u, v in uv.tolist())]
    for number, face in enumerate(faces + 1):
        if number in (0, len(faces) // 2):
            lines.append("usemtl clay" if number else "usemtl glaze")
        lines.append("f " + " ".join(f"{vertex}/{3 * number + corner + 1}" for corner, vertex in enumerate(face)))
    (folder / "a.obj").write_text("\n".join(lines) + "\n")
    (folder / "a.mtl").write_text("newmtl clay\nKd 0.5 0.25 0.125\nnewmtl glaze\nKd 0.125 0.5 0.75\nmap_Kd glaze.png\n")
    return folder / "a.obj"


@pytest.mark.parametrize("name", ["a.obj", "painted.ply"])
@pytest.mark.parametrize("kind", ["obj", "ply", "glb", "vtp"])
def test_a_pickled_result_is_complete(tmp_path, name, kind):
    """Including texture coordinates of corners, materials, expected errors and marks of patches."""
    done = isomend.read(textured(tmp_path) if name == "a.obj" else DATA / name).fill()
    sent = pickle.loads(pickle.dumps(done))
    assert sent.to_bytes(kind) == done.to_bytes(kind)
    assert sent.report == done.report and sent.notes == done.notes and sent.complete == done.complete
    assert {n: v.tobytes() for n, v in sent.corner_data.items()} == {n: v.tobytes() for n, v in done.corner_data.items()}
    assert sent.sigma.tobytes() == done.sigma.tobytes() and sent.flawless == done.flawless
    sent.write(tmp_path / f"sent.{kind}")
    done.write(tmp_path / f"done.{kind}")
    assert (tmp_path / f"sent.{kind}").read_bytes() == (tmp_path / f"done.{kind}").read_bytes()
    assert sent.model().to_bytes(kind) == done.model().to_bytes(kind)
    assert pickle.loads(pickle.dumps(done.model())).to_bytes(kind) == done.model().to_bytes(kind)
    if name == "a.obj":
        (uv,) = sent.corner_data.values()
        assert uv.shape == (len(sent.faces), 3, 2) and np.isfinite(uv[~sent.is_patch]).all()
        assert {b"clay", b"glaze"} <= set(re.findall(rb"usemtl (\w+)", sent.to_bytes("obj")))


def test_a_pickled_glb_keeps_its_document(tmp_path):
    isomend.read(textured(tmp_path)).write(tmp_path / "a.glb")
    model = isomend.read(tmp_path / "a.glb")
    sent = pickle.loads(pickle.dumps(model))
    assert sent.to_bytes("glb") == model.to_bytes("glb") and sent.notes == model.notes
    done = model.restore({"balls": [[[1, 0, -0.3], 0.3]]})
    assert b"glaze" in done.to_bytes("glb")
    assert pickle.loads(pickle.dumps(done)).to_bytes("glb") == done.to_bytes("glb")


def test_all_results_can_be_pickled(sphere):
    vertices, faces = sphere
    data = {"grid": np.ones((len(vertices), 2, 2), np.float32), "on": np.ones(len(vertices), bool)}
    model = isomend.Model(vertices, faces, point_data=data)
    for work in (model.repair(skip=["holes"]), model.fair(strength=0.3), model.restore([5, 6, 7])):
        sent = pickle.loads(pickle.dumps(work))
        assert sent.vertices.tobytes() == work.vertices.tobytes() and sent.report == work.report
        assert sent.is_patch.tobytes() == work.is_patch.tobytes()
        assert sent.report["command"] != "restore" or sent.picture() == work.picture()
    sent = pickle.loads(pickle.dumps(model.fill()))
    assert sent.point_data["grid"].shape[1:] == (2, 2) and sent.point_data["on"].dtype == bool
    assert pickle.loads(pickle.dumps(model)).point_data["on"].dtype == bool
    found, verdict, volume = model.inspect(), model.check(thin=0.1), model.sdf(voxel=0.2)
    assert pickle.loads(pickle.dumps(found)).report == found.report
    assert pickle.loads(pickle.dumps(verdict)).report == verdict.report
    assert pickle.loads(pickle.dumps(volume)).to_bytes() == volume.to_bytes()
    compared = isomend.compare(model, sphere, samples=100)
    assert pickle.loads(pickle.dumps(compared)) == compared


def test_bytes_of_no_result_are_refused():
    from isomend._isomend import Mended, Model

    for kind in (Mended, Model):
        with pytest.raises(isomend.ParameterError, match="these bytes are no"):
            kind.unpacked(b"nonsense")
