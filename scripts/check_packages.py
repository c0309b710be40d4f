#!/usr/bin/env python3
"""scripts/packages.txt holds every package that the build looks for, and none that nothing uses.

    scripts/check_packages.py [ROOT]
"""
import re
import sys
from pathlib import Path

from firn_tree import ROOMS, finish, read, sources

# What CMake looks for -> package ("" = comes with CMake or the compiler).
FOUND_BY_CMAKE = {
    "Catch2": "catch2", "Threads": "", "OpenSSL": "libssl-dev", "benchmark": "libbenchmark-dev", "Eigen3": "libeigen3-dev",
    "fmt": "libfmt-dev", "nlohmann_json": "nlohmann-json3-dev", "CLI11": "libcli11-dev", "Python3": "python3",
    "lcm": "liblcm-dev", "lcm-gen": "liblcm-bin", "ccache": "ccache", "tomlplusplus": "libtomlplusplus-dev",
    "xxhash": "libxxhash-dev", "xxhash.h": "libxxhash-dev", "sleef": "libsleef-dev", "sleef.h": "libsleef-dev", "nlopt": "libnlopt-dev", "nlopt.h": "libnlopt-dev", "nlopt_cxx": "libnlopt-cxx-dev", "python3": "python3", "Java": "default-jdk-headless",
    "dpkg-query": "", "gnuplot": "gnuplot-nox", "clang++": "clang", "avr-gcc": "gcc-avr", "avr/io.h": "avr-libc", "simavr/sim_avr.h": "libsimavr-dev", "simavr": "libsimavr-dev", "ld.gold": "", "zstd": "libzstd-dev",
    "opencv_core": "libopencv-core-dev", "opencv_imgproc": "libopencv-imgproc-dev", "opencv_imgcodecs": "libopencv-imgcodecs-dev", "jpeg": "libjpeg-dev",
    "opencv2/core/version.hpp": "libopencv-core-dev",
    "opencv2/core.hpp": "libopencv-core-dev",
    "opencv_${module}": "libopencv-core-dev", "TBB": "libtbb-dev", "polyclipping": "libpolyclipping-dev",
    "polyclipping/clipper.hpp": "libpolyclipping-dev", "Boost": "libboost-dev", "PNG": "libpng-dev", "EXPAT": "libexpat1-dev", "ZLIB": "zlib1g-dev", "zip": "libzip-dev", "Python3": "python3-dev",
    "pybind11": "pybind11-dev", "mpi": "libopenmpi-dev", "mpi.h": "libopenmpi-dev",
}
FOUND_BY_PREFIX = {"sundials_": "libsundials-dev"}

# Package -> what shows in the sources that it is needed.
EVIDENCE = {
    "g++": r"project\(firn [^)]*\bCXX\)", "cmake": r"cmake_minimum_required", "ninja-build": r"-G Ninja", "ccache": r"find_program\(CCACHE",
    "git": r"\bgit (-C|rev-parse)", "pkg-config": r"pkg_check_modules|\bpkg-config --", "liblcm-dev": r"<lcm/", "liblcm-bin": r"lcm-gen",
    "libeigen3-dev": r"<Eigen/", "libopencv-core-dev": r"<opencv2/core", "libopencv-imgproc-dev": r"<opencv2/imgproc|foreach\(module core imgproc",
    "libopencv-imgcodecs-dev": r"<opencv2/imgcodecs", "libjpeg-dev": r"<jpeglib\.h>", "libsleef-dev": r"<sleef\.h>", "libnlopt-dev": r"<nlopt\.h>|<nlopt\.hpp>", "libnlopt-cxx-dev": r"<nlopt\.hpp>",
    "libsundials-dev": r"<cvode/|<sundials/", "libsundials-cvode6": r"libsundials_cvode\.so\.6",
    "libsundials-nvecserial6": r"libsundials_nvecserial\.so\.6", "libssl-dev": r"<openssl/", "libxxhash-dev": r"<xxhash\.h>",
    "libtomlplusplus-dev": r"<toml\+\+/", "libcli11-dev": r"<CLI/", "nlohmann-json3-dev": r"<nlohmann/", "libfmt-dev": r"<fmt/",
    "gnuplot-nox": r"\bgnuplot\b", "catch2": r"<catch2/", "libbenchmark-dev": r"<benchmark/", "python3": r"env python3",
    "default-jdk-headless": r"find_package\(Java", "default-jre": r"\bXvfb\b", "liblcm-java": r"FIRN_JAVA_FOLDER\}/lcm\.jar",
    "libjchart2d-java": r"FIRN_JAVA_FOLDER\}/jchart2d\.jar", "xvfb": r"\bXvfb\b",
    "libtbb-dev": r"<tbb/", "libpolyclipping-dev": r"<polyclipping/", "libboost-dev": r"<boost/", "libpng-dev": r"<png\.h>",
    "libexpat1-dev": r"<expat\.h>", "zlib1g-dev": r"<zlib\.h>", "libzip-dev": r"<zip\.h>", "libzstd-dev": r"<zstd\.h>", "libsqlite3-dev": r"<sqlite3\.h>",
    "libopenmpi-dev": r"\bmpi\.h\b", "libhdf5-dev": r"<hdf5\.h>", "libhdf5-103-1": r"libhdf5_serial\.so\.103", "libhdf5-hl-100": r"libhdf5_serial_hl\.so\.100", "python3-h5py": r"import h5py", "python3-xarray": r"import xarray", "python3-h5netcdf": r'"h5netcdf"', "python3-netcdf4": r'"netcdf4"', "hdf5-tools": r"\bh5dump\b", "zstd": r'"zstd", "-d"',
    "python3-matplotlib": r"import matplotlib", "python3-jsonschema": r"import jsonschema", "python3-nbformat": r"import nbformat", "python3-dev": r"find_package\(Python3", "pybind11-dev": r"<pybind11/", "python3-numpy": r"import numpy",
    "groff-base": r"\"groff\"", "zsh": r"\"zsh\"", "fish": r"\"fish\"",
    "slurm-wlm": r"slurmctld", "munge": r"munged", "parallel": r"kProgram = \"parallel\"|\"parallel\"", "iproute2": r'"ip", "netns"', "openssh-server": r"\"sshd\"", "openssh-client": r"\"ssh-keygen\"", "rsync": r"\"rsync\"",
    "debootstrap": r"command -v debootstrap", "coinor-cbc": r"command -v cbc", "stress-ng": r'which\("stress-ng"\)', "chromium": r"chromium --headless", "nodejs": r'"node", "--test"', "npm": r'"npm", "ci"', "clang-format": r"clang-format", "clang-tidy": r'"clang-tidy", "--quiet"', "cppcheck": r'"cppcheck", "--std=c11"', "dpkg-dev": r"dpkg-shlibdeps", "mkdocs": r"/usr/bin/mkdocs", "frama-c-base": r'"frama-c"', "lintian": r"\"lintian\"", "clang": r"clang\+\+", "gcc-avr": r"find_program\(AVR_GCC avr-gcc", "avr-libc": r"\bavr/io\.h\b", "libsimavr-dev": r"<simavr/", "libclang-rt-14-dev": r"-fsanitize=fuzzer|sanitize=[\w,]*fuzzer",
}

FIND = re.compile(r"\bfind_(package|library|program|path)\s*\(\s*(\S+)([^)]*)\)")
FIND_HEADERS = re.compile(r"^firn_find_headers\(\S+ \S+ ([^\s)]+)", re.M)  # names its package


def listed(root):
    lines = (re.sub(r"#.*", "", line).strip() for line in read(root, "scripts/packages.txt").splitlines())
    names = (line.partition("|") for line in lines if line and not line.startswith("["))
    return [of_13 if of_12 == "-" else of_12 for of_12, _, of_13 in names]


def wanted_by_cmake(root):
    """(file, what is looked for) for every find_ call; a find_library's first name counts."""
    out = []
    for path in ["CMakeLists.txt"] + sources(root, ROOMS + ("cmake",), {".cmake", ".txt"}):
        if not path.endswith((".cmake", "CMakeLists.txt")) or not (Path(root) / path).is_file():
            continue
        text = re.sub(r"#[^\n]*", "", read(root, path))
        out += [(path, package) for package in FIND_HEADERS.findall(text)]
        for kind, first, rest in FIND.findall(text) if path != "cmake/headers.cmake" else ():
            words = [w for w in rest.split() if w not in ("NAMES", "REQUIRED")]
            out.append((path, first if kind == "package" else words[0] if words else first))
    return out


def check_needed(root):
    have, problems = set(listed(root)), []
    for path, name in wanted_by_cmake(root):
        package = FOUND_BY_CMAKE.get(name, name if name.endswith("-dev") else None)
        for prefix, of_prefix in FOUND_BY_PREFIX.items():
            if name.startswith(prefix):
                package = of_prefix
        if package is None:
            problems.append(f"{path}: looks for {name}, for which scripts/check_packages.py knows no package")
        elif package and package not in have:
            problems.append(f"{path}: looks for {name}: {package} is missing from scripts/packages.txt")
    return problems


def everything(root):
    own = {"scripts/check_packages.py", "scripts/packages.txt"}
    files = sources(root, ROOMS + ("cmake", "scripts", "experiments"), {".h", ".cpp", ".cmake", ".txt", ".py", ".sh"})
    texts = [read(root, p) for p in files if p not in own]
    texts += [read(root, p) for p in ("CMakeLists.txt", "firn", ".ci/run") if (Path(root) / p).is_file()]
    return "\n".join(texts)


def check_used(root):
    text, problems = everything(root), []
    for package in listed(root):
        evidence = EVIDENCE.get(package)
        if evidence is None:
            problems.append(f"scripts/packages.txt: {package}: scripts/check_packages.py does not know what needs it")
        elif not re.search(evidence, text):
            problems.append(f"scripts/packages.txt: {package}: nothing uses it")
    for package, evidence in EVIDENCE.items():
        if package not in listed(root) and re.search(evidence, text):
            problems.append(f"scripts/packages.txt: {package} is missing: {re.search(evidence, text).group(0)!r} needs it")
    return problems


def main():
    root = Path(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).resolve().parent.parent)
    return finish("check_packages", check_needed(root) + check_used(root))


if __name__ == "__main__":
    sys.exit(main())
