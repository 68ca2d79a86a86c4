# packMesh as a part of another project, for example as tools/packMesh of HemoCell's tree.
if(NOT PROJECT_IS_TOP_LEVEL)
  # In HemoCell's tree only the flags that the user has set (CMAKE_CXX_FLAGS of the cache): those that HemoCell adds are for its
  # own code, with -ggdb among them, which makes hundreds of megabytes of a program.
  get_filename_component(hemocell_tools ${PROJECT_SOURCE_DIR} DIRECTORY)
  if(EXISTS ${hemocell_tools}/packCells/packCells.cpp)
    unset(CMAKE_CXX_FLAGS)
  endif()
  # Flags that would change results, or the standard.
  string(REGEX REPLACE "(^| )-(std=[^ ]*|march=[^ ]*|mtune=[^ ]*|ffast-math|Ofast)" "" CMAKE_CXX_FLAGS "${CMAKE_CXX_FLAGS}")
endif()
