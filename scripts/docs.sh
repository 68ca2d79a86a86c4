#!/usr/bin/env bash
# Builds the documentation as a static site in build/docs: scripts/docs.sh
# Warnings, broken links among them, are errors. PACKMESH_SKIP_SETUP=1: MkDocs and Doxygen are already installed.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
scripts/setup.sh --documentation
tests/scripts/links.py "$PWD"

# Pages link to examples and configuration files, so the site has the same tree as the repository.
source=build/docs-source site=build/docs
rm -rf "$source" "$site"
mkdir -p "$source/scripts/packaging" "$source/tests/benchmark"
cp -r README.md CHANGELOG.md CITATION.cff LICENSE docs examples config "$source"
rm "$source"/docs/paper/paper.* "$source/docs/mkdocs.yml"
cp tests/benchmark/README.md tests/benchmark/problems.json "$source/tests/benchmark"
cp -r scripts/packaging/spack scripts/packaging/conda scripts/packaging/Dockerfile "$source/scripts/packaging"
cp scripts/apt-packages.txt "$source/scripts"

echo '
<a href="../../api/index.html">Documentation of the headers</a>' >> "$source/docs/reference/headers.md"

mkdocs build --quiet --strict --config-file docs/mkdocs.yml --site-dir "$PWD/$site"
{ printf 'window.searchIndex = '; cat "$site/search/search_index.json"; } > "$site/search/search_index.js"  # for pages opened as files
doxygen - << DOXYFILE
PROJECT_NAME = packMesh
INPUT = packMesh/packing packMesh/container packMesh/shape packMesh/certificate packMesh/mesh
FILE_PATTERNS = *.h
INPUT_FILTER = "sed 's,^/// @file ,/// @file\n/// ,'"
EXTRACT_ALL = YES
STRIP_FROM_PATH = .
OUTPUT_DIRECTORY = $site
HTML_OUTPUT = api
GENERATE_LATEX = NO
JAVADOC_AUTOBRIEF = YES
HAVE_DOT = NO
WARN_IF_INCOMPLETE_DOC = NO
QUIET = YES
WARN_AS_ERROR = FAIL_ON_WARNINGS
DOXYFILE
echo "(packMesh) Wrote $site/index.html"
