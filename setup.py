# SPDX-License-Identifier: AGPL-3.0-or-later
"""Of pyproject.toml: what scikit-build needs to know."""
import re
from pathlib import Path

from skbuild import setup

citation = (Path(__file__).parent / "CITATION.cff").read_text(encoding="utf-8")

setup(
    version=re.search(r"^version: (\S+)$", citation, re.M)[1],
    packages=["packmesh", "packmesh.formats"],
    package_dir={"": "python"},
    package_data={"packmesh": ["py.typed", "_packmesh.pyi", "page/*", "new_case_files/*"]},
    cmake_args=["-DBUILD_TESTING=OFF", "-DPACKMESH_PYTHON=ON", "-DPACKMESH_PYTHON_DIR=python"],
    cmake_install_target="install_python",
)
