# CAT cells of any meshes, for looking at.
add_executable(catCells cat/main.cpp)
target_link_libraries(catCells PRIVATE hemocell_adapter fmt::fmt packmesh_flags)
install(TARGETS catCells)
