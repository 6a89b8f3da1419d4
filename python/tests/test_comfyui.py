"""The nodes for ComfyUI give the same meshes as the Python functions: batches, values of vertices, textures."""

import sys
from pathlib import Path

import numpy as np
import pytest
import shapes

import isomend

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
comfyui = pytest.importorskip("comfyui")


class Tensor:
    """The part of a tensor's interface that the nodes use."""

    def __init__(self, values, dtype=None):
        self.values = np.asarray(values, dtype)

    def detach(self):
        return self

    cpu = detach

    def numpy(self):
        return self.values

    def new_tensor(self, values):
        return Tensor(values, self.values.dtype)


class Mesh:
    """ComfyUI's mesh: vertices (batch, n, 3), faces (batch, m, 3), and optional attributes."""

    def __init__(self, vertices, faces, **more):
        self.vertices, self.faces = vertices, faces
        self.uvs = self.vertex_colors = self.normals = self.texture = self.vertex_counts = self.face_counts = None
        vars(self).update(more)


def tensors():
    """Functions that make tensors: of the test, and of torch if it is installed."""
    kinds = [lambda values: Tensor(values)]
    try:
        import torch
    except ImportError:
        return kinds
    return [*kinds, torch.from_numpy]


def batch(make, *meshes, **more):
    """A batch of meshes of one size."""
    vertices = np.stack([v for v, _ in meshes]).astype(np.float32)
    return Mesh(make(vertices), make(np.stack([f for _, f in meshes]).astype(np.int64)), **more)


def arrays(mesh, i):
    """Vertices and faces of a mesh of a batch."""
    return comfyui.meshes.each(mesh).__next__() if i == 0 else list(comfyui.meshes.each(mesh))[i]


@pytest.mark.parametrize("make", tensors())
def test_the_fill_node_equals_the_function_with_values_and_textures(make):
    vertices, faces = shapes.open_sphere(dtype=np.float32)
    uvs, texture = vertices[:, :2] * 0.5 + 0.5, object()
    mesh = batch(make, (vertices, faces), uvs=make(uvs[None].copy()), normals=make(vertices[None].copy()), texture=texture)
    out, complete, text = comfyui.nodes.IsomendFill().fill(mesh)
    plain = isomend.fill(vertices, faces, point_data={"uv": uvs})
    points, triangles, own = arrays(out, 0)
    assert complete and text.startswith("1 of 1 holes closed")
    assert np.array_equal(points, plain.vertices.astype(np.float32)) and np.array_equal(triangles, plain.faces)
    assert np.array_equal(own["uv"], plain.point_data["uv"].astype(np.float32))
    assert out.texture is texture and out.normals is None and out.vertex_counts is None
    assert mesh.vertices.shape[1] == len(vertices) if hasattr(mesh.vertices, "shape") else True
    assert len(arrays(mesh, 0)[0]) == len(vertices), "the input stays as it is"


@pytest.mark.parametrize("make", tensors())
def test_batches_of_meshes_with_different_sizes_are_filled(make):
    first, second = shapes.open_sphere(top=3), shapes.open_sphere(top=6)
    n, m = [[len(part[k]) for part in (first, second)] for k in (0, 1)]
    vertices, faces = np.zeros((2, max(n), 3), np.float32), np.zeros((2, max(m), 3), np.int64)
    for i, (v, f) in enumerate((first, second)):
        vertices[i, : len(v)], faces[i, : len(f)] = v, f
    mesh = Mesh(make(vertices), make(faces), vertex_counts=make(np.array(n)), face_counts=make(np.array(m)))
    out, complete, text = comfyui.nodes.IsomendFill().fill(mesh, voxel=0.15)
    assert complete and len(text.splitlines()) == 2
    for i, (v, f) in enumerate((first, second)):
        points, triangles, _ = arrays(out, i)
        plain = isomend.fill(v.astype(np.float32), f, voxel=0.15)
        assert np.array_equal(points, plain.vertices.astype(np.float32)) and np.array_equal(triangles, plain.faces)
        assert shapes.is_closed(triangles)


@pytest.mark.parametrize("make", tensors())
def test_the_check_and_repair_nodes_equal_the_functions(make):
    vertices, faces = shapes.open_sphere(dtype=np.float32)
    mesh = batch(make, (vertices, faces[:, ::-1]))
    before = comfyui.nodes.IsomendCheck().check(mesh)
    sound, text, same = before["result"]
    assert not sound and text == str(isomend.check(vertices, faces[:, ::-1])) and same is mesh and before["ui"]["text"] == [text]
    out, sound, text = comfyui.nodes.IsomendRepair().repair(mesh)
    plain = isomend.repair(vertices, faces[:, ::-1])
    points, triangles, _ = arrays(out, 0)
    assert sound and text == "nothing is wrong"
    assert np.array_equal(points, plain.vertices.astype(np.float32)) and np.array_equal(triangles, plain.faces)
    assert comfyui.nodes.IsomendCheck().check(out)["result"][0]


def test_the_nodes_are_declared_as_comfyui_requires():
    assert set(comfyui.NODE_CLASS_MAPPINGS) == set(comfyui.NODE_DISPLAY_NAME_MAPPINGS)
    for node in comfyui.NODE_CLASS_MAPPINGS.values():
        names = node.INPUT_TYPES()["required"]
        run = getattr(node, node.FUNCTION)
        assert set(names) == set(run.__code__.co_varnames[1 : run.__code__.co_argcount])
        assert len(node.RETURN_TYPES) == len(node.RETURN_NAMES)


def test_progress_and_interruption_go_through_comfyui(monkeypatch):
    from types import ModuleType, SimpleNamespace

    shown = []
    comfy = ModuleType("comfy")
    comfy.utils, comfy.model_management = ModuleType("comfy.utils"), ModuleType("comfy.model_management")
    comfy.utils.ProgressBar = lambda total: SimpleNamespace(update_absolute=lambda value, total: shown.append((value, total)))

    def stop():
        if len(shown) > 1:
            raise KeyboardInterrupt

    comfy.model_management.throw_exception_if_processing_interrupted = stop
    for name, module in (("comfy", comfy), ("comfy.utils", comfy.utils), ("comfy.model_management", comfy.model_management)):
        monkeypatch.setitem(sys.modules, name, module)
    progress = comfyui.nodes.following()
    progress(0.25, 0, 1)
    with pytest.raises(KeyboardInterrupt):
        progress(0.5, 1, 1)
    assert shown == [(25, 100), (50, 100)]
