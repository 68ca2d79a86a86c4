# packMesh as a part of another project, and as tools/packMesh of HemoCell's tree, where it is a subdirectory or built by
# itself, as HemoCell's own tools are.

# Flags of the project around us that would change results, or the standard.
if(NOT PROJECT_IS_TOP_LEVEL)
  string(REGEX REPLACE "(^| )-(std=[^ ]*|march=[^ ]*|mtune=[^ ]*|ffast-math|Ofast)" "" CMAKE_CXX_FLAGS "${CMAKE_CXX_FLAGS}")
endif()

# Programs go to tools/packMesh/bin; whoever calls tools/packCells/packCells gets ours, unless HemoCell's is there.
cmake_path(GET PROJECT_SOURCE_DIR PARENT_PATH hemocell_tools)
if(EXISTS ${hemocell_tools}/packCells/packCells.cpp)
  set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_SOURCE_DIR}/bin)
  set(packcells ${hemocell_tools}/packCells/packCells)
  if(NOT EXISTS ${packcells} OR IS_SYMLINK ${packcells})
    file(REMOVE ${packcells})
    file(CREATE_LINK ../packMesh/bin/packMesh ${packcells} SYMBOLIC)
    message(STATUS "packMesh: ${packcells} is packMesh in the tongue of packCells")
  else()
    message(STATUS "packMesh: ${packcells} is HemoCell's own and stays; remove it and configure again to get packMesh's")
  endif()
endif()
