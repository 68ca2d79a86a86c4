# The page of reports: the files in output/page and the libraries, as one string in C++ (output/report_page.cpp).
#   cmake -DPAGE=<folder> -DLIBRARIES=<files> -DOUTPUT=<file> -P report_page.cmake
cmake_minimum_required(VERSION 3.25)
file(READ ${PAGE}/page.html page)
file(READ ${PAGE}/page.css style)
set(libraries)
foreach(file IN LISTS LIBRARIES)
  cmake_path(GET file FILENAME name)
  file(READ ${file} text)
  string(APPEND libraries "<script>/* ${name} */\n${text}\n</script>\n")
endforeach()
set(scripts)
foreach(name data geometry colors tables plots meshes outlines view panel start)
  file(READ ${PAGE}/${name}.js text)
  string(APPEND scripts "${text}\n")
endforeach()
string(REPLACE "@STYLE@" "${style}" page "${page}")
string(REPLACE "@SCRIPTS@" "${scripts}" page "${page}")
string(REPLACE "@LIBRARIES@" "${libraries}" page "${page}")
file(WRITE ${OUTPUT} "#include <string_view>

namespace packmesh::hemocell {
extern const std::string_view pageTemplate;
static constexpr char text[] = R\"packMesh_page(${page})packMesh_page\";
const std::string_view pageTemplate(text, sizeof text - 1);
}  // namespace packmesh::hemocell
")
