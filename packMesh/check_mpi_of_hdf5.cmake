# A parallel HDF5 that was built with another MPI than packMesh compiles and links, and aborts on several ranks: refused here.
# Compares the MPI library that HDF5 names as needed (none, for a serial HDF5) with those that were found.
function(packmesh_dynamic_names file tag result)
  execute_process(COMMAND ${CMAKE_READELF} --dynamic --wide ${file} OUTPUT_VARIABLE section ERROR_QUIET)
  string(REGEX REPLACE "[][]" "" section "${section}")  # CMake does not divide lists within brackets
  string(REGEX MATCHALL "\\(${tag}\\)[^\n]*" lines "${section}")
  list(TRANSFORM lines REPLACE ".* " "")
  set(${result} ${lines} PARENT_SCOPE)
endfunction()

if(CMAKE_READELF)
  packmesh_dynamic_names(${HDF5_C_LIBRARY_hdf5} NEEDED mpi_of_hdf5)
  list(FILTER mpi_of_hdf5 INCLUDE REGEX "^lib(mpi|mpich|mpi_.*)\\.so")
  set(mpi_found)
  foreach(library ${MPI_CXX_LIBRARIES})
    packmesh_dynamic_names(${library} SONAME names)
    list(APPEND mpi_found ${names})
  endforeach()
  foreach(needed ${mpi_of_hdf5})
    if(mpi_found AND NOT needed IN_LIST mpi_found)
      message(FATAL_ERROR "HDF5 (${HDF5_C_LIBRARY_hdf5}) was built with another MPI (${needed}) than ${MPI_CXX_COMPILER} "
        "(${mpi_found}): such a program aborts on several ranks. State the HDF5 of that MPI by its compiler wrapper, and begin with an empty "
        "build folder. On Debian, for MPICH: -DMPI_CXX_COMPILER=mpicxx.mpich -DHDF5_C_COMPILER_EXECUTABLE=/usr/bin/h5pcc.mpich")
    endif()
  endforeach()
endif()
