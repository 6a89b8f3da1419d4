"""Invalid input and parameters, progress, cancellation, threads and logging."""

import errno
import logging
import os
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest
import shapes

import isomend

TRIANGLE = ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])


@pytest.mark.parametrize(
    ("vertices", "faces", "what"),
    [
        (TRIANGLE[0], np.zeros((0, 3), int), "no faces"),
        (TRIANGLE[0], [[0, 1, 3]], "face 0 refers to vertex 3, but there are only 3"),
        ([[0, 0, 0]], TRIANGLE[1], "face 0 refers to vertex 1, but there is only 1 vertex, numbered"),
        (TRIANGLE[0], [[0, 1, -1]], "vertex -1"),
        (TRIANGLE[0], [[0, 1, 2.5]], "whole numbers"),
        (TRIANGLE[0], [[0, 1, np.nan]], "whole numbers"),
        (TRIANGLE[0], [[0, 1, 1e300]], "not there"),
        (TRIANGLE[0], [[0, 1, 2, 0]], "triangles first"),
        (TRIANGLE[0], [0, 1, 2], r"shape is \(3,\)"),
        ([[0, 0], [1, 0], [0, 1]], TRIANGLE[1], "shape"),
        ([[0, 0, np.inf], [1, 0, 0], [0, 1, 0]], TRIANGLE[1], "not a finite number"),
        ([[0, 0, 0], [1, 0]], TRIANGLE[1], "vertices cannot be made an array, such as rows of different lengths"),
        ([["a", 0, 0]] * 3, TRIANGLE[1], "must be numbers"),
        (np.zeros((3, 3), complex), TRIANGLE[1], "must be numbers"),
        ([[2**53 + 1, 0, 0], [1, 0, 0], [0, 1, 0]], TRIANGLE[1], "beyond"),
        ([[0, 0, 1e300], [1, 0, 0], [0, 1, 0]], TRIANGLE[1], "too large"),
    ],
)
def test_invalid_meshes_are_refused(vertices, faces, what):
    with pytest.raises(isomend.MeshError, match=what):
        isomend.fill(vertices, faces)
    with pytest.raises(ValueError, match=what):
        isomend.inspect(vertices, faces)


@pytest.mark.parametrize(
    ("options", "error", "what"),
    [
        ({"holes": [2]}, isomend.HoleIdError, "there is no hole 2; the mesh has 1"),
        ({"keep_open": [0]}, IndexError, "there is no hole 0"),
        ({"holes": [-1]}, isomend.ParameterError, "negative"),
        ({"holes": 1}, isomend.ParameterError, "list of hole numbers"),
        ({"holes": [1.5]}, isomend.ParameterError, "whole number"),
        ({"voxel": -1}, ValueError, "voxel must be a positive number"),
        ({"voxel": float("nan")}, isomend.ParameterError, "voxel must be a positive number"),
        ({"voxel": "small"}, isomend.ParameterError, "voxel must be a positive number or 'auto', but is 'small'"),
        ({"voxel": 1e-9}, isomend.ParameterError, "too large a grid"),
        ({"energy": "wilmore"}, isomend.ParameterError, "energy must be one of 'willmore', 'curvature-variation'"),
        ({"voxel": True}, isomend.ParameterError, "voxel must be a positive number or 'auto', but is True"),
        ({"max_diameter": 0}, isomend.ParameterError, "max_diameter must be a positive number"),
        ({"edge_ratio": 50}, isomend.ParameterError, "edge_ratio must be a number between 0.05 and 20"),
        ({"threads": 0}, isomend.ParameterError, "threads must be a whole number from 1"),
        ({"threads": 5000}, isomend.ParameterError, "1024 at most"),
        ({"threads": -1}, isomend.ParameterError, "threads"),
        ({"max_diameter": np.inf}, isomend.ParameterError, "max_diameter must be a finite number, but is inf; leave out what has no bound"),
        ({"max_diameter": 10**400}, isomend.ParameterError, "max_diameter must be a number"),
        ({"base_offset": np.inf}, isomend.ParameterError, "base_offset must be a finite number"),
        ({"voxel": np.inf}, isomend.ParameterError, "voxel must be a positive number or 'auto', but is inf"),
        ({"holes": "every"}, isomend.ParameterError, r"holes must be a list of hole numbers, such as \[1\], or 'all', but is 'every'"),
        ({"keep_open": "all"}, isomend.ParameterError, r"such as \[1\], but is 'all'"),
    ],
)
def test_invalid_parameters_are_refused(sphere, options, error, what):
    with pytest.raises(error, match=what) as caught:
        isomend.fill(*sphere, **options)
    assert isinstance(caught.value, isomend.IsomendError)


def test_an_unknown_parameter_of_a_model_is_named(sphere):
    with pytest.raises(isomend.ParameterError, match=r"fill has no parameter 'hole' \(is holes meant\?\); it has holes, max_diameter, "):
        isomend.Model(*sphere).fill(hole=[1])


def test_masks_that_mark_nothing_or_do_not_fit_are_refused(sphere):
    vertices, faces = sphere
    none = np.zeros(len(faces), bool)
    for mark in (none, [], {"balls": [[[9, 9, 9], 0.1]]}):
        with pytest.raises(isomend.EmptyMaskError):
            isomend.restore(vertices, faces, mark)
    with pytest.raises(ValueError, match="3 marks for"):
        isomend.restore(vertices, faces, none[:3])
    with pytest.raises(isomend.ParameterError, match="only"):
        isomend.restore(vertices, faces, [len(faces)])
    with pytest.raises(isomend.ParameterError, match="float64"):
        isomend.restore(vertices, faces, [0.5])


def test_values_that_do_not_fit_are_refused(sphere):
    vertices, faces = sphere
    for data in ({"a": [1.0]}, {"a": ["x"] * len(vertices)}, {"a": np.full(len(vertices), 2**60)}, {"a": 1.0}):
        with pytest.raises(isomend.ParameterError, match="'a'"):
            isomend.fill(vertices, faces, point_data=data)


def test_files_that_cannot_be_read_or_written_are_named(tmp_path, filled):
    with pytest.raises(isomend.FileError, match="none.ply"):
        isomend.read(tmp_path / "none.ply")
    (tmp_path / "bad.ply").write_text("ply\nformat ascii 1.0\nelement vertex 9\nend_header\n")
    with pytest.raises(OSError, match="bad.ply"):
        isomend.read(tmp_path / "bad.ply")
    with pytest.raises(isomend.FileError, match="no folder"):
        filled.write(tmp_path / "no" / "a.ply")
    with pytest.raises(isomend.ParameterError, match="no extension of a known mesh format"):
        filled.write(tmp_path / "a.xyz")
    with pytest.raises(isomend.ParameterError, match="there is no format 'xyz'"):
        filled.to_bytes("xyz")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bad.ply"]


def test_files_are_named_as_by_errors_of_python(tmp_path, filled):
    cases = [
        (lambda: isomend.read(tmp_path / "none.ply"), errno.ENOENT, "none.ply"),
        (lambda: isomend.read(tmp_path), errno.EISDIR, ""),
        (lambda: filled.write(tmp_path / "no" / "a.ply"), errno.ENOENT, "a.ply"),
    ]
    for call, number, name in cases:
        with pytest.raises(isomend.FileError) as caught:
            call()
        assert caught.value.errno == number and caught.value.filename.endswith(name), caught.value
    (tmp_path / "bad.ply").write_text("ply\n")
    with pytest.raises(isomend.FileError) as caught:
        isomend.read(tmp_path / "bad.ply")
    assert caught.value.errno is None and caught.value.filename.endswith("bad.ply")


@pytest.mark.parametrize(
    ("mask", "said"),
    [
        ({"boxes": [[0, 0, 0], [1, 1, 1]]}, r"boxes must be .* \[\[x, y, z\], \[x, y, z\]\]"),
        ({"boxes": [[[0, 0], [1, 1, 1]]]}, "boxes"),
        ({"balls": [0, 0, 0, 1]}, r"balls must be .* \[\[x, y, z\], radius\]"),
        ({"balls": [[[0, 0, 0], -1]]}, "balls"),
        ({"colours": ["ff00"]}, "colours needs six hexadecimal digits"),
        ({"colours": ["ff0000,256"]}, "tolerance from 0 to 255"),
        ({"colours": ["ff0000,1.2.3"]}, "tolerance from 0 to 255"),
        ({"colours": [{"rgb": [255, 0, 0]}]}, "colours must have numbers from 0 to 1"),
        ({"colours": [{"red": 1}]}, "colours must be a text such as"),
        ({"inside": [3]}, "inside of the mask must be closed meshes, .* but builtins.int is no mesh"),
        ({"inside": {"a": 1}}, "inside of the mask .* builtins.dict is no mesh"),
        ({"inside": isomend.Volume(np.zeros((2, 2, 2)))}, "inside of the mask .* this is a volume, not a mesh"),
        ({"inside": isomend.Model(*TRIANGLE)}, "^mesh 1 of inside cannot be used as a mask: its surface is not closed"),
        ({"materials": [1]}, "materials"),
        ({"grow": "far"}, "grow"),
        ({"box": []}, "'box'.*boxes"),
    ],
)
def test_errors_of_masks_name_their_part(sphere, mask, said):
    with pytest.raises(isomend.ParameterError, match=said) as caught:
        isomend.restore(*sphere, mask)
    assert "f64" not in str(caught.value) and "struct" not in str(caught.value)


@pytest.mark.parametrize(
    ("short", "long"),
    [
        ({"balls": [[0, 0, -1, 0.4]]}, {"balls": [[[0, 0, -1], 0.4]]}),
        ({"balls": np.array([[0, 0, -1, 0.4]])}, {"balls": [[[0, 0, -1], 0.4]]}),
        ({"boxes": [[-1, -1, -2, 1, 1, -0.9]]}, {"boxes": [[[-1, -1, -2], [1, 1, -0.9]]]}),
        ({"colours": "ff8000"}, {"colours": [{"rgb": [1, 128 / 255, 0], "tolerance": 0}]}),
        ({"colours": ["#FF8000,51"]}, {"colours": [{"rgb": [1, 128 / 255, 0], "tolerance": 0.2}]}),
        ({"colours": [{"rgb": [1, 128 / 255, 0]}]}, {"colours": "ff8000"}),
    ],
)
def test_masks_have_short_forms(sphere, short, long):
    vertices, faces = sphere
    colours = np.zeros((len(vertices), 3))
    colours[vertices[:, 2] < -0.9] = (1, 128 / 255, 0)
    model = isomend.Model(vertices, faces, point_data={"colors": colours})
    done, same = model.restore(short), model.restore(long)
    assert done.report["removed_faces"] > 0 and done.vertices.tobytes() == same.vertices.tobytes()


def test_the_path_of_a_mask_may_stand_alone(sphere, tmp_path):
    ball = isomend.Model(0.4 * shapes.closed_sphere()[0] + (0, 0, -1), shapes.closed_sphere()[1])
    ball.write(tmp_path / "inside.ply")
    alone = isomend.restore(*sphere, {"inside": tmp_path / "inside.ply"})
    assert alone.report["removed_faces"] > 0
    assert alone.vertices.tobytes() == isomend.restore(*sphere, {"inside": [str(tmp_path / "inside.ply")]}).vertices.tobytes()
    for given in (ball, [ball, tmp_path / "inside.ply"]):
        assert alone.vertices.tobytes() == isomend.restore(*sphere, {"inside": given}).vertices.tobytes()


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda v, f: isomend.fill(v, f, max_diam=60), r"fill has no parameter 'max_diam' \(is max_diameter meant\?\); it has holes, max_diameter, .*strict$"),
        (lambda v, f: isomend.repair(v, f, hole=1), r"repair has no parameter 'hole' \(is holes meant\?\); it has weld"),
        (lambda v, f: isomend.restore((v, f), [0], hole=1), "restore has no parameter 'hole'; it has keep_shape"),
        (lambda v, f: isomend.check(v, f, thinner=1), r"check has no parameter 'thinner' \(is thin meant\?\); it has thin, min_wall, debris, threads$"),
        (lambda v, f: isomend.compare((v, f), (v, f), sample=1), r"compare has no parameter 'sample' \(is samples meant\?\); it has samples, threads$"),
        (lambda v, f: isomend.sdf(v, f, size=1), "sdf has no parameter 'size'; it has voxel, band, threads$"),
        (lambda v, f: isomend.surface("a.vti", at=1), "surface has no parameter 'at'; it has level"),
        (lambda v, f: isomend.signed_distance(v, v, f, at=1), "signed_distance has no parameter 'at'; it has threads"),
        (lambda v, f: isomend.restore(v, f, mask=[1, 2]), r"restore has no parameter 'mask' \(is mark meant\?\); it has keep_shape"),
        (lambda v, f: isomend.fair(v, f, mask=[1, 2]), r"fair has no parameter 'mask' \(is mark meant\?\); it has strength"),
        (lambda v, f: isomend.sdf(v, f, band="wide"), "band must be a positive number or 'full', but is 'wide'"),
        (lambda v, f: isomend.fair(v, f, strength=np.inf), "strength must be a finite number"),
        (lambda v, f: isomend.restore(v, f, {"balls": [[0, 0, -1, np.inf]]}), "the radius of each of the mask's balls must be a finite number"),
        (lambda v, f: isomend.restore(v, f, [[1], [1, 2]]), "the mask cannot be made an array, such as rows of different lengths"),
        (lambda v, f: isomend.fill(v, f, point_data={"a": [[1], [1, 2]]}), "point_data 'a' cannot be made an array"),
        (lambda v, f: isomend.fill(v, f).delivering(tolerance="x"), "tolerance must be a number, but is 'x'"),
        (lambda v, f: isomend.fill(v, f, like=5), "like must be 'mirror', .*, the path of a mesh, or a mesh, but builtins.int is no mesh"),
        (lambda v, f: isomend.fill(v, f, progress=5), r"progress must be a function, called as progress\(part, done, regions\), but is 5"),
        (lambda v, f: isomend.fill(v, f, strict="yes"), "strict must be True or False"),
        (lambda v, f: isomend.fill(v, f, holes=["a"]), "each number of holes must be a whole number, but is 'a'"),
        (lambda v, f: isomend.fill(v, f, bridge="1+2"), r"bridge must be a list such as \[\[1, 2\]\], but is '1\+2'"),
        (lambda v, f: isomend.fill(v, f, crease=3), r"crease must be a list such as \[\(1, 2\)\], but is 3"),
        (lambda v, f: isomend.fill(v, f, max_diameter="60"), "max_diameter must be a number, but is '60'"),
        (lambda v, f: isomend.fill(v, f, point_data=v), "point_data must be a dictionary of names and arrays"),
        (lambda v, f: isomend.fill((v, f), point_data={"a": v}), "a mesh or a file has values of its own: give its arrays"),
        (lambda v, f: isomend.restore((v, f), "red"), "a mask must be one bool for each face, face numbers, or a dictionary"),
        (lambda v, f: isomend.restore((v, f), 5), "a mask must be one bool for each face"),
    ],
)
def test_wrong_arguments_are_answered_with_what_is_wanted(sphere, call, said):
    with pytest.raises(isomend.ParameterError, match=said):
        call(*sphere)


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda v, f: isomend.fill(v), r"faces are missing: .* isomend.fill\(vertices, faces\)"),
        (lambda v, f: isomend.fill(v.tolist()), "faces are missing"),
        (lambda v, f: isomend.fill_mesh(isomend.Model(v, f)), r"this is a model: call isomend.fill\(model, ...\)"),
        (lambda v, f: isomend.repair_mesh("a.ply"), r"this is a path: call isomend.repair\(path, ...\)"),
        (lambda v, f: isomend.restore_mesh((v, f), [0]), r"these are arrays: call isomend.restore\(vertices, faces, ...\)"),
        (lambda v, f: isomend.surface(isomend.Model(v, f)), r"given Model; isomend.sdf\(mesh\) makes a volume"),
    ],
)
def test_meshes_of_the_wrong_kind_are_answered_with_the_right_call(sphere, call, said):
    with pytest.raises(isomend.MeshTypeError, match=said) as caught:
        call(*sphere)
    assert isinstance(caught.value, TypeError) and isinstance(caught.value, isomend.IsomendError)


def test_a_scene_of_trimesh_is_answered_with_its_mesh(sphere):
    trimesh = pytest.importorskip("trimesh")
    scene = trimesh.Scene([trimesh.Trimesh(*sphere, process=False)])
    for call in (isomend.fill, isomend.fill_mesh):
        with pytest.raises(TypeError, match=r"scene.to_mesh\(\)"):
            call(scene)


def test_errors_belong_to_the_package():
    errors = [value for value in vars(isomend).values() if isinstance(value, type) and issubclass(value, isomend.IsomendError)]
    assert len(errors) == 9 and {error.__module__ for error in errors} == {"isomend"}


def test_all_holes_can_be_named_and_bridges_need_two(sphere, filled):
    assert isomend.fill(*sphere, holes="all").faces.tobytes() == filled.faces.tobytes()
    with pytest.raises(isomend.ParameterError, match="flat"):
        isomend.fill(*sphere, flat="all")
    for group in ([1, 1], [1], []):
        with pytest.raises(isomend.ParameterError, match="bridge"):
            isomend.fill(*sphere, bridge=[group])


def test_strict_raises_with_the_result():
    # A zigzag rim: no converged surface continues it.
    vertices, faces = shapes.open_sphere(around=24, latitudes=12, top=3)
    torn = vertices.copy()
    rim = isomend.inspect(vertices, faces).holes[0].rim
    torn[rim[::2], 2] -= 1.5
    loose = isomend.fill(torn, faces)
    if loose.flawless:
        pytest.fail("the fill of this hole is flawless now: use a worse hole")
    with pytest.raises(isomend.StrictError, match="converged") as caught:
        isomend.fill(torn, faces, strict=True)
    assert caught.value.result.faces.tobytes() == loose.faces.tobytes()


def large_sphere():
    """A sphere with a hole whose fill takes seconds."""
    return shapes.open_sphere(around=256, latitudes=128, top=50)


def test_progress_is_reported_at_most_20_times_a_second():
    calls = []
    begun = time.perf_counter()
    isomend.fill(*large_sphere(), threads=1, progress=lambda *state: calls.append((time.perf_counter(), state)))
    seconds = time.perf_counter() - begun
    assert 1 <= len(calls) <= 20 * seconds + 1
    parts = [state[0] for _, state in calls]
    assert parts == sorted(parts) and parts[-1] == 1.0
    assert calls[-1][1][1:] == (1, 1)
    assert all(b - a > 0.04 for (a, _), (b, _) in zip(calls[:-2], calls[1:-1]))


def test_progress_may_cancel_and_its_exceptions_are_raised():
    begun = time.perf_counter()
    with pytest.raises(isomend.Cancelled):
        isomend.fill(*large_sphere(), progress=lambda *_: False)
    assert time.perf_counter() - begun < 2

    def fails(*_):
        raise KeyError("its own")

    with pytest.raises(KeyError, match="its own"):
        isomend.fill(*large_sphere(), progress=fails)


def test_ctrl_c_ends_a_fill_within_half_a_second():
    vertices, faces = large_sphere()
    sent = []

    def interrupt():
        sent.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    # A process started in the background may ignore SIGINT; the default handler is set for the test.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.3, interrupt)
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            for _ in range(20):
                isomend.fill(vertices, faces, voxel=0.01)
    finally:
        signal.signal(signal.SIGINT, before)
    assert time.perf_counter() - sent[0] < 0.5


def test_other_threads_run_during_a_fill():
    counted = 0
    done = threading.Event()

    def count():
        nonlocal counted
        while not done.is_set():
            counted += 1
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    isomend.fill(*large_sphere())
    done.set()
    thread.join()
    assert counted > 50


def test_a_forked_process_fills_too(sphere, filled):
    multiprocessing = pytest.importorskip("multiprocessing")
    if "fork" not in multiprocessing.get_all_start_methods():
        pytest.skip("no fork here")
    with multiprocessing.get_context("fork").Pool(1) as pool:
        result = pool.apply_async(fill_bytes, sphere)
        assert result.get(timeout=60) == filled.vertices.tobytes()


def fill_bytes(vertices, faces):
    return isomend.fill(vertices, faces).vertices.tobytes()


def test_messages_go_to_the_log_of_python(sphere, caplog):
    with caplog.at_level(logging.DEBUG, logger="isomend"):
        isomend.fill(*sphere)
    assert any(record.name == "isomend" and record.levelno == logging.DEBUG for record in caplog.records)
    caplog.clear()
    with caplog.at_level(logging.WARNING, logger="isomend"):
        isomend.fill(*sphere)
    assert not caplog.records


def test_the_import_takes_less_than_a_tenth_of_a_second():
    """In CPU time, because other programs may be running."""
    code = "import time; begun = time.process_time(); import isomend; print(time.process_time() - begun)"
    seconds = [float(subprocess.check_output([sys.executable, "-c", code])) for _ in range(5)]
    assert min(seconds) < 0.1, seconds


def test_the_command_comes_with_the_package(tmp_path):
    run = lambda *words: subprocess.run([sys.executable, "-c", CALL, *words], capture_output=True, text=True, cwd=tmp_path)  # noqa: E731
    assert run("--version").stdout.strip() == f"isomend {isomend.__version__}"
    assert run("fill", "none.ply", "-o", "a.ply").returncode == 1
    assert run("fill", "a.ply").returncode == 2


CALL = "import sys; from isomend._command import main; sys.argv[0] = 'isomend'; sys.exit(main())"
