#!/usr/bin/env python3
"""The recipes of scripts/packaging/ are well-formed and agree with the build: the Spack recipe is executed against a stand-in of Spack,
the conda recipe is read with the rules of conda-forge's linter, the Dockerfile instruction by instruction with the rules of
hadolint that matter here.

    recipes.py <source tree>
"""
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import types
from pathlib import Path

root = Path(sys.argv[1])
faults = []


def check(right, text):
    if not right:
        faults.append(text)


def cited(key):
    """What CITATION.cff states, the one home of version, repository and contact."""
    return re.search(rf'^ *{key}: "?([^"\n]+)"?$', (root / "CITATION.cff").read_text(encoding="utf-8"), re.M)[1]


def directives_of(recipe):
    """What the recipe declares, by a stand-in for the module that Spack offers."""
    called = []
    stand_in = types.ModuleType("spack.package")

    def directive(name):
        return lambda *arguments, **options: called.append((name, arguments, options))

    for name in ("version", "variant", "depends_on", "license", "conflicts", "extends", "resource"):
        setattr(stand_in, name, directive(name))
    stand_in.CMakePackage = type(
        "CMakePackage", (), {
            "define_from_variant": lambda self, name, variant: f"-D{name}={variant}",
            "define": lambda self, name, value: f"-D{name}={value}", "stage": types.SimpleNamespace(source_path="/stage")})
    stand_in.run_after = lambda *arguments, **options: lambda function: function
    stand_in.on_package_attributes = lambda **options: lambda function: function
    sys.modules["spack"], sys.modules["spack.package"] = types.ModuleType("spack"), stand_in
    names = {}
    exec(compile(recipe.read_text(encoding="utf-8"), str(recipe), "exec"), names)
    return names["Packmesh"], called


def check_spack():
    recipe = root / "scripts/packaging/spack/packages/packmesh/package.py"
    package, called = directives_of(recipe)
    check(package.__doc__ and package.homepage, "Spack: no description or homepage")
    given = dict(argument[2:].split("=") for argument in package().cmake_args())
    for name, variant in (("BUILD_TESTING", "tests"), ("PACKMESH_PYTHON", "python")):
        check(given.pop(name, None) == variant, f"Spack: {name} does not follow the variant")
    resources = [options for name, _, options in called if name == "resource"]
    for name, path in given.items():
        check(
            any(
                path.startswith(f"/stage/{one['placement']}/") if one["expand"] else path ==
                f"/stage/{one['placement']}/{Path(one['url']).name}" for one in resources), f"Spack: no resource has {path}")
    conda = re.findall(r"^  - url: (\S+)\n    sha256: ([0-9a-f]{64})$",
                       (root / "scripts/packaging/conda/meta.yaml").read_text(), re.M)
    check(
        sorted((one["url"], one["sha256"]) for one in resources) == sorted(conda), "Spack and conda do not take the same files")
    own = ("https://raw.githubusercontent.com/mrdoob/three.js/", "https://github.com/chartjs/Chart.js/releases/")
    check(all(url.startswith(own) for url, _ in conda), f"not from the projects themselves: {conda}")
    found = set(re.findall(r"^find_file\((\w+)", (root / "python/CMakeLists.txt").read_text(), re.M))
    check(found == set(given), f"Spack: CMake looks for {sorted(found)}, the recipe gives {sorted(given)}")
    check("namespace: packmesh" in (root / "scripts/packaging/spack/repo.yaml").read_text(),
          "Spack: repo.yaml has no namespace")
    variants = {arguments[0] for name, arguments, _ in called if name == "variant"}
    needed = {}
    for name, arguments, options in called:
        if name != "depends_on":
            continue
        spec = arguments[0]
        check(re.fullmatch(r"[a-z0-9-]+(@[\d.]*:?[\d.]*)?([+~][a-z]+)*", spec), f"Spack: '{spec}' is no spec")
        when = options.get("when", "")
        check(not when or when.lstrip("+~") in variants, f"Spack: '{when}' names no variant")
        kinds = options.get("type", "link")
        check(set([kinds] if isinstance(kinds, str) else kinds) <= {"build", "link", "run"}, f"Spack: type of '{spec}'")
        needed[re.match(r"[a-z0-9-]+", spec).group()] = spec
    # What Debian's list calls otherwise.
    spack_name = {
        "libeigen3-dev": "eigen", "libfmt-dev": "fmt", "libhdf5-openmpi-dev": "hdf5", "libopenmesh-dev": "openmesh",
        "libopenmpi-dev": "mpi", "librandom123-dev": "random123", "libtet1.5-dev": "tetgen", "libtinyxml2-dev": "tinyxml2",
        "nlohmann-json3-dev": "nlohmann-json", "libxxhash-dev": "xxhash", "catch2": "catch2", "libglpk-dev": "glpk",
        "libgmp-dev": "gmp", "cmake": "cmake", "pkg-config": "pkgconfig", "pybind11-dev": "py-pybind11",
        "python3-dev": "python", "python3-numpy": "py-numpy", "python3-scipy": "py-scipy", "python3-h5py": "py-h5py",
        "python3-jinja2": "py-jinja2"}
    listed = {line.split("#")[0].strip() for line in (root / "scripts/apt-packages.txt").read_text().splitlines()}
    for debian, spack in spack_name.items():
        check(debian in listed, f"scripts/apt-packages.txt does not list {debian} any more, the Spack recipe does ({spack})")
        check(spack in needed, f"Spack: {spack} ({debian}) is missing")
    unknown = {p for p in listed
               if p.endswith("-dev") and p not in spack_name and "mpich" not in p}  # MPICH is an `mpi` of Spack
    check(not unknown, f"Spack: nothing corresponds to {sorted(unknown)}")
    least = re.search(r"cmake_minimum_required\(VERSION ([\d.]+)\)", (root / "CMakeLists.txt").read_text()).group(1)
    check(needed.get("cmake") == f"cmake@{least}:", f"Spack: CMake {least} is needed, not {needed.get('cmake')}")


def check_conda():
    """The rules of conda-forge's linter that apply to a recipe inside the tree."""
    text = (root / "scripts/packaging/conda/meta.yaml").read_text(encoding="utf-8")
    variables = dict(re.findall(r'^{% set (\w+) = "([^"]*)" %}$', text, re.M))
    file, pattern = re.search(
        r'^{% set citation = load_file_regex\(load_file="([^"]+)", regex_pattern="([^"]+)", from_recipe_dir=True\) %}\n'
        r"{% set version = citation\[1\] %}$", text, re.M).groups()
    variables["version"] = re.search(pattern.replace("\\\\", "\\"),
                                     (root / "scripts/packaging/conda" / file).read_text(encoding="utf-8"))[1]
    plain = re.sub(r"^{%.*%}\n", "", text, flags=re.M)
    plain = re.sub(r"{{ compiler\('(\w+)'\) }}", r"compiler_\1", plain)
    plain = re.sub(r"{{ (\w+) }}", lambda m: variables.get(m[1], "UNKNOWN"), plain)
    check("UNKNOWN" not in plain and "{{" not in plain, "conda: a variable is not set")
    plain = re.sub(r"^#.*\n", "", plain, flags=re.M)
    sections = re.findall(r"^(\w+):$", plain, re.M)
    order = ["package", "source", "build", "requirements", "test", "about", "extra"]
    check(sections == order, f"conda: the sections are {sections}, not {order}")
    check(re.search(r"^  version: (.*)$", plain, re.M)[1] == cited("version"), "conda: the version is not that of CITATION.cff")
    for line in ("  name: packmesh", "  number: 0", "  license: AGPL-3.0-or-later", "  license_file: LICENSE"):
        check(f"\n{line}\n" in plain, f"conda: no line '{line.strip()}'")
    for key in ("home", "summary", "description", "recipe-maintainers", "commands", "git_rev"):
        check(re.search(rf"^ +{key}:", plain, re.M), f"conda: no {key}")
    check(not re.search(r"[ \t]+$", text, re.M) and text.endswith("\n") and not text.endswith("\n\n"),
          "conda: blanks at ends of lines, or the last line")
    needed = dict(
        re.findall(r"^    - ([a-z0-9_-]+)(?: (.*))?$",
                   re.search(r"^requirements:\n(.*?)^test:", plain, re.M | re.S)[1], re.M))
    for package in ("compiler_c", "compiler_cxx", "ninja", "pkg-config", "openmpi", "hdf5", "eigen", "openmesh", "tetgen",
                    "tinyxml2", "fmt", "nlohmann_json", "xxhash", "numpy", "scipy", "h5py", "jinja2"):
        check(package in needed, f"conda: {package} is missing")
    for name in re.findall(r"^find_file\((\w+)", (root / "python/CMakeLists.txt").read_text(), re.M):
        check(f"-D{name}=" in plain, f"conda: CMake looks for {name}, the recipe does not give it")
    least = re.search(r"cmake_minimum_required\(VERSION ([\d.]+)\)", (root / "CMakeLists.txt").read_text()).group(1)
    check(needed.get("cmake") == f">={least}", f"conda: CMake {least} is needed, not {needed.get('cmake')}")


def check_cmake():
    """What CMake finds is in the list of packages."""
    debian_name = {
        "Eigen3": "libeigen3-dev", "RANDOM123": "librandom123-dev", "XXHASH": "libxxhash-dev", "MPI": "libopenmpi-dev",
        "HDF5": "libhdf5-openmpi-dev", "OpenMesh": "libopenmesh-dev", "fmt": "libfmt-dev",
        "nlohmann_json": "nlohmann-json3-dev", "TINYXML2": "libtinyxml2-dev", "TetGen": "libtet1.5-dev",
        "PkgConfig": "pkg-config", "Threads": "build-essential", "Catch2": "catch2", "Python": "python3-dev", "Git": "git",
        "pybind11": "pybind11-dev"}
    listed = {line.split("#")[0].strip() for line in (root / "scripts/apt-packages.txt").read_text().splitlines()}
    for lists in ("CMakeLists.txt", "python/CMakeLists.txt", "tests/CMakeLists.txt"):
        text = (root / lists).read_text()
        found = re.findall(r"^ *(?:find_package|pkg_check_modules)\((\w+)", text, re.M) \
            + [name.removesuffix("_INCLUDE_DIR") for name in re.findall(r"^ *find_path\((\w+)", text, re.M)]
        for name in found:
            check(name in debian_name, f"{lists}: the package that has {name} is not known to recipes.py")
            package = debian_name.get(name, "")
            check(package in listed, f"{lists} finds {name}, scripts/apt-packages.txt lacks {package}")
    check("scripts/setup.sh" in (root / "scripts/packaging/Dockerfile").read_text(),
          "Dockerfile: scripts/setup.sh does not install")
    check("python3-numpy" in (root / "scripts/packaging/debian.cmake").read_text(),
          "Debian package: the Python package needs NumPy")
    check("SHLIBDEPS ON" in (root / "scripts/packaging/debian.cmake").read_text(), "Debian package: no dpkg-shlibdeps")


def check_setup():
    """Tests that need what a system does not have do not keep setup.sh from installing the rest; libraries that it lacks do."""
    tools = {
        "dpkg-query": "exit 1", "sudo": 'exec "$@"',
        "apt-cache": '[ $1 = policy ] || exit 1; case $2 in $LACKING) ;; *) echo "  Candidate: 1.0" ;; esac',
        "apt-get": 'for word; do case $word in $LACKING) exit 100 ;; esac; done; [ $1 = update ] || echo "installed $*"'}
    with tempfile.TemporaryDirectory() as folder:
        for name, text in tools.items():
            (Path(folder) / name).write_text(f"#!/bin/sh\n{text}\n")
            (Path(folder) / name).chmod(0o755)
        for form, lacking, code in (("--full", "chromium", 0), ("--full", "none", 0), ("--full", "libfmt-dev", 1),
                                    ("--without-tests", "libfmt-dev", 1)):
            done = subprocess.run(
                [root / "scripts/setup.sh", form], text=True, capture_output=True,
                env={**os.environ, "PATH": f"{folder}:{os.environ['PATH']}", "LACKING": lacking, "PACKMESH_SKIP_SETUP": "0"})
            check(done.returncode == code, f"setup.sh {form} without {lacking} ends with {done.returncode}: {done.stderr}")
            words = done.stdout.partition("installed ")[2].split()
            check(code or ("libfmt-dev" in words and "valgrind" in words and lacking not in words),
                  f"setup.sh {form} without {lacking} installs {words}")


def check_citation():
    """CITATION.cff has the version, the repository and the contact; nothing else states them."""
    for value in (cited("repository-code"), cited("email")):
        listed = subprocess.run(["git", "-C", str(root), "grep", "-lIF", value], text=True, capture_output=True).stdout.split()
        check(set(listed) <= {"CITATION.cff"}, f"{value} of CITATION.cff stands in {listed}, too")
    for file in ("CMakeLists.txt", "pyproject.toml", "setup.py"):
        check(not re.search(r"(?i)^.*version *=? *\"?\d+\.\d+\.\d+\"?$", (root / file).read_text(encoding="utf-8"), re.M),
              f"{file} states a version")
    paper = (root / "docs/paper/paper.md").read_text(encoding="utf-8")
    authors = re.findall(r'^  - name: "(.*)"$',
                         (root / "CITATION.cff").read_text(encoding="utf-8").split("\nauthors:\n")[1].split("\nkeywords:")[0],
                         re.M)
    check(
        re.findall(r"^  - name: (.*)$",
                   paper.split("affiliations:")[0], re.M) == authors, "paper.md: the authors are not those of CITATION.cff")
    used = set(re.findall(r"@(\w+)", paper.split("\n---\n", 1)[1]))
    listed = set(re.findall(r"^@\w+{(\w+),$", (root / "docs/paper/paper.bib").read_text(encoding="utf-8"), re.M))
    check(used == listed, f"paper.md and paper.bib do not have the same references: {sorted(used ^ listed)}")
    check(f"## [{cited('version')}]" in (root / "CHANGELOG.md").read_text(encoding="utf-8"),
          "CHANGELOG.md has no section of the version in CITATION.cff")


def check_dockerfile():
    text = re.sub(r"^#.*\n", "", (root / "scripts/packaging/Dockerfile").read_text(encoding="utf-8"), flags=re.M)
    instructions = [line.split(None, 1) for line in re.sub(r"\\\n", " ", text).splitlines() if line.strip()]
    known = {"FROM", "RUN", "COPY", "WORKDIR", "ENTRYPOINT", "CMD", "USER", "SHELL", "LABEL", "ENV", "ARG"}
    stages = []
    for instruction, value in instructions:
        check(instruction in known, f"Dockerfile: unknown instruction {instruction}")
        if instruction == "FROM":
            image, *name = value.split()
            check(":" in image and not image.endswith(":latest"), f"Dockerfile: {image} has no tag (DL3006, DL3007)")
            stages.append(name[1] if name else "")
        elif instruction in ("ENTRYPOINT", "CMD", "SHELL"):
            check(isinstance(json.loads(value), list), f"Dockerfile: {instruction} must be a list (DL3025)")
        elif instruction == "WORKDIR":
            check(value.startswith("/"), "Dockerfile: WORKDIR must be absolute (DL3000)")
        elif instruction == "COPY" and "--from=" in value:
            check(re.search(r"--from=(\w+)", value).group(1) in stages, f"Dockerfile: COPY {value} names no stage (DL3022)")
        elif instruction == "RUN":
            check("sudo" not in value and not re.search(r"\bcd\b", value), "Dockerfile: sudo or cd (DL3004, DL3003)")
            if "apt-get install" in value:
                check("--no-install-recommends" in value and " -y" in value, "Dockerfile: apt-get install (DL3014, DL3015)")
                check("rm -rf /var/lib/apt/lists" in value, "Dockerfile: package lists stay (DL3009)")
            for script in re.findall(r"\bscripts/\S+", value):
                check((root / script).exists(), f"Dockerfile: there is no {script}")
            if shutil.which("shellcheck"):
                found = subprocess.run(["shellcheck", "-s", "bash", "-"], input=value, text=True, capture_output=True)
                check(found.returncode == 0, f"Dockerfile: {found.stdout}")
    check([v for i, v in instructions if i == "USER"][-1:] not in ([], ["root"]), "Dockerfile: the last user is root (DL3002)")
    check(instructions[0][0] == "FROM" and len(stages) == 2, "Dockerfile: a stage that builds and one that runs")


check_spack()
check_conda()
check_cmake()
check_setup()
check_citation()
check_dockerfile()
print("\n".join(faults) or "The recipes are well-formed")
sys.exit(1 if faults else 0)
