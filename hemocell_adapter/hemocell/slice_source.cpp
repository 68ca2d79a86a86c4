// SPDX-License-Identifier: AGPL-3.0-or-later
// Position of the pre-inlet of a case, from its C++ code.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "hemocell_adapter/hemocell/case_source.h"

namespace packmesh::hemocell {
namespace {

/// A node coordinate: a number, or an offset from the last node along an axis.
struct Coordinate {
  std::int64_t offset = 0;
  std::optional<int> fromLastOf;  ///< axis of the last node it is relative to
};

/// x0, x1, y0, y1, z0, z1 of a Box3D, as far as known.
using BoxValue = std::array<std::optional<Coordinate>, 6>;

constexpr const char* members[] = {"x0", "x1", "y0", "y1", "z0", "z1"};

std::optional<int> memberNamed(const Token& token) {
  for (int m = 0; m < 6; ++m)
    if (token.is(members[m])) return m;
  return {};
}

BoxValue wholeLattice() {
  BoxValue box;
  for (int axis = 0; axis < 3; ++axis) {
    box[2 * axis] = Coordinate{0, {}};
    box[2 * axis + 1] = Coordinate{0, axis};
  }
  return box;
}

/// Interprets the statements of a file, in order, as far as they concern boxes.
class Reader {
 public:
  Reader(const std::vector<Token>& tokens, const std::string& file)
      : tokens_(tokens), file_(file), followed_(tokens.size(), false) {}

  std::vector<PreInletCall> run() {
    std::size_t first = 0;
    int depth = 0;
    for (std::size_t i = 0; i < tokens_.size(); ++i) {
      const Token& t = tokens_[i];
      if (t.kind != Token::Kind::symbol) continue;
      if (t.is("(") || t.is("[")) ++depth;
      if (t.is(")") || t.is("]")) depth = std::max(depth - 1, 0);
      const bool brace = t.is("{") || t.is("}");
      if (!brace && (depth > 0 || !t.is(";"))) continue;
      statement({first, i});
      if (brace) depth = 0;
      if (t.is("{")) {
        const bool loop = has({first, i}, {"for", "while", "do"});
        blocks_.push_back({loopsIn(blocks_.size()) + int(loop), {}, {}});
      }
      if (t.is("}")) closeBlock();
      first = i + 1;
    }
    return std::move(calls_);
  }

 private:
  struct Variable {
    BoxValue value;
    std::size_t block;  ///< number of open blocks where it is declared
  };
  struct Block {
    int loops;  ///< number of loops among the open blocks, including this one
    /// Members changed in this block: unknown after it, because it may not have been executed.
    std::set<std::pair<std::string, int>> changes;
    std::vector<std::string> declared;
  };
  /// Number of loops among the first `blocks` of the open blocks.
  int loopsIn(std::size_t blocks) const { return blocks == 0 ? 0 : blocks_[blocks - 1].loops; }

  const Token& token(std::size_t i) const { return tokens_[i]; }
  bool is(std::size_t i, TokenRange range, const char* text) const {
    return i >= range.first && i < range.second && tokens_[i].is(text);
  }

  void closeBlock() {
    if (blocks_.empty()) return;
    const Block block = std::move(blocks_.back());
    blocks_.pop_back();
    for (const std::string& name : block.declared) {
      const auto found = boxes_.find(name);
      if (found != boxes_.end() && found->second.block > blocks_.size()) boxes_.erase(found);
    }
    for (const auto& [name, member] : block.changes) forget(name, member);
  }

  void set(const std::string& name, int member, std::optional<Coordinate> value) {
    const auto found = boxes_.find(name);
    if (found == boxes_.end()) return;
    constexpr std::size_t deepest = 100;  // deeper nesting is not followed
    const bool tooDeep = blocks_.size() > deepest;
    const bool repeated = loopsIn(blocks_.size()) > loopsIn(found->second.block);
    found->second.value[member] = repeated || tooDeep ? std::nullopt : value;
    if (!blocks_.empty() && !tooDeep) blocks_.back().changes.emplace(name, member);
  }
  void forget(const std::string& name, int member) { set(name, member, {}); }

  bool has(TokenRange range, std::initializer_list<const char*> words) const {
    for (std::size_t i = range.first; i < range.second; ++i)
      for (const char* word : words)
        if (token(i).kind == Token::Kind::word && token(i).is(word)) return true;
    return false;
  }

  void statement(TokenRange range) {
    const bool conditional =
        has(range, {"if", "else", "for", "while", "do", "switch", "case", "default", "catch"});
    findCalls(range);
    if (conditional || !declaration(range))
      for (const TokenRange& part : splitAtCommas(tokens_, range)) assignment(part, conditional);
    forgetOtherUses(range);
  }

  /// `Box3D slice = ...`, `plb::Box3D slice(...)`, `auto slice = ...`.
  bool declaration(TokenRange range) {
    std::size_t i = range.first;
    while (i + 1 < range.second && (token(i).is("const") || token(i + 1).is("::")))
      i += token(i).is("const") ? 1 : 2;
    if (i + 1 >= range.second || !(token(i).is("Box3D") || token(i).is("auto"))) return false;
    const Token& name = token(i + 1);
    if (name.kind != Token::Kind::word) return false;
    std::optional<BoxValue> value;
    if (is(i + 2, range, "=")) value = boxOf({i + 3, range.second});
    if (is(i + 2, range, "(")) {
      value = cornersOf(i + 2, range);
      if (!value) value = boxOf({i + 3, range.second - 1});
    }
    boxes_[name.text] = {value.value_or(BoxValue{}), blocks_.size()};
    if (!blocks_.empty()) blocks_.back().declared.push_back(name.text);
    follow(range.first, value ? range.second : i + 2);
    return true;
  }

  /// Box3D(x0, x1, y0, y1, z0, z1), from its opening bracket on.
  std::optional<BoxValue> cornersOf(std::size_t open, TokenRange range) const {
    const std::size_t close = tokens_[open].closing;
    if (close + 1 != range.second) return {};
    const std::vector<TokenRange> parts = splitAtCommas(tokens_, {open + 1, close});
    if (parts.size() != 6) return {};
    BoxValue box;
    for (int m = 0; m < 6; ++m) box[m] = coordinateOf(parts[m]);
    return box;
  }

  std::optional<BoxValue> boxOf(TokenRange range) const {
    std::size_t i = range.first;
    while (i + 1 < range.second && token(i + 1).is("::")) i += 2;
    if (i >= range.second) return {};
    if (token(i).is("Box3D") && is(i + 1, range, "(")) return cornersOf(i + 1, range);
    if (range.second - i == 1) {
      const auto found = boxes_.find(token(i).text);
      if (found != boxes_.end()) return found->second.value;
      return {};
    }
    // flagMatrix->getBoundingBox(), hemocell.lattice->getBoundingBox(), (*lattice).getBoundingBox()
    if (range.second - i < 4 || !is(range.second - 3, range, "getBoundingBox") ||
        !is(range.second - 2, range, "(") || !is(range.second - 1, range, ")"))
      return {};
    for (; i < range.second - 3; ++i)
      if (token(i).kind != Token::Kind::word && !token(i).is(".") && !token(i).is("->") &&
          !token(i).is("(") && !token(i).is(")") && !token(i).is("*"))
        return {};
    return wholeLattice();
  }

  /// A sum of integer literals and members of boxes, at most one of which is relative to the last node.
  std::optional<Coordinate> coordinateOf(TokenRange range) const {
    Coordinate sum;
    std::size_t i = range.first;
    for (bool first = true; i < range.second; first = false) {
      std::int64_t sign = 1;
      if (token(i).is("+") || token(i).is("-")) {
        sign = token(i).is("-") ? -1 : 1;
        ++i;
      } else if (!first) {
        return {};
      }
      std::size_t end = i;
      int depth = 0;
      for (; end < range.second; ++end) {
        if (token(end).is("(")) ++depth;
        if (token(end).is(")")) --depth;
        if (depth == 0 && end > i && (token(end).is("+") || token(end).is("-"))) break;
      }
      const auto term = termOf({i, end});
      if (!term || (term->fromLastOf && (sign < 0 || sum.fromLastOf))) return {};
      sum.offset += sign * term->offset;
      if (term->fromLastOf) sum.fromLastOf = term->fromLastOf;
      i = end;
    }
    if (range.first == range.second) return {};
    return sum;
  }

  std::optional<Coordinate> termOf(TokenRange range) const {
    if (const auto number = literalNumber(tokens_, range)) {
      constexpr double most = 1e6;
      if (*number != std::floor(*number) || std::abs(*number) > most) return {};
      return Coordinate{static_cast<std::int64_t>(*number), {}};
    }
    if (range.second - range.first < 3 || !token(range.second - 2).is(".")) return {};
    const auto member = memberNamed(token(range.second - 1));
    if (!member) return {};
    const auto box = boxOf({range.first, range.second - 2});
    return box ? (*box)[*member] : std::nullopt;
  }

  struct Target {
    std::string name;
    std::optional<int> member;  ///< empty: the whole box
    std::size_t after = 0;      ///< index of the token after it
  };

  std::optional<Target> targetAt(std::size_t i, TokenRange range) const {
    if (!isBox(i, range)) return {};
    if (!is(i + 1, range, ".")) return Target{token(i).text, {}, i + 1};
    if (i + 2 >= range.second) return {};
    const auto member = memberNamed(token(i + 2));
    if (!member) return {};
    return Target{token(i).text, member, i + 3};
  }

  /// True if the token at `i` is a variable that holds a box.
  bool isBox(std::size_t i, TokenRange range) const {
    if (i >= range.second || token(i).kind != Token::Kind::word) return false;
    if (i > 0 && (token(i - 1).is(".") || token(i - 1).is("->") || token(i - 1).is("::"))) return false;
    return boxes_.count(token(i).text) > 0;
  }

  /// `slice.x0 = slice.x1 = slice.x1 - 5`, `slice.x0 += 2`, `slice = other`.
  void assignment(TokenRange range, bool conditional) {
    std::vector<Target> targets;
    std::size_t i = range.first;
    int sign = 0;  // sign of += and -=
    while (const auto target = targetAt(i, range)) {
      const std::size_t at = target->after;
      sign = is(at, range, "+=") ? 1 : is(at, range, "-=") ? -1 : 0;
      if (sign == 0 && !is(at, range, "=")) break;
      targets.push_back(*target);
      i = at + 1;
      if (sign != 0) break;
    }
    if (targets.empty()) return;
    const std::optional<Coordinate> value = coordinateOf({i, range.second});
    const std::optional<BoxValue> box = boxOf({i, range.second});
    follow(range.first, value || box ? range.second : i);
    for (const Target& target : targets)
      for (int m = 0; m < 6; ++m) {
        if (target.member && *target.member != m) continue;
        std::optional<Coordinate> next = target.member ? value : box ? (*box)[m] : std::nullopt;
        if (sign != 0) {
          const std::optional<Coordinate> before = boxes_[target.name].value[m];
          const bool known = target.member && before && value && !value->fromLastOf;
          if (known)
            next = Coordinate{before->offset + sign * value->offset, before->fromLastOf};
          else
            next.reset();
        }
        set(target.name, m, conditional ? std::nullopt : next);
      }
  }

  /// Boxes that could be changed in a way that is not followed become unknown: as an argument, by address,
  /// ++.
  void forgetOtherUses(TokenRange range) {
    for (std::size_t i = range.first; i < range.second; ++i) {
      if (!isBox(i, range) || followed_[i]) continue;
      const std::string& name = token(i).text;
      const bool reads = is(i + 1, range, ".") && i + 2 < range.second;
      const auto member = reads ? memberNamed(token(i + 2)) : std::nullopt;
      bool changed = false;
      if (i > 0)
        for (const char* before : {"&", "++", "--", ">>"}) changed = changed || token(i - 1).is(before);
      for (const char* after : {"=", "+=", "-=", "*=", "/=", "%=", "&=", "|=", "^=", "++", "--"})
        changed = changed || is(i + 3, range, after);
      if (member && !changed) continue;
      if (reads && !member && token(i + 2).text.compare(0, 3, "get") == 0) continue;
      for (int m = 0; m < 6; ++m)
        if (!member || *member == m) forget(name, m);
    }
  }

  void follow(std::size_t first, std::size_t last) {
    std::fill(followed_.begin() + std::ptrdiff_t(first), followed_.begin() + std::ptrdiff_t(last), true);
  }

  void findCalls(TokenRange range) {
    for (std::size_t i = range.first; i + 1 < range.second; ++i) {
      if (token(i).kind != Token::Kind::word || !token(i + 1).is("(") || !isCall(tokens_, i)) continue;
      const bool automatic = token(i).is("autoPreinletFromBoundary");
      if (!automatic && !token(i).is("preInletFromSlice")) continue;
      const std::size_t close = tokens_[i + 1].closing;
      if (close == tokens_.size() || followed_[i]) continue;
      follow(i, close);
      const std::vector<TokenRange> arguments = splitAtCommas(tokens_, {i + 2, close});
      if (arguments.size() != (automatic ? 1 : 2)) continue;
      PreInletCall call;
      call.where = fmt::format("{}:{}", file_, token(i).line);
      call.text = sourceText(tokens_, {i, close + 1});
      call.direction = directionOf(arguments[0]);
      if (call.direction && automatic) {
        const bool positive = (*call.direction)[1] == 'p';
        call.slice = positive ? -2 : 1;  // the second-to-last plane, or the second
      } else if (call.direction) {
        place(call, boxOf(arguments[1]));
      }
      calls_.push_back(std::move(call));
    }
  }

  /// `Direction::Xpos`.
  std::optional<std::string> directionOf(TokenRange range) const {
    std::size_t i = range.first;
    while (i + 1 < range.second && token(i + 1).is("::")) i += 2;
    if (range.second - i != 1) return {};
    for (const char* name : {"Xneg", "Xpos", "Yneg", "Ypos", "Zneg", "Zpos"})
      if (token(i).is(name)) return name;
    return {};
  }

  /// Sets slice and ranges if the whole box is known and flat.
  static void place(PreInletCall& call, const std::optional<BoxValue>& box) {
    if (!box) return;
    const int axis = (*call.direction)[0] - 'X';
    std::array<NodePlane, 6> planes{};
    for (int m = 0; m < 6; ++m) {
      const std::optional<Coordinate>& c = (*box)[m];
      if (!c || (c->fromLastOf && (*c->fromLastOf != m / 2 || c->offset > 0)) ||
          (!c->fromLastOf && c->offset < 0))
        return;
      planes[m] = c->fromLastOf ? c->offset - 1 : c->offset;
    }
    if (planes[2 * axis] != planes[2 * axis + 1]) return;
    call.slice = planes[2 * axis];
    for (int k = 0; k < 3; ++k)
      if (k != axis && (planes[2 * k] != 0 || planes[2 * k + 1] != -1))
        call.ranges.push_back({k, planes[2 * k], planes[2 * k + 1]});
  }

  const std::vector<Token>& tokens_;
  const std::string& file_;
  std::map<std::string, Variable> boxes_;
  std::vector<Block> blocks_;
  std::vector<bool> followed_;  ///< tokens whose effects on boxes are followed
  std::vector<PreInletCall> calls_;
};

}  // namespace

std::vector<PreInletCall> preInletCalls(const std::vector<Token>& tokens, const std::string& file) {
  return Reader(tokens, file).run();
}

}  // namespace packmesh::hemocell
