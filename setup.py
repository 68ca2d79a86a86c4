# SPDX-License-Identifier: AGPL-3.0-or-later
"""Of pyproject.toml: what scikit-build needs to know."""
import re
from pathlib import Path

from setuptools import find_packages
from skbuild import setup

citation = (Path(__file__).parent / "CITATION.cff").read_text(encoding="utf-8")

setup(
    version=re.search(r"^version: (\S+)$", citation, re.M)[1],
    packages=find_packages("python"),
    package_dir={"": "python"},
    package_data={"packmesh": ["py.typed", "_packmesh.pyi", "show/page/*", "cases/templates/*"]},
    cmake_args=["-DBUILD_TESTING=OFF", "-DPACKMESH_PYTHON=ON", "-DPACKMESH_PYTHON_DIR=python"],
    cmake_install_target="install_python",
)
