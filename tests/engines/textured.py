"""Writes a closed ball with a normal map as a GLB file: smooth normals, a seam, and an image that is mirrored half-way
around. The mesh has what pieces do not keep, too: tangents, a camera and an animation."""
import json
import math
import struct
import sys
import zlib
from pathlib import Path

RINGS, SEGMENTS = 24, 32


def png(size: int) -> bytes:
    """A normal map with a slope that varies along u."""
    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    row = b"\0" + b"".join(bytes((96 + 64 * (x % 2), 128, 248)) for x in range(size))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", size, size, 8, 2, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(row * size)) + chunk(b"IEND", b""))


def write(file: Path) -> None:
    normals, uv, corners = [], [], []
    for ring in range(RINGS + 1):
        theta = math.pi * ring / RINGS
        across = 0.0 if ring in (0, RINGS) else math.sin(theta)
        for segment in range(SEGMENTS + 1):
            phi = 2 * math.pi * (segment % SEGMENTS) / SEGMENTS
            normals.append((across * math.sin(phi), math.cos(theta), across * math.cos(phi)))
            uv.append((1 - abs(2 * segment / SEGMENTS - 1), ring / RINGS))
    for ring in range(RINGS):
        for segment in range(SEGMENTS):
            a, b = ring * (SEGMENTS + 1) + segment, (ring + 1) * (SEGMENTS + 1) + segment
            if ring > 0:
                corners += [a, b, a + 1]
            if ring < RINGS - 1:
                corners += [a + 1, b, b + 1]
    count = len(normals)
    views, binary = [], b""

    def add(data: bytes) -> int:
        nonlocal binary
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        binary += data + b"\0" * (-len(data) % 4)
        return len(views) - 1

    def floats(rows: list) -> int:
        return add(b"".join(struct.pack(f"<{len(row)}f", *row) for row in rows))

    position = {"componentType": 5126, "count": count, "type": "VEC3"}
    accessors = [
        {"bufferView": floats(normals), "min": [-1, -1, -1], "max": [1, 1, 1], **position},
        {"bufferView": floats(uv), "componentType": 5126, "count": count, "type": "VEC2"},
        {"bufferView": floats([(1, 0, 0, 1)] * count), "componentType": 5126, "count": count, "type": "VEC4"},
        {"bufferView": add(struct.pack(f"<{len(corners)}I", *corners)), "componentType": 5125, "count": len(corners),
         "type": "SCALAR"},
        {"bufferView": floats([(0,), (1,)]), "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0],
         "max": [1]},
        {"bufferView": floats([(0, 0, 0), (0, 1, 0)]), "componentType": 5126, "count": 2, "type": "VEC3"},
    ]
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0, "name": "ball"}, {"camera": 0}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}],
        "animations": [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
                        "samplers": [{"input": 4, "output": 5}]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "NORMAL": 0, "TEXCOORD_0": 1, "TANGENT": 2},
                                    "indices": 3, "material": 0}]}],
        "materials": [{"name": "bumpy", "normalTexture": {"index": 0},
                       "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}], "images": [{"mimeType": "image/png", "bufferView": add(png(16))}],
        "accessors": accessors, "bufferViews": views, "buffers": [{"byteLength": len(binary)}],
    }
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    file.write_bytes(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary))
                     + struct.pack("<I4s", len(text), b"JSON") + text
                     + struct.pack("<I4s", len(binary), b"BIN\0") + binary)


if __name__ == "__main__":
    write(Path(sys.argv[1]))
