// SPDX-License-Identifier: AGPL-3.0-or-later
#include "packMesh/io/hdf5_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <system_error>

#include "packMesh/core/error.h"
#include "packMesh/core/input_file.h"

namespace packmesh {

QuietHdf5::QuietHdf5() {
  H5dont_atexit();  // files are closed by then; for damaged files it would print errors
  H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}
QuietHdf5::~QuietHdf5() {
  H5Eset_auto2(H5E_DEFAULT, function_, data_);
}

namespace {

/// Opening a pipe could block forever.
bool isRegular(const std::filesystem::path& file) {
  std::error_code ignored;
  return std::filesystem::is_regular_file(file, ignored);
}

}  // namespace

Hdf5Reader::Hdf5Reader(const std::filesystem::path& file)
    : name_(file.string()),
      file_(isRegular(file) ? H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT) : H5I_INVALID_HID,
            H5Fclose) {
  if (file_.good()) return;
  const bool isHdf5 = isRegular(file) && H5Fis_hdf5(file.c_str()) > 0;
  fail(!isThere(file) ? "no such file"
       : isHdf5       ? "is truncated, damaged, or being written by another program"
                      : "is not an HDF5 file or cannot be read");
}

void Hdf5Reader::fail(const std::string& what) const {
  throw InputError(name_ + ": " + what);
}

void Hdf5Reader::readAttribute(const std::string& path, const char* name, H5T_class_t kind, hid_t type,
                               void* to) const {
  const Hdf5Handle attribute(H5Aopen_by_name(file_, path.c_str(), name, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!attribute.good()) fail("has no attribute '" + std::string(name) + "' of '" + path + "'");
  const Hdf5Handle found(H5Aget_type(attribute), H5Tclose), space(H5Aget_space(attribute), H5Sclose);
  if (H5Tget_class(found) != kind || H5Sget_simple_extent_npoints(space) != 1 ||
      H5Aread(attribute, type, to) < 0)
    fail("attribute '" + std::string(name) + "' of '" + path + "' has an unexpected type");
}

std::string Hdf5Reader::text(const std::string& path, const char* name) const {
  const Hdf5Handle attribute(H5Aopen_by_name(file_, path.c_str(), name, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  if (!attribute.good()) fail("has no attribute '" + std::string(name) + "' of '" + path + "'");
  const Hdf5Handle type(H5Aget_type(attribute), H5Tclose);
  const bool fixed = H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0;
  constexpr std::size_t longest = 1 << 20;
  std::string text(fixed ? std::min(H5Tget_size(type), longest) : 0, '\0');
  if (!fixed || H5Tget_size(type) > longest || H5Aread(attribute, type, text.data()) < 0)
    fail("attribute '" + std::string(name) + "' of '" + path + "' is not text");
  return text.c_str();
}
std::int64_t Hdf5Reader::integer(const std::string& path, const char* name) const {
  std::int64_t value = 0;
  readAttribute(path, name, H5T_INTEGER, H5T_NATIVE_INT64, &value);
  return value;
}
double Hdf5Reader::real(const std::string& path, const char* name) const {
  double value = 0.0;
  readAttribute(path, name, H5T_FLOAT, H5T_NATIVE_DOUBLE, &value);
  return value;
}

bool Hdf5Reader::has(const std::string& path) const {
  return H5Lexists(file_, path.c_str(), H5P_DEFAULT) > 0;
}

std::array<std::int64_t, 2> Hdf5Reader::size(const std::string& path) const {
  const Hdf5Handle set(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose);
  if (!set.good()) fail("has no table '" + path + "'");
  const Hdf5Handle space(H5Dget_space(set), H5Sclose), type(H5Dget_type(set), H5Tclose);
  const int rank = H5Sget_simple_extent_ndims(space);
  const H5T_class_t kind = H5Tget_class(type);
  hsize_t size[3] = {0, 1, 1};
  if (rank < 1 || rank > 3 || (kind != H5T_INTEGER && kind != H5T_FLOAT) ||
      H5Sget_simple_extent_dims(space, size, nullptr) < 0)
    fail("'" + path + "' is not a numeric table");
  const hsize_t most = std::filesystem::file_size(name_);  // damaged files can state any size
  for (const hsize_t one : size)
    if (one > most) size[0] = most + 1;
  if (size[0] > most || size[1] * size[2] > most || size[0] * size[1] * size[2] > most)
    fail("is damaged: table '" + path + "' is larger than the file");
  return {static_cast<std::int64_t>(size[0]), static_cast<std::int64_t>(size[1] * size[2])};
}

void Hdf5Reader::requireRows(const std::string& path, int columns, std::int64_t first,
                             std::int64_t count) const {
  const auto found = size(path);
  if (found[1] != columns || first < 0 || count < 0 || first > found[0] || count > found[0] - first)
    fail("table '" + path + "' has " + std::to_string(found[0]) + " x " + std::to_string(found[1]) +
         " numbers; expected " + std::to_string(first + count) + " x " + std::to_string(columns));
}

void Hdf5Reader::readTable(const std::string& path, int columns, std::int64_t first, std::int64_t count,
                           hid_t type, void* to) const {
  if (count == 0) return;
  const Hdf5Handle set(H5Dopen2(file_, path.c_str(), H5P_DEFAULT), H5Dclose);
  const Hdf5Handle space(H5Dget_space(set), H5Sclose), memory(rowsSpace(count, columns), H5Sclose);
  if (!selectRows(space, first, count) || H5Dread(set, type, memory, space, H5P_DEFAULT, to) < 0)
    fail("table '" + path + "' cannot be read: the file is damaged");
}

namespace {

// Tables are written as they are in memory.
static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__);

/// More than names and attributes take [bytes].
constexpr std::int64_t spare = std::int64_t{1} << 20;

/// Largest size of files for this process [bytes]; files in memory count.
std::int64_t largestFile() {
  rlimit limit;
  constexpr auto most = std::numeric_limits<std::int64_t>::max();
  if (::getrlimit(RLIMIT_FSIZE, &limit) != 0 || limit.rlim_cur >= static_cast<rlim_t>(most)) return most;
  return static_cast<std::int64_t>(limit.rlim_cur);
}

const char* const tooLarge = "is larger than the limit for files (ulimit -f)";

/// Lets HDF5 create `file`, and then gives it the file in memory instead: it cannot open one without a name.
hid_t createFile(const std::filesystem::path& file, int memory, std::uint64_t userBlock) {
  const Hdf5Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose),
      access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_obj_track_times(creation, false);
  if (H5Pset_userblock(creation, userBlock) < 0 || H5Pset_fapl_sec2(access) < 0) return H5I_INVALID_HID;
  Hdf5Handle created(H5Fcreate(file.c_str(), H5F_ACC_TRUNC, creation, access), H5Fclose);
  void* descriptor = nullptr;
  const bool moved = created.good() && H5Fget_vfd_handle(created, access, &descriptor) >= 0 &&
                     ::dup2(memory, *static_cast<int*>(descriptor)) >= 0;
  return moved ? created.release() : H5I_INVALID_HID;
}

}  // namespace

Hdf5Writer::Hdf5Writer(AtomicFiles& file, const Communicator& ranks, std::uint64_t userBlock)
    : ranks_(ranks),
      disk_(file),
      first_(ranks.rank() == 0),
      memory_(first_ ? ::memfd_create("packMesh HDF5", MFD_CLOEXEC) : -1),
      file_(memory_ >= 0 && largestFile() > spare ? createFile(file.temporary(), memory_, userBlock)
                                                  : H5I_INVALID_HID,
            H5Fclose) {
  if (first_) require(largestFile() > spare, tooLarge);
  if (first_) require(file_.good(), std::string("cannot be created: ") + std::strerror(errno));
}

Hdf5Writer::~Hdf5Writer() {
  file_.close();
  if (memory_ >= 0) ::close(memory_);
}

void Hdf5Writer::require(bool good, const std::string& otherwise) {
  if (first_ && !good && error_.empty()) error_ = disk_.target().string() + ": " + otherwise;
}

void Hdf5Writer::group(const std::string& path) {
  if (!writing()) return;
  const Hdf5Handle creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation, false);
  const Hdf5Handle group(H5Gcreate2(file_, path.c_str(), H5P_DEFAULT, creation, H5P_DEFAULT), H5Gclose);
  require(group.good());
}

void Hdf5Writer::attribute(const std::string& path, const char* name, const std::string& text) {
  const Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  require(H5Tset_size(type, text.size() + 1) >= 0 && H5Tset_cset(type, H5T_CSET_UTF8) >= 0);
  writeAttribute(path, name, type, type, text.c_str());
}
void Hdf5Writer::attribute(const std::string& path, const char* name, std::int64_t value) {
  writeAttribute(path, name, H5T_STD_I64LE, H5T_NATIVE_INT64, &value);
}
void Hdf5Writer::attribute(const std::string& path, const char* name, double value) {
  writeAttribute(path, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
}

void Hdf5Writer::writeAttribute(const std::string& path, const char* name, hid_t type, hid_t inMemory,
                                const void* data) {
  if (!writing()) return;
  const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Hdf5Handle attribute(
      H5Acreate_by_name(file_, path.c_str(), name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
      H5Aclose);
  require(attribute.good() && H5Awrite(attribute, inMemory, data) >= 0);
}

/// On the first rank: creates a table. @return its position in the file [bytes]; negative: nothing is written
std::int64_t Hdf5Writer::placeTable(const std::string& path, std::int64_t rows, int columns, int depth,
                                    hid_t type) {
  const auto size = rows * columns * depth * static_cast<std::int64_t>(H5Tget_size(type));
  require(sizeSoFar() + size < largestFile() - spare, tooLarge);
  if (!writing()) return -1;
  const Hdf5Handle space(rowsSpace(rows, columns, depth), H5Sclose);
  const Hdf5Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(creation, false);
  H5Pset_alloc_time(creation, H5D_ALLOC_TIME_EARLY);
  H5Pset_fill_time(creation, H5D_FILL_TIME_NEVER);
  const Hdf5Handle set(H5Dcreate2(file_, path.c_str(), type, space, H5P_DEFAULT, creation, H5P_DEFAULT),
                       H5Dclose);
  require(set.good());
  if (rows == 0 || !set.good()) return -1;
  const haddr_t position = H5Dget_offset(set);  // with the user block
  require(position != HADDR_UNDEF);
  if (position == HADDR_UNDEF) return -1;
  const auto begin = static_cast<std::int64_t>(position);
  tables_.push_back({begin, begin + size});
  return begin;
}

std::int64_t Hdf5Writer::sizeSoFar() const {
  hsize_t size = 0;
  return file_.good() && H5Fget_filesize(file_, &size) >= 0 ? static_cast<std::int64_t>(size) : 0;
}

void Hdf5Writer::writeTable(const std::string& path, std::int64_t rows, int columns, int depth, hid_t type,
                            std::string_view data) {
  const std::int64_t all = ranks_.sum(rows);
  std::int64_t position = first_ ? placeTable(path, all, columns, depth, type) : -1;
  ranks_.streamToFirst({data}, [&](std::string_view part) {
    toDisk(position, part);
    position += static_cast<std::int64_t>(part.size());
  });
}

/// On the first rank.
void Hdf5Writer::toDisk(std::int64_t position, std::string_view text) {
  if (!writing()) return;
  try {
    disk_.write(position, text);
  } catch (const OutputError& error) {
    error_ = error.what();
  }
}

/// What HDF5 has written into memory, except where tables are: it has left them empty.
void Hdf5Writer::writeAllButTables() {
  std::sort(tables_.begin(), tables_.end(),
            [](const Extent& a, const Extent& b) { return a.begin < b.begin; });
  std::string text;
  const auto copy = [&](std::int64_t begin, std::int64_t end) {
    text.resize(static_cast<std::size_t>(std::max<std::int64_t>(end - begin, 0)));
    require(::pread(memory_, text.data(), text.size(), begin) == static_cast<ssize_t>(text.size()));
    toDisk(begin, text);
  };
  std::int64_t done = 0;
  for (const Extent& table : tables_) {
    copy(done, table.begin);
    done = table.end;
  }
  copy(done, ::lseek(memory_, 0, SEEK_END));
}

void Hdf5Writer::close() {
  if (first_) require(file_.close());
  if (writing()) writeAllButTables();
  if (!error_.empty()) throw OutputError(error_);
}

void writeMesh(Hdf5Writer& out, const std::string& group, const TriangleMesh& mesh) {
  std::vector<double> vertices;
  for (const Vec3& v : mesh.vertices) vertices.insert(vertices.end(), v.data(), v.data() + 3);
  std::vector<std::int32_t> triangles;
  for (const Triangle& t : mesh.triangles) triangles.insert(triangles.end(), {t[0], t[1], t[2]});
  out.commonTable(group + "/vertices", 3, vertices);
  out.commonTable(group + "/triangles", 3, triangles);
}

}  // namespace packmesh
