// SPDX-License-Identifier: AGPL-3.0-or-later
/// @file packmesh-tetgen: reads surfaces and writes tetrahedra between them, by TetGen. Started by packMesh
/// alone (cat/tetgen_run.h), once for each run; it may crash or be ended at any time.
#define TETLIBRARY
#include <tetgen.h>

#include <poll.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <new>
#include <thread>
#include <type_traits>

#include "packMesh/cat/tetgen_run.h"
#include "packMesh/core/box.h"

using namespace packmesh;

namespace {

constexpr int starter = 3;  ///< descriptor of the socket to the process that has started this one

/// O0: no flips afterwards, so that tetrahedra are Delaunay; T: relative tolerance of coplanarity, which may
/// be as small as rounding errors for surfaces that are known not to intersect. Then a looser tolerance, then
/// (Y) no new points on surfaces, but within the volume.
constexpr const char* variants[tetgenVariants] = {"O0T1e-14", "O0T1e-10", "YO0T1e-14"};

/// tetgenio deletes its arrays; here it references arrays that belong to others.
struct BorrowedInput : tetgenio {
  std::vector<polygon> polygons;
  std::vector<facet> facets;

  explicit BorrowedInput(const TetgenInput& input)
      : polygons(input.triangles.size()), facets(polygons.size()) {
    // TetGen does not modify its input, but predates const.
    const auto borrow = [](const auto* data) { return const_cast<std::decay_t<decltype(*data)>*>(data); };
    pointlist = borrow(input.points.data()->data());
    numberofpoints = static_cast<int>(input.points.size());
    for (std::size_t t = 0; t < polygons.size(); ++t) {
      polygons[t] = {borrow(input.triangles[t].data()), 3};
      facets[t] = {&polygons[t], 1, nullptr, 0};
    }
    facetlist = facets.data();
    facetmarkerlist = borrow(input.triangleLabels.data());
    numberoffacets = static_cast<int>(facets.size());
  }
  ~BorrowedInput() {
    pointlist = nullptr;
    facetlist = nullptr;
    facetmarkerlist = nullptr;
  }
  BorrowedInput(const BorrowedInput&) = delete;
  BorrowedInput& operator=(const BorrowedInput&) = delete;
};

std::string switchesOf(const TetgenInput& input) {
  // Q: quiet; J: points keep their indices; p: respects triangles; d: lists those that intersect; M: does not
  // merge them; c: keeps the convex hull; A: numbers regions; F: no list of faces.
  std::string switches = "QJ";
  if (input.triangles.empty())
    switches += "F";
  else
    switches += std::string(input.crossings ? "pdM" : "pM") + variants[input.variant];
  if (input.keepHull) switches += "c";
  if (input.regions) switches += "A";
  return switches;
}

TetgenOutput outputOf(const tetgenio& out, const TetgenInput& input) {
  TetgenOutput output;
  output.points = input.points;
  if (input.subfaces || input.crossings) {
    output.subfaces.resize(out.numberoftrifaces);
    for (int f = 0; f < out.numberoftrifaces; ++f)
      std::copy_n(out.trifacelist + 3 * f, 3, output.subfaces[f].data());
    output.subfaceLabels.assign(out.trifacemarkerlist, out.trifacemarkerlist + out.numberoftrifaces);
  }
  if (input.crossings) return output;
  const int given = static_cast<int>(input.points.size());
  const auto* points = reinterpret_cast<const double(*)[3]>(out.pointlist);
  for (int p = given; p < out.numberofpoints; ++p)
    output.points.emplace_back(points[p][0], points[p][1], points[p][2]);
  output.steinerLabels.assign(out.numberofpoints - given, 0);
  for (int corner = 0; corner < 3 * out.numberoftrifaces; ++corner)
    if (const int steiner = out.trifacelist[corner] - given; steiner >= 0)
      output.steinerLabels[steiner] = out.trifacemarkerlist[corner / 3];
  output.tetrahedra.resize(out.numberoftetrahedra);
  std::copy_n(out.tetrahedronlist, 4 * output.tetrahedra.size(),
              output.tetrahedra.empty() ? nullptr : output.tetrahedra[0].data());
  if (out.numberoftetrahedronattributes > 0) {
    // TetGen counts from 1; the region outside of all surfaces is -1.
    output.regions.assign(out.tetrahedronattributelist,
                          out.tetrahedronattributelist + out.numberoftetrahedra);
    for (int& region : output.regions) region = std::max(region, 0);
  }
  return output;
}

std::string received() {
  std::string bytes;
  char buffer[1 << 16];
  for (;;) {
    const ssize_t n = read(starter, buffer, sizeof buffer);
    if (n == 0) return bytes;
    if (n > 0)
      bytes.append(buffer, static_cast<std::size_t>(n));
    else if (errno != EINTR)
      return {};
  }
}

/// Writes the answer and ends the process, without what is done at the end of main(): TetGen may have
/// destroyed what it uses.
[[noreturn]] void answer(const TetgenAnswer& answer) {
  const std::string bytes = messageOf(answer);
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t n = write(starter, bytes.data() + at, bytes.size() - at);
    if (n < 0 && errno != EINTR) _exit(1);
    if (n > 0) at += static_cast<std::size_t>(n);
  }
  std::fflush(stdout);
  _exit(0);
}

/// TetGen gives up by freeing its mesh and throwing a number. The destructor of the mesh would free it again;
/// but nothing is destroyed before this handler is called, because nothing catches the exception.
[[noreturn]] void answerException() {
  TetgenAnswer failure;
  failure.code = TetgenFailure::unknown;
  try {
    throw;
  } catch (int code) {
    failure.code = code;
  } catch (const std::bad_alloc&) {
    failure.code = TetgenFailure::outOfMemory;
  } catch (...) {
  }
  answer(failure);
}

/// Ends this process when the one that has started it closes the socket or ends.
void watchStarter() {
  std::thread([] {
    pollfd socket{starter, 0, 0};  // waits for POLLHUP: both directions are closed
    while (poll(&socket, 1, -1) < 0 && errno == EINTR) continue;
    _exit(1);
  }).detach();
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 2 && std::string(argv[1]) == "--version") {
    std::puts(tetgenProgramVersion().c_str());
    return 0;
  }
  const rlimit none = {0, 0};
  setrlimit(RLIMIT_CORE, &none);  // a crash is an answer, too
  const std::optional<TetgenInput> input = tetgenInputOf(received());
  if (!input) {
    std::fputs("there are no surfaces to be read; packMesh starts this program\n", stderr);
    return 2;
  }
  watchStarter();
  std::set_terminate(answerException);
  Box extent;
  for (const Vec3& p : input->points) extent.add(p);
  if (input->points.size() < 4 || !(extent.size().array() > 0.0).all()) {
    TetgenAnswer failure;
    failure.code = TetgenFailure::badInput;  // TetGen would fail an assertion
    answer(failure);
  }
  tetgenio out;
  BorrowedInput in(*input);
  tetrahedralize(switchesOf(*input).data(), &in, &out);
  answer({outputOf(out, *input), 0});
}
