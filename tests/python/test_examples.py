"""Runs the examples of docs/bindings.md as they stand there."""
import os
import pathlib
import re
import shutil
import subprocess
import sys

import pytest

from conftest import BUNNY, ROOT

PROGRAM = pathlib.Path(os.environ.get("BRITTLE_COMMAND", ROOT / "build/release/bin/brittle"))
PAGE = (ROOT / "docs/bindings.md").read_text(encoding="utf-8")
EXAMPLES = [(language, text) for language, text in re.findall(r"^```(\w+)\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
            if language in ("sh", "cpp", "c", "python")]  # tools/test-blender and tools/test-languages run the others


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """The library, installed as the page says, and an environment that finds it."""
    prefix = tmp_path_factory.mktemp("prefix")
    subprocess.run(["cmake", "--install", ROOT / "build/release", "--component", "library", "--prefix", prefix],
                   check=True, stdout=subprocess.DEVNULL)
    folder = next(prefix.glob("lib*/**/pkgconfig"))
    return dict(os.environ, PKG_CONFIG_PATH=str(folder), LD_LIBRARY_PATH=str(folder.parent), PREFIX=str(prefix))


def compile_and_run(compiler, options, package, source, folder, environment):
    flags = subprocess.run(["pkg-config", f"--define-variable=prefix={environment['PREFIX']}", "--cflags", "--libs",
                            package], check=True, capture_output=True, text=True, env=environment).stdout.split()
    subprocess.run([compiler, *options, source, "-o", folder / "example", *flags], check=True, env=environment)
    return subprocess.run([folder / "example"], check=True, cwd=folder, env=environment, capture_output=True,
                          text=True).stdout


@pytest.mark.parametrize("language, text", EXAMPLES, ids=[f"{k}-{language}" for k, (language, _) in enumerate(EXAMPLES)])
def test_example(language, text, tmp_path, request):
    shutil.copy(BUNNY, tmp_path)
    if language == "python":
        printed = subprocess.run([sys.executable, "-c", text], check=True, cwd=tmp_path, capture_output=True,
                                 text=True).stdout
        assert printed
    elif language == "sh":
        environment = dict(os.environ, PATH=f"{PROGRAM.parent}:{os.environ['PATH']}")
        subprocess.run(["sh", "-ec", text], check=True, cwd=tmp_path, env=environment)
        assert (tmp_path / "pieces.glb").stat().st_size > 1000 and (tmp_path / "bunny.png").exists()
    elif language == "cpp":
        source = tmp_path / "example.cpp"
        source.write_text(text)
        printed = compile_and_run("c++", ["-std=c++20", "-Wall"], "brittle", source, tmp_path,
                                  request.getfixturevalue("installed"))
        assert re.fullmatch(r"\d+ pieces\n", printed)
    elif language == "c":
        source = tmp_path / "example.c"
        source.write_text(text)
        compile_and_run("cc", ["-std=c99", "-Wall"], "brittle-c", source, tmp_path, request.getfixturevalue("installed"))
        assert (tmp_path / "c.glb").stat().st_size > 1000
    else:
        pytest.fail(f"nothing runs an example in {language}")


def test_all_faces_have_an_example():
    assert {language for language, _ in EXAMPLES} >= {"sh", "cpp", "c", "python"}
