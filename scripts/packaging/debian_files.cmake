# What Debian's policy asks of a package besides what is installed: run by cpack before it makes the package (debian.cmake).
set(share ${CPACK_TEMPORARY_DIRECTORY}/usr/share)
if(NOT CPACK_GENERATOR STREQUAL "DEB" OR NOT EXISTS ${share})
  return()
endif()

# Manual pages of all commands, made of what they print.
file(CREATE_LINK packMesh.1.gz ${share}/man/man1/packCells.1.gz SYMBOLIC)
foreach(command catCells packmesh)
  if(NOT EXISTS ${CPACK_TEMPORARY_DIRECTORY}/usr/bin/${command})
    continue()
  endif()
  execute_process(COMMAND ${CPACK_TEMPORARY_DIRECTORY}/usr/bin/${command} --help OUTPUT_VARIABLE help COMMAND_ERROR_IS_FATAL ANY)
  string(REPLACE "\\" "\\\\" help "${help}")
  string(REPLACE "-" "\\-" help "${help}")
  string(REGEX REPLACE "\n([.'])" "\n\\\\&\\1" help "${help}")
  set(what "cells of the chordal axis transform of any meshes")
  if(command STREQUAL "packmesh")
    set(what "shows and converts packings of blood cells")
  endif()
  string(TOUPPER ${command} upper)
  file(WRITE ${share}/man/man1/${command}.1 ".TH ${upper} 1 \"\" \"packMesh ${CPACK_PACKAGE_VERSION}\" \"User Commands\"\n"
    ".SH NAME\n${command} \\- ${what}\n.SH DESCRIPTION\n.nf\n${help}.fi\n.SH SEE ALSO\npackMesh(1)\n")
endforeach()
file(GLOB pages ${share}/man/man1/*.1)

file(MAKE_DIRECTORY ${share}/lintian/overrides)
file(WRITE ${share}/lintian/overrides/packmesh
  "# The programs, the library and the plug-in that cases are linked to are one package.\n"
  "packmesh: package-name-doesnt-match-sonames *\n"
  "packmesh: link-to-shared-library-in-wrong-package *\n"
  "# CPack writes both scripts for packages with a shared library.\n"
  "packmesh: maintscript-calls-ldconfig *\n")
execute_process(COMMAND date --utc --rfc-email --date=${CPACK_PACKMESH_RELEASED} OUTPUT_VARIABLE date OUTPUT_STRIP_TRAILING_WHITESPACE
  COMMAND_ERROR_IS_FATAL ANY)
file(WRITE ${share}/doc/packmesh/changelog "packmesh (${CPACK_PACKAGE_VERSION}) unstable; urgency=medium\n\n"
  "  * Changes are listed in CHANGELOG.md.\n\n -- ${CPACK_PACKAGE_CONTACT}  ${date}\n")
execute_process(COMMAND gzip -9 -n ${pages} ${share}/doc/packmesh/changelog COMMAND_ERROR_IS_FATAL ANY)
