# SPDX-License-Identifier: AGPL-3.0-or-later
# From a clone of packMesh:   spack repo add scripts/packaging/spack && spack dev-build packmesh@main
from spack.package import *


class Packmesh(CMakePackage):
    """Packs the surface meshes of blood cells into vessels for HemoCell: to the requested hematocrit; verifies that
    no two overlap and that HemoCell keeps every one. Replaces HemoCell's packCells."""

    homepage = "https://www.hemocell.eu"

    license("AGPL-3.0-or-later")

    version("main", branch="main")

    variant("python", default=True, description="Build the Python package")
    variant("tests", default=False, description="Build the tests")

    extends("python", when="+python")

    depends_on("c", type="build")
    depends_on("cxx", type="build")
    depends_on("cmake@3.25:", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("mpi")
    depends_on("hdf5@1.10:+mpi")
    depends_on("eigen@3.4:3")
    depends_on("openmesh@9:")
    depends_on("tetgen@1.5:1.5+pic")
    depends_on("tinyxml2@8:")
    depends_on("fmt@9:")
    depends_on("nlohmann-json@3.11:")
    depends_on("random123", type="build")
    depends_on("xxhash@0.8:", type="build")
    depends_on("python@3.9:", type=("build", "link", "run"), when="+python")
    depends_on("py-pybind11@2.10:", type="build", when="+python")
    depends_on("py-numpy", type=("build", "run"), when="+python")
    depends_on("py-scipy@1.8:", type="run", when="+python")
    depends_on("py-h5py", type="run", when="+python")
    depends_on("py-jinja2", type="run", when="+python")
    depends_on("catch2@2.13:2", type="build", when="+tests")
    depends_on("glpk", type="build", when="+tests")
    depends_on("gmp", type="build", when="+tests")
    depends_on("povray", type=("build", "run"), when="+tests")

    # Parts of the page of reports. The files of three.js r111 have the checksums of those in its package 0.111.0 for npm.
    resource(name="three", url="https://raw.githubusercontent.com/mrdoob/three.js/r111/build/three.min.js",
             sha256="cd0bb6c699acc574c48ded9499338e69d00c4029bae6512b669b5db74dd8fea6", placement="javascript/three",
             expand=False)
    resource(name="controls",
             url="https://raw.githubusercontent.com/mrdoob/three.js/r111/examples/js/controls/OrbitControls.js",
             sha256="6e83de3bc8156ad002b92bbc9620eec76418d3495458acb5a831cc7227a1b094", placement="javascript/controls",
             expand=False)
    resource(name="chart.js", url="https://github.com/chartjs/Chart.js/releases/download/v3.9.1/chart.js-3.9.1.tgz",
             sha256="111e0751796f087a51e94dfed910ccfb1278fd30e584a6e48514dba9ae7e72c6", placement="javascript/chart.js",
             expand=True)

    def cmake_args(self):
        libraries = self.stage.source_path + "/javascript"
        return [
            self.define_from_variant("BUILD_TESTING", "tests"),
            self.define_from_variant("PACKMESH_PYTHON", "python"),
            self.define("THREE_JS", libraries + "/three/three.min.js"),
            self.define("THREE_CONTROLS_JS", libraries + "/controls/OrbitControls.js"),
            self.define("CHART_JS", libraries + "/chart.js/dist/chart.min.js"), ]

    @run_after("install")
    @on_package_attributes(run_tests=True)
    def packs_a_box(self):
        """A small periodic box is packed, and checked by the program installed."""
        with working_dir("packed", create=True):
            Executable(self.prefix.bin.packMesh)("30", "30", "30", "--hematocrit", "0.3")
            Executable(self.prefix.bin.packMesh)("check", "--box", "30", "30", "30")
