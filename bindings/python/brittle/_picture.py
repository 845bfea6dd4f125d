"""Small pictures of meshes and pieces for notebooks, drawn by numpy."""
from __future__ import annotations

import base64
import colorsys
import html
import struct
import zlib

import numpy as np

_SIZE = 240, 180  #: pixels, width and height
_SAMPLES = 2  #: per pixel, in each direction
_LIGHT = np.array([-0.35, -0.6, 0.72])  #: towards the light: from above, over the left shoulder; image coordinates
_CHUNK = 50_000  #: faces that are drawn at a time, which bounds the memory


def _view() -> np.ndarray:
    """(3, 3): rows are right, up, and the direction towards the eye."""
    eye = np.array([0.55, 0.45, 0.7])
    eye /= np.linalg.norm(eye)
    right = np.cross([0.0, 1.0, 0.0], eye)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(eye, right), eye])


def piece_colours(count: int) -> np.ndarray:
    """(count, 3): colours from 0 to 1, unlike for neighbours in number."""
    return np.array([colorsys.hsv_to_rgb((0.07 + 0.618034 * k) % 1.0, 0.45, 0.95) for k in range(count)]).reshape(-1, 3)


def draw(vertices: np.ndarray, faces: np.ndarray, colours: np.ndarray) -> np.ndarray:
    """Draws faces, each with a colour, seen from above at an angle, without perspective. Returns (height, width, 4)
    uint8, transparent where there is nothing."""
    width, height = (_SAMPLES * size for size in _SIZE)
    points = vertices @ _view().T
    low, high = (points.min(axis=0), points.max(axis=0)) if len(points) else (np.zeros(3), np.ones(3))
    scale = 0.95 * min(width / max(high[0] - low[0], 1e-30), height / max(high[1] - low[1], 1e-30))
    middle = (low + high) / 2
    points = np.stack([width / 2 + scale * (points[:, 0] - middle[0]), height / 2 - scale * (points[:, 1] - middle[1]),
                       scale * (points[:, 2] - middle[2])], axis=1)
    image, depth = np.zeros((height * width, 4)), np.full(height * width, -np.inf)
    for begin in range(0, len(faces), _CHUNK):
        corners = points[faces[begin:begin + _CHUNK]]
        # The image has Y downwards, so a face that looks at the eye is clockwise here.
        edges = corners[:, 1:] - corners[:, :1]
        normal = np.cross(edges[:, 1], edges[:, 0])
        seen = np.flatnonzero(normal[:, 2] > 0)
        corners, normal = corners[seen], normal[seen]
        shade = 0.3 + 0.7 * np.clip(normal @ _LIGHT / np.linalg.norm(normal, axis=1), 0, None)
        colour = colours[begin + seen] * shade[:, None]
        # All sample points in the box of each face.
        first = np.clip(np.ceil(corners[:, :, :2].min(axis=1) - 0.5), 0, None).astype(int)
        last = np.minimum(np.floor(corners[:, :, :2].max(axis=1) - 0.5), [width - 1, height - 1]).astype(int)
        extent = np.maximum(last - first + 1, 0)
        counts = extent[:, 0] * extent[:, 1]
        face = np.repeat(np.arange(len(corners)), counts)
        within = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
        x = first[face, 0] + within % np.maximum(extent[face, 0], 1)
        y = first[face, 1] + within // np.maximum(extent[face, 0], 1)
        at, area = np.stack([x + 0.5, y + 0.5], axis=1), normal[face, 2]
        shares = []
        for k in range(3):
            a, b = corners[face, (k + 1) % 3, :2] - at, corners[face, (k + 2) % 3, :2] - at
            shares.append((a[:, 1] * b[:, 0] - a[:, 0] * b[:, 1]) / area)
        z = sum(share * corners[face, k, 2] for k, share in enumerate(shares))
        inside = np.flatnonzero(np.minimum.reduce(shares) >= 0)
        inside = inside[np.argsort(z[inside], kind="stable")]  # of equal indices numpy keeps the last, the nearest
        pixel = y[inside] * width + x[inside]
        nearer = z[inside] > depth[pixel]
        inside, pixel = inside[nearer], pixel[nearer]
        depth[pixel] = z[inside]
        image[pixel, :3], image[pixel, 3] = colour[face[inside]], 1.0
    blocks = image.reshape(_SIZE[1], _SAMPLES, _SIZE[0], _SAMPLES, 4).mean(axis=(1, 3))
    blocks[..., :3] /= np.maximum(blocks[..., 3:], 1e-9)
    pixels: np.ndarray = (255 * np.clip(blocks, 0, 1) + 0.5).astype(np.uint8)
    return pixels


def png(image: np.ndarray) -> bytes:
    """The PNG file of an image (height, width, 4)."""
    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    height, width = image.shape[:2]
    rows = np.concatenate([np.zeros((height, 1), np.uint8), image.reshape(height, -1)], axis=1)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(rows.tobytes())) + chunk(b"IEND", b""))


def figure(image: np.ndarray, caption: str) -> str:
    """HTML with a picture and a line of text."""
    data = base64.b64encode(png(image)).decode()
    return (f'<figure style="margin:0"><img width="{image.shape[1]}" height="{image.shape[0]}" '
            f'src="data:image/png;base64,{data}"><figcaption>{html.escape(caption)}</figcaption></figure>')
