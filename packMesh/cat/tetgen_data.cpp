// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/cat/tetgen_run.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace packmesh {
namespace {

/// To be increased whenever messages change.
constexpr std::uint32_t formatVersion = 1;

struct Head {
  char mark[8];
  std::uint32_t version;
  std::uint64_t length;  ///< of what follows [bytes]
};

constexpr char markOfInput[8] = {'P', 'M', 'S', 'U', 'R', 'F', 'A', 'C'};
constexpr char markOfAnswer[8] = {'P', 'M', 'T', 'E', 'T', 'R', 'A', 'H'};

// The members of a message, in their order, visited by its writer and its reader.
template <class Input, class Visit>
void visitInput(Input& input, Visit&& visit) {
  visit(input.points);
  visit(input.triangles);
  visit(input.triangleLabels);
  visit(input.keepHull);
  visit(input.regions);
  visit(input.subfaces);
  visit(input.crossings);
  visit(input.variant);
}
template <class Answer, class Visit>
void visitAnswer(Answer& answer, Visit&& visit) {
  visit(answer.output.points);
  visit(answer.output.steinerLabels);
  visit(answer.output.tetrahedra);
  visit(answer.output.regions);
  visit(answer.output.subfaces);
  visit(answer.output.subfaceLabels);
  visit(answer.code);
}

class Writer {
 public:
  template <class T>
  void operator()(const std::vector<T>& items) {
    (*this)(static_cast<std::uint64_t>(items.size()));
    add(items.data(), items.size() * sizeof(T));
  }
  template <class T>
  void operator()(const T& value) {
    static_assert(std::is_arithmetic_v<T>);
    add(&value, sizeof value);
  }
  std::string message(const char (&mark)[8]) const {
    Head head = {};
    std::memcpy(head.mark, mark, sizeof mark);
    head.version = formatVersion;
    head.length = bytes_.size();
    return std::string(reinterpret_cast<const char*>(&head), sizeof head) + bytes_;
  }

 private:
  void add(const void* from, std::size_t size) {
    if (size > 0) bytes_.append(static_cast<const char*>(from), size);
  }
  std::string bytes_;
};

class Reader {
 public:
  Reader(const std::string& message, const char (&mark)[8]) {
    Head head;
    if (message.size() < sizeof head) return;
    std::memcpy(&head, message.data(), sizeof head);
    good_ = std::memcmp(head.mark, mark, sizeof mark) == 0 && head.version == formatVersion &&
            head.length == message.size() - sizeof head;
    at_ = message.data() + sizeof head;
    left_ = message.size() - sizeof head;
  }
  template <class T>
  void operator()(std::vector<T>& items) {
    std::uint64_t count = 0;
    (*this)(count);
    if (!good_ || count > left_ / sizeof(T)) return void(good_ = false);
    items.resize(count);
    take(items.data(), count * sizeof(T));
  }
  template <class T>
  void operator()(T& value) {
    static_assert(std::is_arithmetic_v<T>);
    if constexpr (std::is_same_v<T, bool>) {
      char byte = 0;
      take(&byte, 1);
      value = byte != 0;
    } else {
      take(&value, sizeof value);
    }
  }
  /// Whether all has been read, and nothing else was there.
  bool complete() const { return good_ && left_ == 0; }

 private:
  void take(void* to, std::size_t size) {
    good_ = good_ && size <= left_;
    if (!good_ || size == 0) return;
    std::memcpy(to, at_, size);
    at_ += size;
    left_ -= size;
  }
  bool good_ = false;
  const char* at_ = nullptr;
  std::size_t left_ = 0;
};

/// Whether all corners are numbers of points.
template <class Element>
bool within(const std::vector<Element>& elements, std::size_t points) {
  return std::all_of(elements.begin(), elements.end(), [&](const Element& element) {
    return std::all_of(element.begin(), element.end(),
                       [&](int p) { return p >= 0 && static_cast<std::size_t>(p) < points; });
  });
}

std::string meaningOf(int code) {
  switch (code) {
    case TetgenFailure::outOfMemory:
      return "it ran out of memory";
    case TetgenFailure::intersection:
      return "it found surfaces that intersect";
    case TetgenFailure::tooSmall:
      return "it found edges or angles too small for it";
    case TetgenFailure::tooClose:
      return "it found surfaces too close to each other";
    case TetgenFailure::badInput:
      return "it rejected its input";
    case TetgenFailure::stopped:
      return "it was stopped";
    case TetgenFailure::noAnswer:
      return "its program has not answered";
    default:
      return "internal error of TetGen";
  }
}

}  // namespace

std::string TetgenFailure::text() const {
  return meaningOf(code) + (words.empty() ? "" : " (" + words + ")");
}

std::string messageOf(const TetgenInput& input) {
  Writer writer;
  visitInput(input, writer);
  return writer.message(markOfInput);
}

std::string messageOf(const TetgenAnswer& answer) {
  Writer writer;
  visitAnswer(answer, writer);
  return writer.message(markOfAnswer);
}

std::optional<TetgenInput> tetgenInputOf(const std::string& message) {
  Reader reader(message, markOfInput);
  TetgenInput input;
  visitInput(input, reader);
  const bool good = reader.complete() && within(input.triangles, input.points.size()) &&
                    input.triangleLabels.size() == input.triangles.size() && input.variant >= 0 &&
                    input.variant < tetgenVariants;
  if (!good) return {};
  return input;
}

std::optional<TetgenAnswer> tetgenAnswerOf(const std::string& message) {
  Reader reader(message, markOfAnswer);
  TetgenAnswer answer;
  visitAnswer(answer, reader);
  const TetgenOutput& output = answer.output;
  const std::size_t points = output.points.size();
  const bool good = reader.complete() && within(output.tetrahedra, points) &&
                    within(output.subfaces, points) && output.steinerLabels.size() <= points &&
                    (output.regions.empty() || output.regions.size() == output.tetrahedra.size()) &&
                    output.subfaceLabels.size() == output.subfaces.size();
  if (!good) return {};
  return answer;
}

std::string tetgenProgramVersion() {
  return "packmesh-tetgen, messages of version " + std::to_string(formatVersion);
}

}  // namespace packmesh
