"""Builds libbrittle by CMake and packs it, with the libraries that it needs, into a wheel for every Python 3.

The package calls the library through ctypes, so no part of the wheel depends on the version of Python. The environment
variable CMAKE_ARGS holds further arguments for CMake.
"""
import os
import pathlib
import platform
import re
import shlex
import shutil
import subprocess

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py
from wheel.bdist_wheel import bdist_wheel

HERE = pathlib.Path(__file__).resolve().parent
SOURCE = HERE.parent.parent
BUILD = SOURCE / "build" / "python"
# Shared with every program of the system; all others travel in the wheel.
SYSTEM_LIBRARIES = re.compile(r"(ld-linux.*|lib(c|m|dl|rt|pthread|gcc_s|stdc\+\+))\.so\.")


def version() -> str:
    return re.search(r"project\(brittle VERSION ([0-9.]+)", (SOURCE / "CMakeLists.txt").read_text())[1]


def build_library() -> list[pathlib.Path]:
    """Builds libbrittle and returns it with the libraries that must lie beside it."""
    subprocess.run(["cmake", "-S", SOURCE, "-B", BUILD, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                    "-DBRITTLE_LIBRARY_ONLY=ON", "-DBRITTLE_TBB=OFF", "-DBUILD_TESTING=OFF",
                    # RPATH, unlike RUNPATH, also holds for the libraries that those beside it need.
                    "-DCMAKE_BUILD_RPATH=$ORIGIN", "-DCMAKE_SHARED_LINKER_FLAGS=-Wl,--disable-new-dtags",
                    *shlex.split(os.environ.get("CMAKE_ARGS", ""))],
                   check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", BUILD, "--target", "brittle_c"], check=True)
    library = next((BUILD / "bindings" / "c").glob("libbrittle.so.*.*.*"))
    listed = subprocess.run(["ldd", library], check=True, capture_output=True, text=True).stdout
    found = re.findall(r"^\s*(\S+) => (/\S+)", listed, re.MULTILINE)
    return [library] + [pathlib.Path(path) for name, path in found if not SYSTEM_LIBRARIES.match(name)]


class BuildPackage(build_py):
    """Adds the libraries to the package, under the names that the loader looks for."""

    def run(self) -> None:
        super().run()
        target = pathlib.Path(self.build_lib) / "brittle" / "lib"
        shutil.rmtree(target, ignore_errors=True)
        target.mkdir(parents=True)
        shutil.copyfile(SOURCE / "LICENSE", target / "LICENSE")
        for package in ("libbullet-dev", "nlohmann-json3-dev", "libboost-dev"):  # whose code libbrittle holds
            notice = pathlib.Path("/usr/share/doc") / package / "copyright"
            if notice.exists():  # on Debian
                shutil.copyfile(notice, target / f"LICENSE.{package}")
        for library in build_library():
            dynamic = subprocess.run(["readelf", "-d", library], check=True, capture_output=True, text=True).stdout
            soname = re.search(r"\(SONAME\).*\[(.+)\]", dynamic)[1]
            shutil.copyfile(library.resolve(), target / soname)
            subprocess.run(["strip", "--strip-unneeded", target / soname], check=True)


class PlatformWheel(bdist_wheel):
    """Names the wheel for any Python 3, on this processor and this C library or a newer one."""

    def finalize_options(self) -> None:
        super().finalize_options()
        self.root_is_pure = False

    def get_tag(self) -> tuple[str, str, str]:
        libc = os.confstr("CS_GNU_LIBC_VERSION").split()[1].replace(".", "_")
        return "py3", "none", f"manylinux_{libc}_{platform.machine()}"


class BinaryDistribution(Distribution):
    """Holds machine code though it has no extension modules."""

    def has_ext_modules(self) -> bool:
        return True


BUILD.mkdir(parents=True, exist_ok=True)
setup(version=version(), options={"egg_info": {"egg_base": str(BUILD)}, "build": {"build_base": str(BUILD / "package")}},
      cmdclass={"build_py": BuildPackage, "bdist_wheel": PlatformWheel}, distclass=BinaryDistribution)
