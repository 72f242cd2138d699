"""Makes wheels of a finished build: `libskybody` and `skybody`, which needs it.

    ./dev wheel                                              # builds all that it takes
    .venv/bin/python scripts/build_wheels.py --build build/release --out build/wheels

`libskybody` has all that needs no Python: the library, plugins, scenarios with their models and
policies, headers, CMake files and the program. `skybody` is the Python package, once for the Python
of the build and, with skybody_stable_module, once for 3.12 and later. auditwheel copies the
libraries of others beside ours, under names that no other copy has, and says on which systems
(manylinux) the wheels run. elf_symbol_versions lets these be older ones.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import tomllib
from dataclasses import dataclass
from pathlib import Path

import elf_symbol_versions

ROOT = Path(__file__).resolve().parents[1]
LIMIT = 25e6  # bytes of a wheel
COMPONENTS = ("library", "development", "program")
STATIC = ("AEC", "BLAS", "HDF5", "LAPACK", "SZ")  # archives of others, linked in (packaging/wheel)
# Headers of others, compiled in.
HEADERS = (
    "CLI/CLI.hpp",
    "Random123/philox.h",
    "eigen3/Eigen/Core",
    "fmt/core.h",
    "spdlog/spdlog.h",
)
OLDER = "older"  # folder of other libraries that ask for older symbols
MODULE_FINDS_LIBRARY = "$ORIGIN/../libskybody/lib"
LIBRARY_PACKAGE = '''"""The library of Skybody, for C++ and for the package `skybody`: a prefix."""

from pathlib import Path

prefix = Path(__file__).parent  # bin, include, lib, share
'''


@dataclass(frozen=True)
class Wheel:
    """One wheel: its distribution's name, its tag, and the folder of its files."""

    name: str
    tag: str
    folder: Path


class Project:
    """Name, version and needs, from pyproject.toml and CMakeLists.txt."""

    def __init__(self) -> None:
        self.table = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
        found = re.search(r"VERSION (\d+\.\d+\.\d+)", (ROOT / "CMakeLists.txt").read_text())
        assert found, "CMakeLists.txt has a version"
        self.version = found[1]

    def metadata(self, name: str, needs: list[str], extras: dict[str, list[str]]) -> str:
        """The file METADATA."""
        lines = ["Metadata-Version: 2.1", f"Name: {name}", f"Version: {self.version}"]
        lines += [f"Summary: {self.table['description']}", f"License: {self.table['license']}"]
        lines += ["License-File: LICENSE", f"Requires-Python: {self.table['requires-python']}"]
        lines += [f"Author: {author['name']}" for author in self.table["authors"]]
        lines += [f"Keywords: {','.join(self.table['keywords'])}"]
        lines += [f"Classifier: {classifier}" for classifier in self.table["classifiers"]]
        lines += [f"Requires-Dist: {need}" for need in needs]
        for extra, packages in extras.items():
            lines.append(f"Provides-Extra: {extra}")
            lines += [f'Requires-Dist: {package}; extra == "{extra}"' for package in packages]
        lines.append("Description-Content-Type: text/markdown")
        return "\n".join(lines) + "\n\n" + (ROOT / "README.md").read_text()


def run(*command: str | Path) -> str:
    """Output of a command. Exits with its message where it fails."""
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"error: {' '.join(map(str, command))}:\n{done.stdout}{done.stderr}")
    return done.stdout


# --- contents -----------------------------------------------------------------------------------


def add_library(build: Path, folder: Path) -> None:
    """The package `libskybody`: an installation of the build, with the wheel's own library."""
    prefix = folder / "libskybody"
    for component in COMPONENTS:
        run("cmake", "--install", build, "--prefix", prefix, "--component", component)
    libraries = prefix / "lib"
    for link in [p for p in libraries.iterdir() if p.is_symlink()]:  # wheels have no links
        link.unlink()
    for own in [p for p in (build / "lib/wheel").glob("libskybody.so.*") if not p.is_symlink()]:
        shutil.copy2(own, libraries)
    if not list(libraries.glob("libskybody.so.*")):
        sys.exit(f"error: {build}/lib/wheel has no libskybody: build skybody_wheel_library")
    for program in (prefix / "bin").iterdir():
        run(tool("patchelf"), "--set-rpath", "$ORIGIN/../lib", program)
    for library in libraries.glob("*.so.*"):
        run(tool("patchelf"), "--set-rpath", "$ORIGIN", library)
    random123 = Path(cache_value(build, "SKYBODY_RANDOM123_INCLUDE_DIR")) / "Random123"
    shutil.copytree(random123, prefix / "include/Random123")
    (prefix / "__init__.py").write_text(LIBRARY_PACKAGE)
    (prefix / "py.typed").touch()


def add_package(module: Path, stub: Path, folder: Path) -> None:
    """The package `skybody` with one native module, which finds the library beside it."""
    ignored = shutil.ignore_patterns("__pycache__", "_native*")
    shutil.copytree(ROOT / "python/skybody", folder / "skybody", ignore=ignored)
    shutil.copy2(stub, folder / "skybody")
    copy = shutil.copy2(module, folder / "skybody")
    run(tool("patchelf"), "--set-rpath", MODULE_FINDS_LIBRARY, copy)


def cache_value(build: Path, name: str) -> str:
    """A value of the build's CMakeCache.txt."""
    found = re.search(rf"^{name}:\w+=(.*)$", (build / "CMakeCache.txt").read_text(), re.M)
    return found[1] if found else ""


def tool(name: str) -> Path:
    """A program of this Python's environment."""
    return Path(sys.executable).with_name(name)


def package_of(library: Path) -> str | None:
    """The Debian package that owns a library of this system; None elsewhere."""
    if shutil.which("dpkg") is None:
        return None
    # Since the merge of /lib and /usr/lib, dpkg knows a file by either name.
    names = {library.as_posix(), library.as_posix().removeprefix("/usr"), f"/usr{library}"}
    for name in names:
        done = subprocess.run(["dpkg", "-S", name], capture_output=True, text=True)
        if done.returncode == 0:
            return done.stdout.split(":")[0]
    return None


def linked_libraries(folder: Path) -> set[Path]:
    """The libraries of the system that a wheel's files need."""
    said = "".join(run("ldd", path) for path in elf_files(folder))
    return {Path(path).resolve() for path in re.findall(r"=> (/\S+)", said)}


def for_older_systems(wheel: Path, copies: Path) -> None:
    """Lets the wheel's own files, and copies of the system's libraries that it takes, ask for older
    symbols. auditwheel finds the copies first.
    """
    for path in wheel.rglob("*"):
        if path.is_file() and not path.is_symlink():
            elf_symbol_versions.lower(path)
    copies.mkdir(exist_ok=True)
    for path in linked_libraries(wheel):
        copy = Path(shutil.copy2(path, copies / soname(path)))
        if not elf_symbol_versions.lower(copy):
            copy.unlink()


def soname(library: Path) -> str:
    """The name by which others ask for a library."""
    return run(tool("patchelf"), "--print-soname", library).strip() or library.name


def add_licenses(build: Path, folder: Path) -> None:
    """Licences of the libraries of others that the wheel brings, as Debian has them."""
    licenses = folder / "libskybody/share/skybody/licenses"
    licenses.mkdir(parents=True, exist_ok=True)
    static = [cache_value(build, f"SKYBODY_STATIC_{name}") for name in STATIC]
    paths = linked_libraries(folder) | {Path(path).resolve() for path in static if path}
    headers = Path(cache_value(build, "SKYBODY_RANDOM123_INCLUDE_DIR"))
    paths |= {headers / name for name in HEADERS}
    for package in sorted({found for path in paths if (found := package_of(path))}):
        notice = Path("/usr/share/doc") / package / "copyright"
        if notice.is_file():
            shutil.copy(notice, licenses / f"{package}.txt")


def elf_files(folder: Path) -> list[Path]:
    """The library, the learners and the program of the package `libskybody`."""
    return [*folder.glob("libskybody/lib/*.so.*"), *folder.glob("libskybody/bin/*")]


# --- wheels -------------------------------------------------------------------------------------


def pack(project: Project, wheel: Wheel, extra: dict[str, list[str]], needs: list[str]) -> Path:
    """Writes the wheel's metadata and packs its folder."""
    for_older_systems(wheel.folder, wheel.folder.parent / OLDER)
    info = wheel.folder / f"{wheel.name}-{project.version}.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(project.metadata(wheel.name, needs, extra))
    lines = ["Wheel-Version: 1.0", "Generator: skybody", "Root-Is-Purelib: false"]
    (info / "WHEEL").write_text("\n".join([*lines, f"Tag: {wheel.tag}", ""]))
    shutil.copy(ROOT / "LICENSE", info)
    run(sys.executable, "-m", "wheel", "pack", wheel.folder, "--dest-dir", wheel.folder.parent)
    return next(wheel.folder.parent.glob(f"{wheel.name}-*{wheel.tag}.whl"))


def repair(packed: Path, out: Path) -> Path:
    """The wheel with the libraries that it needs, and the tag of the systems that it runs on."""
    command = [tool("auditwheel"), "repair", "--strip", "--only-plat", "--wheel-dir", out]
    command += ["--zip-compression-level", "9", packed]
    for ours in ("libskybody.so.*", "libskybody_learn.so.*"):
        command += ["--exclude", ours]
    before = set(out.glob("*.whl"))
    run(*command)
    (made,) = set(out.glob("*.whl")) - before
    return made


def library_wheel(project: Project, build: Path, work: Path) -> Path:
    """The wheel `libskybody`, not yet repaired."""
    folder = work / "libskybody"
    add_library(build, folder)
    add_licenses(build, folder)
    scripts = folder / f"libskybody-{project.version}.data/scripts"
    scripts.mkdir(parents=True)
    script = shutil.copy(ROOT / "python/program.py", scripts / "skybody")
    Path(script).chmod(0o755)
    return pack(project, Wheel("libskybody", f"py3-none-{platform()}", folder), {}, [])


def package_wheel(project: Project, module: Path, stub: Path, work: Path) -> Path:
    """The wheel `skybody` with one native module, not yet repaired."""
    version = f"cp{sys.version_info.major}{sys.version_info.minor}"
    python = "cp312-abi3" if ".abi3." in module.name else f"{version}-{version}"
    folder = work / python
    add_package(module, stub, folder)
    needs = [f"libskybody=={project.version}", *project.table["dependencies"]]
    extras = project.table["optional-dependencies"]
    return pack(project, Wheel("skybody", f"{python}-{platform()}", folder), extras, needs)


def platform() -> str:
    """The tag of this machine alone."""
    return sysconfig.get_platform().replace("-", "_").replace(".", "_")


def modules(build: Path, folder: Path) -> list[Path]:
    """The native modules that are built."""
    found = [*folder.glob("_native.c*.so")]
    if not found:
        sys.exit(f"error: {folder} has no native module: build skybody_python_stub")
    if cache_value(build, "SKYBODY_STABLE_PYTHON"):  # else one may lie there from before
        found.append(build / "lib/wheel/_native.abi3.so")
    return found


def make(build: Path, out: Path) -> list[Path]:
    """All wheels of a build. Wheels of the same version that lie in `out` are removed."""
    project = Project()
    out.mkdir(parents=True, exist_ok=True)
    for old in out.glob(f"*skybody-{project.version}-*.whl"):
        old.unlink()
    time = run("git", "-C", ROOT, "log", "-1", "--format=%ct").strip()
    os.environ.setdefault("SOURCE_DATE_EPOCH", time)  # the same build gives the same wheel
    os.environ["PATH"] = f"{Path(sys.executable).parent}:{os.environ['PATH']}"  # patchelf
    with tempfile.TemporaryDirectory() as scratch:
        work = Path(scratch)
        os.environ["LD_LIBRARY_PATH"] = f"{work / OLDER}:{build / 'lib/wheel/lapack'}"
        packed = [library_wheel(project, build, work)]
        folder = Path(cache_value(build, "SKYBODY_MODULE_FOLDER"))
        stub = folder / "_native.pyi"
        packed += [package_wheel(project, m, stub, work) for m in modules(build, folder)]
        return [repair(wheel, out) for wheel in packed]


def main() -> int:
    """Makes the wheels and prints their names and sizes; returns the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--build", type=Path, default=ROOT / "build/release")
    parser.add_argument("--out", type=Path, default=ROOT / "build/wheels")
    parser.add_argument("--recompress", action="store_true", help="smaller, in a minute of advzip")
    options = parser.parse_args()
    wheels = make(options.build.resolve(), options.out.resolve())
    if options.recompress:
        run("advzip", "--recompress", "-3", *wheels)
    for wheel in wheels:
        print(f"{wheel.stat().st_size / 1e6:6.2f} MB  {wheel}")
    large = [wheel.name for wheel in wheels if wheel.stat().st_size > LIMIT]
    if large:
        print(f"error: larger than {LIMIT / 1e6:g} MB: {', '.join(large)}", file=sys.stderr)
    return 1 if large else 0


if __name__ == "__main__":
    sys.exit(main())
