// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/chordal_split.h"

#include <cmath>
#include <utility>

namespace packmesh {
namespace {

/// Which corners have equal labels: one bit for each pair of corners.
int equalities(int a, int b, int c, int d) {
  return (a == b) | (a == c) << 1 | (a == d) << 2 | (b == c) << 3 | (b == d) << 4 | (c == d) << 5;
}

ChordalPattern patternOf(const std::array<int, 4>& label) {
  // Corners sorted by the frequency of their label, those with the same label together.
  ChordalPattern pattern;
  std::array<int, 4> count{}, firstWith{};
  for (int k = 0; k < 4; ++k)
    for (int j = 3; j >= 0; --j)
      if (label[j] == label[k]) {
        ++count[k];
        firstWith[k] = j;
      }
  int placed = 0;
  for (int wanted = 4; wanted >= 1; --wanted)
    for (int first = 0; first < 4; ++first)
      for (int k = first; k < 4; ++k)
        if (count[k] == wanted && firstWith[k] == first)
          pattern.order[placed++] = static_cast<std::uint8_t>(k);
  const int largest = count[pattern.order[0]];
  pattern.kind = largest == 4                   ? ChordalCase::none
                 : largest == 3                 ? ChordalCase::threeOne
                 : largest == 1                 ? ChordalCase::allDifferent
                 : count[pattern.order[2]] == 2 ? ChordalCase::twoTwo
                                                : ChordalCase::twoOneOne;
  return pattern;
}

/// Indexed by equalities(); combinations that cannot occur stay empty.
using PatternTable = std::array<ChordalPattern, 64>;

PatternTable makeTable() {
  PatternTable table;
  std::array<int, 4> label;
  for (int code = 0; code < 256; ++code) {
    for (int k = 0; k < 4; ++k) label[k] = code >> 2 * k & 3;
    table[equalities(label[0], label[1], label[2], label[3])] = patternOf(label);
  }
  return table;
}

const PatternTable patterns = makeTable();

/// Splits one tetrahedron after the other.
class Splitter {
 public:
  /// @param out of sufficient size
  Splitter(const Tetrahedra& tetrahedra, WallFaces wall, ChordalFaces& out)
      : points_(tetrahedra.points.data()),
        labels_(tetrahedra.labels.data()),
        atWall_(wall == WallFaces::atWall),
        face_(out.faces.data()) {}

  void split(int index, const Tetrahedron& t, const ChordalPattern& pattern) {
    tetrahedron_ = index;
    order_ = pattern.order.data();
    for (int k = 0; k < 4; ++k) corner_[k] = t[order_[k]];
    withCase(pattern.kind, [this](auto kind) {
      addAll<kind.value>(std::make_index_sequence<chordalCuts<kind.value>.size()>());
    });
  }

 private:
  const Vec3& at(int k) const { return points_[corner_[k]]; }

  template <int mask>
  std::uint8_t bits() const {
    int bits = 0;
    for (int k = 0; k < 4; ++k)
      if (mask >> k & 1) bits |= 1 << order_[k];
    return static_cast<std::uint8_t>(bits);
  }

  template <ChordalCase kind, std::size_t... cuts>
  void addAll(std::index_sequence<cuts...>) {
    (add<kind, cuts>(), ...);
  }

  /// A face, or two in a plane; it cuts the edges between the corners on both sides in half.
  template <ChordalCase kind, std::size_t number>
  void add() {
    constexpr ChordalCut cut = chordalCuts<kind>[number];
    constexpr int i = lowestCorner(cut.first), j = lowestCorner(cut.second);
    const Vec3 normal = cut.normal(at(0), at(1), at(2), at(3)), edge = at(j) - at(i);
    const double length = normal.norm(), along = normal.dot(edge);
    face_->normal = normal / (along < 0.0 ? -length : length);
    if (!(length > 0.0)) face_->normal = edge.normalized();  // flat up to rounding
    const bool toWall = atWall_ && labels_[corner_[j]] == wallLabel;
    const bool fromWall = atWall_ && labels_[corner_[i]] == wallLabel;
    face_->away = length > 0.0 && !toWall && !fromWall ? 0.5 * std::abs(along) / length : 0.0;
    face_->point = toWall ? at(j) : fromWall ? at(i) : Vec3(0.5 * (at(i) + at(j)));
    finish<cut.first, cut.second>();
    if constexpr (cut.twice) {
      face_->normal = face_[-1].normal;
      face_->away = face_[-1].away;
      face_->point = face_[-1].point;
      finish<cut.first, cut.second>();
    }
  }

  template <int first, int second>
  void finish() {
    face_->tetrahedron = tetrahedron_;
    face_->first = bits<first>();
    face_->second = bits<second>();
    ++face_;
  }

  const Vec3* points_;
  const int* labels_;
  bool atWall_;
  ChordalFace* face_;
  int tetrahedron_ = 0;
  int corner_[4];
  const std::uint8_t* order_ = nullptr;
};

}  // namespace

const ChordalPattern& chordalPattern(int a, int b, int c, int d) {
  return patterns[equalities(a, b, c, d)];
}

void splitChordally(const Tetrahedra& tetrahedra, WallFaces wall, ChordalFaces& out) {
  const std::vector<int>& labels = tetrahedra.labels;
  const auto patternAt = [&](const Tetrahedron& t) -> const ChordalPattern& {
    return patterns[equalities(labels[t[0]], labels[t[1]], labels[t[2]], labels[t[3]])];
  };
  // Count first, so that memory is allocated once.
  out.tetrahedra.fill(0);
  for (const Tetrahedron& t : tetrahedra.tetrahedra) {
    const ChordalCase kind = patternAt(t).kind;
    if (kind != ChordalCase::none) ++out.tetrahedra[static_cast<int>(kind)];
  }
  std::int64_t count = 0;
  for (int kind = 0; kind < 5; ++kind) count += out.tetrahedra[kind] * chordalFaceCount[kind];
  out.faces.resize(count);

  Splitter splitter(tetrahedra, wall, out);
  for (std::size_t i = 0; i < tetrahedra.tetrahedra.size(); ++i) {
    const Tetrahedron& t = tetrahedra.tetrahedra[i];
    const ChordalPattern& pattern = patternAt(t);
    if (pattern.kind != ChordalCase::none) splitter.split(static_cast<int>(i), t, pattern);
  }
}

}  // namespace packmesh
