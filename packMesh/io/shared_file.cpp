// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/shared_file.h"

#include <algorithm>

#include "packMesh/core/error.h"

namespace packmesh {

/// Does nothing after an error.
template <class Step>
void SharedFile::attempt(const Step& step) {
  if (!error_.empty()) return;
  try {
    step();
  } catch (const OutputError& error) {
    error_ = error.what();
  }
}

SharedFile::SharedFile(const std::filesystem::path& file, const std::filesystem::path& target,
                       const Communicator& ranks)
    : ranks_(ranks) {
  const bool first = ranks.rank() == 0;
  const std::string name = ranks.broadcast(first ? std::filesystem::absolute(file).string() : "", 0);
  const std::string final = ranks.broadcast(target.string(), 0);
  attempt([&] { file_.emplace(name, final); });
  found_ = !ranks.any(!file_);
  if (found_ || first) return;
  file_.reset();
  error_.clear();  // the first rank writes for this one
}

std::int64_t SharedFile::write(std::int64_t position, const std::vector<std::string_view>& own) {
  std::int64_t length = 0;
  for (const std::string_view piece : own) length += static_cast<std::int64_t>(piece.size());
  std::vector<std::int64_t> positions;
  for (const std::int64_t ofRank : ranks_.gatherAll(std::vector<std::int64_t>{length})) {
    positions.push_back(position);
    position += ofRank;
  }
  if (!found_) {
    gather(positions, own);
    return position;
  }
  std::int64_t at = positions[ranks_.rank()];
  attempt([&] {
    for (const std::string_view piece : own) {
      file_->write(at, piece);
      at += static_cast<std::int64_t>(piece.size());
    }
  });
  return position;
}

void SharedFile::writeOfFirst(std::int64_t position, std::string_view text) {
  if (ranks_.rank() == 0) attempt([&] { file_->write(position, text); });
}

/// The first rank writes all parts, piece by piece: a message between ranks has a largest length.
void SharedFile::gather(const std::vector<std::int64_t>& positions,
                        const std::vector<std::string_view>& own) {
  constexpr std::size_t longest = std::size_t{1} << 24;
  std::vector<std::string_view> pieces;
  for (const std::string_view piece : own)
    for (std::size_t at = 0; at < piece.size(); at += longest) pieces.push_back(piece.substr(at, longest));
  std::vector<std::int64_t> ends = positions;
  const auto rounds = static_cast<std::size_t>(-ranks_.min(-static_cast<std::int64_t>(pieces.size())));
  for (std::size_t round = 0; round < rounds; ++round) {
    const std::string_view piece = round < pieces.size() ? pieces[round] : std::string_view();
    int rank = 0;
    ranks_.visitInOrder(std::vector<char>(piece.begin(), piece.end()), [&](const std::vector<char>& part) {
      attempt([&] { file_->write(ends[rank], {part.data(), part.size()}); });
      ends[rank++] += static_cast<std::int64_t>(part.size());
    });
  }
}

void SharedFile::close() {
  if (!file_) return;
  attempt([&] {
    file_->verify();
    file_->close();
  });
  file_.reset();
}

void SharedFile::requireGood() const {
  if (!error_.empty()) throw OutputError(error_);
}

}  // namespace packmesh
