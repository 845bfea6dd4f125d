"""The structures of the package are those of brittle.h, as the C compiler lays them out."""
import ctypes
import subprocess

from brittle import _library as lib

from conftest import ROOT

STRUCTURES = {
    "error": lib.Error, "array": lib.Array, "mesh_arrays": lib.MeshArrays, "inspection": lib.InspectionStruct,
    "repair_settings": lib.RepairSettings, "pattern": lib.Pattern, "fracture_settings": lib.FractureSettings,
    "certificate": lib.CertificateStruct, "export_settings": lib.ExportSettings, "world_settings": lib.WorldSettings,
    "anchor": lib.Anchor, "material": lib.MaterialStruct, "object_settings": lib.ObjectSettings,
    "load_settings": lib.LoadSettings, "run_object": lib.RunObjectStruct, "replay_result": lib.ReplayResultStruct,
}


def test_structures(tmp_path):
    lines, expected = [], []
    for name, structure in STRUCTURES.items():
        lines.append(f'printf("{name} %zu\\n", sizeof(brittle_{name}));')
        expected.append(f"{name} {ctypes.sizeof(structure)}")
        for field, kind, *_ in structure._fields_:
            offset = getattr(structure, field).offset
            lines.append(f'printf("{name}.{field} %zu %zu\\n", offsetof(brittle_{name}, {field}), '
                         f"sizeof(((brittle_{name}*)0)->{field}));")
            expected.append(f"{name}.{field} {offset} {ctypes.sizeof(kind)}")
    transform = lib.TRANSFORM
    lines.append('printf("transform %zu\\n", sizeof(brittle_transform));')
    expected.append(f"transform {transform.itemsize}")
    for field in transform.names:
        lines.append(f'printf("transform.{field} %zu\\n", offsetof(brittle_transform, {field}));')
        expected.append(f"transform.{field} {transform.fields[field][1]}")
    source = tmp_path / "layout.c"
    source.write_text("#include <stddef.h>\n#include <stdio.h>\n#include \"brittle.h\"\nint main(void) {\n"
                      + "\n".join(lines) + "\nreturn 0; }\n")
    subprocess.run(["cc", "-std=c99", "-I", ROOT / "bindings/c", source, "-o", tmp_path / "layout"], check=True)
    printed = subprocess.run([tmp_path / "layout"], check=True, capture_output=True, text=True).stdout
    assert printed.splitlines() == expected
