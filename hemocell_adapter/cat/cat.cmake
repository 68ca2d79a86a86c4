# CAT cells of any meshes, for looking at.
add_executable(catCells cat/main.cpp)
target_link_libraries(catCells PRIVATE hemocell_adapter fmt::fmt packmesh_flags)
target_compile_options(catCells PRIVATE ${packmesh_optimized_little})
install(TARGETS catCells)
