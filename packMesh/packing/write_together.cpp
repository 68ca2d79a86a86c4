// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/packing/write_together.h"

#include <string>

#include "packMesh/core/error.h"
#include "packMesh/io/hdf5_writer.h"

namespace packmesh {

void writeTogether(const Communicator& ranks, const std::function<void()>& work) {
  std::string error;
  try {
    work();
  } catch (const OutputError& failure) {
    error = failure.what();
  }
  const auto failed = ranks.min(std::int64_t(error.empty() ? ranks.size() : ranks.rank()));
  if (failed < ranks.size()) throw OutputError(ranks.broadcast(error, static_cast<int>(failed)));
}

std::unique_ptr<AtomicFiles> writtenHdf5(const std::filesystem::path& file, const Communicator& ranks,
                                         std::uint64_t userBlock,
                                         const std::function<void(Hdf5Writer&)>& content) {
  const bool first = ranks.rank() == 0;
  auto files = std::make_unique<AtomicFiles>();
  writeTogether(ranks, [&] {
    if (first) files->begin(file);
  });
  writeTogether(ranks, [&] {
    Hdf5Writer out(first ? files->temporary() : std::filesystem::path(), file, ranks, userBlock);
    content(out);
    const std::int64_t size = out.close();
    if (first) files->skipTo(size);
  });
  return files;
}

}  // namespace packmesh
