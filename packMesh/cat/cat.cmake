# What the wing needs that the rest of the library does not: OpenMesh, and TetGen in a program of its own.
target_link_libraries(packMesh PRIVATE OpenMeshCore OpenMeshTools)

# OpenMesh's property containers copy what g++ takes for uninitialised.
set_source_files_properties(cat/levels_of_detail.cpp PROPERTIES
  COMPILE_OPTIONS $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)

# TetGen in a program of its own, which the library starts (cat/tetgen_run.h).
add_executable(packmesh_tetgen cat/main.cpp cat/tetgen_data.cpp core/vector.cpp)
set_target_properties(packmesh_tetgen PROPERTIES OUTPUT_NAME packmesh-tetgen
  RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/libexec/packmesh)
target_compile_features(packmesh_tetgen PRIVATE cxx_std_17)
target_include_directories(packmesh_tetgen PRIVATE ${PROJECT_SOURCE_DIR})
target_link_libraries(packmesh_tetgen PRIVATE Eigen3::Eigen Threads::Threads TetGen::TetGen packmesh_flags)
add_dependencies(packMesh packmesh_tetgen)
install(TARGETS packmesh_tetgen DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/packmesh)
