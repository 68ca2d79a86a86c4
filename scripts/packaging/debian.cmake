# A Debian package: cpack -G DEB --config <build tree>/CPackConfig.cmake. dpkg-shlibdeps finds the libraries
# that it depends on.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME packmesh)
set(CPACK_PACKAGE_VENDOR "The packMesh developers")
set(CPACK_PACKAGE_CONTACT "The packMesh developers <${packmesh_contact}>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY ${PROJECT_DESCRIPTION})
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_PACKAGE_DEPENDS python3)  # the command packmesh
file(WRITE ${PROJECT_BINARY_DIR}/debian/triggers "activate-noawait ldconfig\n")
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA ${PROJECT_BINARY_DIR}/debian/triggers)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_CURRENT_LIST_DIR}/debian_files.cmake)
packmesh_citation(date-released CPACK_PACKMESH_RELEASED)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "openmpi-bin, python3-numpy, python3-scipy, python3-h5py, python3-jinja2")  # mpirun; what the Python package needs
# Pictures; what find_package(packMesh) looks for.
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "povray, python3-meshio, python3-vtk9, libfmt-dev, libhdf5-openmpi-dev, libopenmesh-dev, libopenmpi-dev, libtinyxml2-dev")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "Fills vessels with the surface meshes of blood cells that HemoCell will
simulate, to the requested hematocrit, and verifies that no two of them
overlap and that HemoCell keeps every one. Replaces HemoCell's packCells.")
include(CPack)
