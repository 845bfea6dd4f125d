"""The declarations for Rust and C#: they are those of brittle.h, compile, and break the bunny. Run by
tools/test-languages, with the installed library in the folder BRITTLE_PREFIX."""
import importlib.machinery
import importlib.util
import os
import pathlib
import re
import shutil
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PREFIX = pathlib.Path(os.environ["BRITTLE_PREFIX"])
LIBRARY = next(PREFIX.glob("lib*/**/libbrittle.so")).parent
ENVIRONMENT = dict(os.environ, LD_LIBRARY_PATH=str(LIBRARY))
PAGE = (ROOT / "docs/bindings.md").read_text(encoding="utf-8")


def run(*command, folder) -> str:
    done = subprocess.run(command, cwd=folder, env=ENVIRONMENT, capture_output=True, text=True)
    assert done.returncode == 0, f"{command[0]} returned {done.returncode}:\n{done.stdout}{done.stderr}"
    return done.stdout


def compile_c(source, folder) -> list:
    (folder / "program.c").write_text(source)
    run("cc", "-std=c99", "-I", PREFIX / "include", "program.c", "-o", "program", folder=folder)
    return ["./program"]


def compile_rust(source, folder) -> list:
    shutil.copy(ROOT / "bindings/rust/brittle.rs", folder)
    (folder / "program.rs").write_text(source)
    run("rustc", "-D", "warnings", "program.rs", "-L", LIBRARY, "-l", "brittle", folder=folder)
    return ["./program"]


def compile_csharp(source, folder) -> list:
    (folder / "program.cs").write_text(source)
    run("mcs", "-unsafe", "-warnaserror", "program.cs", ROOT / "bindings/csharp/Brittle.cs", folder=folder)
    return ["mono", "program.exe"]


@pytest.fixture(scope="module")
def header():
    loader = importlib.machinery.SourceFileLoader("declare", str(ROOT / "tools/declare-bindings"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("declare", loader))
    loader.exec_module(module)
    return module.Header(module.HEADER.read_text(encoding="utf-8"))


def test_files_are_those_of_the_header():
    subprocess.run([ROOT / "tools/declare-bindings", "--check"], check=True)


def test_layout_of_all_structures(header, tmp_path):
    c, rust, csharp = [], [], []
    for name, fields, _ in header.structs:
        c.append(f'printf("{name} %zu\\n", sizeof({name}));')
        rust.append(f'println!("{name} {{}}", std::mem::size_of::<{name}>());')
        csharp.append(f'Console.WriteLine("{name} " + sizeof({name}));')
        for field, *_ in fields:
            escaped = "r#" + field if field == "type" else field
            c.append(f'printf("{name}.{field} %zu\\n", offsetof({name}, {field}));')
            rust.append(f"unsafe {{ let s = std::mem::MaybeUninit::<{name}>::uninit(); let p = s.as_ptr(); println!("
                        f'"{name}.{field} {{}}", std::ptr::addr_of!((*p).{escaped}) as usize - p as usize); }}')
            csharp.append(f'Console.WriteLine("{name}.{field} " + Marshal.OffsetOf(typeof({name}), "{field}"));')
    expected = run(*compile_c("#include <brittle.h>\n#include <stddef.h>\n#include <stdio.h>\nint main(void) {\n"
                              + "\n".join(c) + "\nreturn 0; }\n", tmp_path), folder=tmp_path)
    assert len(expected.splitlines()) == len(c) > 100
    assert run(*compile_rust('#[path = "brittle.rs"]\nmod brittle;\nuse brittle::*;\nfn main() {\n' + "\n".join(rust)
                             + "\n}\n", tmp_path), folder=tmp_path) == expected
    assert run(*compile_csharp("using System;\nusing System.Runtime.InteropServices;\nusing static Brittle;\n"
                               "static unsafe class Program { static void Main() {\n" + "\n".join(csharp) + "\n} }\n",
                               tmp_path), folder=tmp_path) == expected


def test_constants(header, tmp_path):
    c = [f'printf("%u\\n", (unsigned){name});' for name, *_ in header.constants]
    printed = run(*compile_c("#include <brittle.h>\n#include <stdio.h>\nint main(void) {\n" + "\n".join(c)
                             + "\nreturn 0; }\n", tmp_path), folder=tmp_path)
    assert [int(line) for line in printed.splitlines()] == [int(value, 0) for _, value, _ in header.constants]


@pytest.mark.parametrize("language, compile_it, output", [("rust", compile_rust, "rust.glb"),
                                                          ("csharp", compile_csharp, "csharp.glb")])
def test_example_of_the_documentation(language, compile_it, output, tmp_path):
    shutil.copy("/usr/share/glmark2/models/bunny.obj", tmp_path)
    source = re.search(rf"^```{language}\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)[1]
    run(*compile_it(source, tmp_path), folder=tmp_path)
    # The pieces of the command line, byte for byte.
    run(ROOT / "build/release/bin/brittle", "fracture", "bunny.obj", "-n", "20", "-o", "command.glb", folder=tmp_path)
    ours, theirs = ((tmp_path / name).read_bytes() for name in (output, "command.glb"))
    assert len(ours) > 1e6 and geometry(ours) == geometry(theirs)


def geometry(glb: bytes) -> bytes:
    """The binary part of a GLB file; the other one names the file."""
    length = int.from_bytes(glb[12:16], "little")
    return glb[20 + length:]
