// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/growth/tetgen_run.h"

#define TETLIBRARY
#include <tetgen.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

#include "packMesh/core/child_process.h"
#include "packMesh/growth/tetgen_call.h"

namespace packmesh {
namespace {

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

/// While an instance exists, the output of TetGen is captured.
class Listener {
 public:
  Listener() : stream_(open_memstream(&text_, &size_)) {
    if (stream_) stdout = stream_;
  }
  ~Listener() {
    stdout = saved_;
    if (stream_) std::fclose(stream_);
    std::free(text_);
  }
  Listener(const Listener&) = delete;
  Listener& operator=(const Listener&) = delete;

  /// As one line.
  std::string heard() {
    if (!stream_) return {};
    std::fflush(stream_);
    std::string line;
    for (std::size_t k = 0; k < size_; ++k) {
      const bool space = text_[k] == '\n' || text_[k] == ' ';
      if (!space || (!line.empty() && line.back() != ' ')) line += space ? ' ' : text_[k];
    }
    if (!line.empty() && line.back() == ' ') line.pop_back();
    return line;
  }

 private:
  FILE* saved_ = stdout;
  char* text_ = nullptr;
  std::size_t size_ = 0;
  FILE* stream_;
};

std::string meaningOf(int code) {
  switch (code) {
    case 1:
      return "it ran out of memory";
    case 3:
      return "it found surfaces that intersect";
    case 4:
      return "it found edges or angles too small for it";
    case 5:
      return "it found surfaces too close to each other";
    case TetgenFailure::badInput:
      return "it rejected its input";
    case TetgenFailure::stopped:
      return "it was stopped";
    case TetgenGaveUp::assertion:
      return "one of its assertions failed";
    default:
      return "internal error of TetGen";
  }
}

TetgenOutput resultOf(const tetgenio& out, const TetgenInput& input) {
  TetgenOutput result;
  const int given = static_cast<int>(input.points.size());
  const auto* points = reinterpret_cast<const double(*)[3]>(out.pointlist);
  result.points = input.points;
  for (int p = given; p < out.numberofpoints; ++p)
    result.points.emplace_back(points[p][0], points[p][1], points[p][2]);
  result.steinerLabels.assign(out.numberofpoints - given, 0);
  for (int corner = 0; corner < 3 * out.numberoftrifaces; ++corner)
    if (const int steiner = out.trifacelist[corner] - given; steiner >= 0)
      result.steinerLabels[steiner] = out.trifacemarkerlist[corner / 3];
  result.tetrahedra.resize(out.numberoftetrahedra);
  std::copy_n(out.tetrahedronlist, 4 * result.tetrahedra.size(),
              result.tetrahedra.empty() ? nullptr : result.tetrahedra[0].data());
  if (out.numberoftetrahedronattributes > 0) {
    // TetGen counts from 1; the region outside of all surfaces is -1.
    result.regions.assign(out.tetrahedronattributelist,
                          out.tetrahedronattributelist + out.numberoftetrahedra);
    for (int& region : result.regions) region = std::max(region, 0);
  }
  if (input.subfaces) {
    result.subfaces.resize(out.numberoftrifaces);
    for (int f = 0; f < out.numberoftrifaces; ++f)
      std::copy_n(out.trifacelist + 3 * f, 3, result.subfaces[f].data());
    result.subfaceLabels.assign(out.trifacemarkerlist, out.trifacemarkerlist + out.numberoftrifaces);
  }
  return result;
}

TetgenOutput runHere(const TetgenInput& input, int variant, TetgenFailure& failure) {
  // Q: quiet; J: points keep their indices; p: respects triangles; M: does not merge them; c: keeps the
  // convex hull; A: numbers regions; F: no list of faces.
  std::string switches = "QJ";
  if (input.triangles.empty())
    switches += "F";
  else
    switches += std::string("pM") + variants[variant];
  if (input.keepHull) switches += "c";
  if (input.regions) switches += "A";
  failure = {};
  Box extent;
  for (const Vec3& p : input.points) extent.add(p);
  if (input.points.size() < 4 || !(extent.size().array() > 0.0).all()) {
    failure.code = TetgenFailure::badInput;  // an assertion would end the process
    return {};
  }
  tetgenio out;
  BorrowedInput in(input);
  Listener listener;
  try {
    const TetgenCall call;
    tetrahedralize(switches.data(), &in, &out);
    return resultOf(out, input);
  } catch (const TetgenGaveUp& gaveUp) {
    failure.code = gaveUp.code;
  } catch (int code) {
    failure.code = code;
  } catch (const std::bad_alloc&) {
    failure.code = 1;
  }
  failure.words = listener.heard();
  return {};
}

/// Visits all members of a run's output.
template <class Output, class Failure, class Visit>
void forEachTable(Output& output, Failure& failure, Visit&& visit) {
  visit(output.points);
  visit(output.steinerLabels);
  visit(output.tetrahedra);
  visit(output.regions);
  visit(output.subfaces);
  visit(output.subfaceLabels);
  visit(failure.words);
}

std::string bytesOf(const TetgenOutput& output, const TetgenFailure& failure) {
  std::string bytes(reinterpret_cast<const char*>(&failure.code), sizeof failure.code);
  forEachTable(output, failure, [&](const auto& table) {
    const std::size_t size = table.size();
    bytes.append(reinterpret_cast<const char*>(&size), sizeof size);
    bytes.append(reinterpret_cast<const char*>(table.data()), size * sizeof *table.data());
  });
  return bytes;
}

TetgenOutput outputOf(const std::string& bytes, TetgenFailure& failure) {
  const char* at = bytes.data();
  const auto take = [&](void* to, std::size_t size) {
    if (size > 0) std::memcpy(to, at, size);
    at += size;
  };
  TetgenOutput output;
  take(&failure.code, sizeof failure.code);
  forEachTable(output, failure, [&](auto& table) {
    std::size_t size = 0;
    take(&size, sizeof size);
    table.resize(size);
    take(static_cast<void*>(table.data()), size * sizeof *table.data());
  });
  return output;
}

}  // namespace

std::string TetgenFailure::text() const {
  return meaningOf(code) + (words.empty() ? "" : " (TetGen's message: " + words + ")");
}

TetgenOutput runTetgen(const TetgenInput& input, int variant, TetgenFailure& failure,
                       const std::function<bool()>& stop) {
  if (!stop) return runHere(input, variant, failure);
  const ChildOutcome outcome = inChildProcess(
      [&] {
        TetgenFailure found;
        const TetgenOutput output = runHere(input, variant, found);
        return bytesOf(output, found);
      },
      stop);
  failure = {};
  if (outcome.end == ChildOutcome::End::done) return outputOf(outcome.bytes, failure);
  failure.code = outcome.end == ChildOutcome::End::stopped ? TetgenFailure::stopped : TetgenFailure::unknown;
  return {};
}

}  // namespace packmesh
