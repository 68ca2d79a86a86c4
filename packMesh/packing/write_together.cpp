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
  auto files = std::make_unique<AtomicFiles>();
  writeTogether(ranks, [&] {
    if (ranks.rank() == 0) files->begin(file);
  });
  writeTogether(ranks, [&] {
    Hdf5Writer out(*files, ranks, userBlock);
    content(out);
    out.close();
  });
  return files;
}

void commitTogether(std::unique_ptr<AtomicFiles> files, const Communicator& ranks) {
  writeTogether(ranks, [&] {
    if (ranks.rank() != 0) return;
    files->end();
    files->commit();
  });
}

}  // namespace packmesh
