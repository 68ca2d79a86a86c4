// SPDX-License-Identifier: AGPL-3.0-or-later
#include "hemocell_adapter/output/shared_files.h"

#include <fmt/format.h>

#include <exception>
#include <utility>

#include "hemocell_adapter/base/exit_codes.h"
#include "hemocell_adapter/base/ranks.h"

namespace packmesh::hemocell {

void SharedFiles::makeFolder(const std::filesystem::path& folder) {
  onFirstRank(ranks_, [&] {
    std::error_code error;
    if (!folder.empty()) std::filesystem::create_directories(folder, error);
    if (error)
      throw OutputError(
          fmt::format("{}: the folder cannot be created: {}", folder.string(), error.message()));
  });
}

void SharedFiles::begin(const std::filesystem::path& target) {
  onFirstRank(ranks_, [&] { files_.begin(target); });
  size_ = 0;
  if (ranks_.alone()) return;
  const bool first = ranks_.rank() == 0;
  const std::string file =
      ranks_.broadcast(first ? std::filesystem::absolute(files_.temporary()).string() : "", 0);
  const std::string name = ranks_.broadcast(first ? files_.target().string() : "", 0);
  try {
    if (!first) own_.emplace(file, name);
    found_ = true;
  } catch (const OutputError&) {
    found_ = false;
  }
  found_ = !ranks_.any(!found_);
  if (!found_) own_.reset();
}

void SharedFiles::append(const std::function<std::string()>& text) {
  std::vector<std::string> own;
  onFirstRank(ranks_, [&] {
    if (ranks_.rank() == 0) own.push_back(text());
  });
  appendParts(own);
}

void SharedFiles::appendParts(std::string own) {
  appendParts(std::vector<std::string>{std::move(own)});
}

void SharedFiles::gather(const std::vector<std::string>& own) {
  std::string all;
  for (const std::string& text : own) all += text;
  std::exception_ptr error;
  ranks_.visitInOrder(std::vector<char>(all.begin(), all.end()), [&](const std::vector<char>& part) {
    try {
      if (!error) files_.append({part.data(), part.size()});
    } catch (...) {
      error = std::current_exception();
    }
  });
  onFirstRank(ranks_, [&] {
    if (error) std::rethrow_exception(error);
  });
}

void SharedFiles::appendParts(const std::vector<std::string>& own) {
  if (!found_) return gather(own);
  std::int64_t length = 0;
  for (const std::string& text : own) length += static_cast<std::int64_t>(text.size());
  std::int64_t position = size_ + ranks_.sumBefore({length}).front();
  size_ += ranks_.sum(length);
  together(ranks_, [&] {
    for (const std::string& text : own) {
      if (own_) {
        own_->write(position, text);
      } else {
        files_.append(text);
      }
      position += static_cast<std::int64_t>(text.size());
    }
    if (!own_) files_.skipTo(size_);
  });
}

void SharedFiles::end() {
  together(ranks_, [&] {
    if (!own_) return;
    own_->verify();
    own_->close();
  });
  own_.reset();
  onFirstRank(ranks_, [&] { files_.end(); });
}

void SharedFiles::commit() {
  onFirstRank(ranks_, [&] { files_.commit(); });
}

}  // namespace packmesh::hemocell
