"""The layers of a mesh, texture coordinates and colours, carried to the outside of its pieces."""
from __future__ import annotations

from dataclasses import dataclass

import bpy
import numpy as np


def gather(collection, attribute: str, count: int, kind=np.float32) -> np.ndarray:
    """One attribute of all elements of a Blender collection, (elements, count)."""
    values = np.empty(len(collection) * count, kind)
    collection.foreach_get(attribute, values)
    return values.reshape(-1, count) if count > 1 else values


@dataclass
class Layer:
    """Values of the corners of triangles."""

    name: str
    values: np.ndarray  #: (triangles, 3, components)
    active: bool  #: the one that is edited
    rendered: bool  #: the one that materials use unless they name another


@dataclass
class ColourLayer(Layer):
    kind: str  #: FLOAT_COLOR or BYTE_COLOR


class Layers:
    """The layers of an evaluated mesh with its triangles, in the coordinates and the order that the core was given."""

    def __init__(self, mesh: bpy.types.Mesh, loops: np.ndarray, corners: np.ndarray, points: np.ndarray) -> None:
        self.places = points[corners]  #: (triangles, 3, 3)
        rendered = next((layer.name for layer in mesh.uv_layers if layer.active_render), None)
        active = mesh.uv_layers.active
        self.uv = [Layer(layer.name, gather(layer.data, "uv", 2)[loops], layer == active, layer.name == rendered)
                   for layer in mesh.uv_layers]
        colours = mesh.color_attributes
        self.colours = [ColourLayer(layer.name,
                                    gather(layer.data, "color", 4)[corners if layer.domain == "POINT" else loops],
                                    layer == colours.active_color, k == colours.render_color_index, layer.data_type)
                        for k, layer in enumerate(colours)]
        self.follow = True  #: whether the faces of the core are still these triangles

    @property
    def active_uv(self) -> Layer | None:
        return next((layer for layer in self.uv if layer.active), None)

    def weights(self, sources: np.ndarray, places: np.ndarray) -> np.ndarray:
        """Barycentric coordinates (faces, 3, 3) of the corners `places` of faces in the triangles `sources`."""
        a, b, c = (self.places[sources][:, None, k] for k in range(3))
        normal = np.cross(b - a, c - a)
        areas = np.stack([np.einsum("fki,fki->fk", np.broadcast_to(normal, places.shape), np.cross(s - r, places - r))
                          for r, s in ((b, c), (c, a), (a, b))], axis=-1)
        areas = np.maximum(areas, 0.0)
        sums = areas.sum(axis=-1, keepdims=True)
        return np.divide(areas, sums, out=np.full_like(areas, 1.0 / 3.0), where=sums > 0)

    @staticmethod
    def at(layer: Layer, sources: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Values of a layer at weights in triangles, (faces, 3, components)."""
        return np.einsum("fkv,fvc->fkc", weights, layer.values[sources])
