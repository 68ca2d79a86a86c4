# SPDX-License-Identifier: AGPL-3.0-or-later
"""Of pyproject.toml: what scikit-build needs to know."""
from skbuild import setup

setup(
    packages=["packmesh", "packmesh.formats"],
    package_dir={"": "python"},
    package_data={"packmesh": ["py.typed", "_packmesh.pyi", "page/*"]},
    cmake_args=["-DBUILD_TESTING=OFF", "-DPACKMESH_PYTHON=ON", "-DPACKMESH_PYTHON_DIR=python"],
    cmake_install_target="install_python",
)
