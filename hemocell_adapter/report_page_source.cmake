# The page of reports, with its libraries as they are installed: three.js (until version 124, which has controls for pages without
# modules) and Chart.js 3. Elsewhere than in Debian: -DTHREE_JS=<file> and so on.
set(javascript /usr/share/javascript)
find_file(THREE_JS three.min.js PATHS ${javascript}/three NO_DEFAULT_PATH REQUIRED)
find_file(THREE_CONTROLS_JS OrbitControls.js PATHS ${javascript}/three/examples/js/controls NO_DEFAULT_PATH REQUIRED)
find_file(CHART_JS chart.min.js PATHS ${javascript}/chart.js NO_DEFAULT_PATH REQUIRED)
set(page_libraries ${THREE_JS} ${THREE_CONTROLS_JS} ${CHART_JS})
set(page ${CMAKE_CURRENT_SOURCE_DIR}/output/page)
file(GLOB page_files CONFIGURE_DEPENDS ${page}/*)
add_custom_command(OUTPUT ${page_source} DEPENDS ${page_files} ${page_libraries} report_page.cmake
  COMMAND ${CMAKE_COMMAND} -DPAGE=${page} "-DLIBRARIES=${page_libraries}" -DOUTPUT=${page_source}
    -P ${CMAKE_CURRENT_SOURCE_DIR}/report_page.cmake VERBATIM)
