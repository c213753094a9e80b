// Arrays in HDF5 files. The same calls write the same bytes. Files are read as untrusted input.
//
// Writing. Objects carry no times, the library version is fixed to the format of 1.8, and numbers
// have one byte order. Bytes depend only on the numbers. Series are stored in chunks: bytes of
// equal significance are grouped (shuffle) and compressed by zlib at its lowest level, and each
// chunk has a Fletcher checksum. A row that is appended extends the array and writes the chunks
// that it touches: memory does not grow with the run.
//
// Reading. HDF5 1.10 trusts the contents of a file: lengths, links to other files, filters,
// addresses of texts of variable length. Each claim is therefore checked before it is used. An
// array must be in the file itself, be stored contiguously or in chunks with the three known
// filters, claim no more entries than a file of this size can hold, and have exactly the type that
// the writer gives it. Texts have a fixed length, that of the longest of their array.
//
// HDF5 reports failures through return codes; `check` and `requireRead` turn them into exceptions.
// The library is not thread-safe by default: this file refuses to compile against such a build.
#include "sim/trajectory/array_file.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <functional>
#include <map>
#include <numeric>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <hdf5.h>

#include "sim/base/error.h"
#include "sim/base/file_kinds.h"

#ifndef H5_HAVE_THREADSAFE
#error "this HDF5 library is not thread-safe, but trajectories and checkpoints use separate threads"
#endif

namespace kirireel::trajectory {
namespace {

// Large enough to compress well, small enough to fit HDF5's cache of 1 MiB for each array.
constexpr std::size_t kChunkBytes = 256 * 1024;
// zlib level. Higher levels cost several times as much and save a few per cent.
constexpr unsigned kCompression = 1;
// An array that claims to be this many times larger than its file is damaged. Constant data
// compress up to 1000 times, but are stored with times and vertices, which do not.
constexpr double kMaxShrunk = 200;
constexpr const char* kChecksum = "crc32";
// First bytes of the writer's files: the signature, then the version of the superblock.
constexpr std::string_view kBeginning = "\x89HDF\r\n\x1a\n\x02";

/// An HDF5 identifier, closed at the end of its scope.
class Handle {
 public:
  Handle() = default;
  Handle(hid_t id, herr_t (*closing)(hid_t)) : id_(id), close_(closing) {}
  Handle(Handle&& other) noexcept
      : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  // Swapping leaves the old identifier to the other's destructor.
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Handle() { close(); }

  hid_t id() const { return id_; }
  bool valid() const { return id_ >= 0; }
  /// Returns false if closing failed: pending data could not be written.
  bool close() { return !valid() || close_(std::exchange(id_, H5I_INVALID_HID)) >= 0; }

 private:
  hid_t id_ = H5I_INVALID_HID;
  herr_t (*close_)(hid_t) = nullptr;
};

/// Call this before any other call of HDF5: failures are then thrown, not printed, and nothing is
/// retried at the end of the program.
void startLibrary() {
  // Initialised once, by the first thread.
  static const herr_t once = H5dont_atexit();
  static_cast<void>(once);
  H5Eset_auto(H5E_DEFAULT, nullptr, nullptr);
}

// Access properties for writing and reading.
Handle accessProperties() {
  startLibrary();
  Handle properties(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  // Network file systems often refuse locks.
  H5Pset_file_locking(properties.id(), false, true);
  // The format of HDF5 1.8: metadata have checksums, and MATLAB can read it.
  H5Pset_libver_bounds(properties.id(), H5F_LIBVER_V18, H5F_LIBVER_V18);
  return properties;
}

/// Creation properties without a time stamp.
Handle untimed(hid_t kind) {
  Handle properties(H5Pcreate(kind), H5Pclose);
  H5Pset_obj_track_times(properties.id(), false);
  return properties;
}

/// UTF-8 with a fixed number of bytes, padded with 0.
Handle textType(std::size_t bytes) {
  Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  // HDF5 has no texts of 0 bytes.
  H5Tset_size(type.id(), std::max<std::size_t>(1, bytes));
  H5Tset_strpad(type.id(), H5T_STR_NULLPAD);
  H5Tset_cset(type.id(), H5T_CSET_UTF8);
  return type;
}

Handle spaceOf(const Shape& shape) {
  const std::vector<hsize_t> lengths(shape.begin(), shape.end());
  return {H5Screate_simple(static_cast<int>(lengths.size()), lengths.data(), nullptr), H5Sclose};
}

Handle scalarSpace() {
  return {H5Screate(H5S_SCALAR), H5Sclose};
}

/// The lengths of an array with `count` rows of a shape.
std::vector<hsize_t> withRows(std::size_t count, const Shape& rowShape) {
  std::vector<hsize_t> lengths = {count};
  lengths.insert(lengths.end(), rowShape.begin(), rowShape.end());
  return lengths;
}

/// Selects consecutive rows of an array.
bool selectRows(hid_t space, std::size_t first, std::size_t rows, const Shape& rowShape) {
  std::vector<hsize_t> start(rowShape.size() + 1, 0);
  start.front() = first;
  const std::vector<hsize_t> count = withRows(rows, rowShape);
  return H5Sselect_hyperslab(space, H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr) >=
         0;
}

/// HDF5's own checksums need chunks: 3.7 ms for 4 MB instead of 1.8.
double checksum(std::span<const double> entries) {
  return checksumOf(std::as_bytes(entries));
}

}  // namespace

std::size_t entryCount(const Shape& shape) {
  return std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies<>());
}

struct ArrayWriter::Internals {
  /// An array that can grow.
  struct Series {
    Handle array;
    Shape rowShape;
    std::size_t rows = 0;
  };

  void check(bool done) {
    if (done) return;
    // The destructor must not close a file whose writing failed.
    failed = true;
    const std::string reason = errno != 0 ? std::strerror(errno) : "HDF5 reports no reason";
    throw OutputError(
        fmt::format("{}: error: cannot be written ({}); free some space or choose another folder",
                    shownPath.string(), reason));
  }

  Handle make(const std::string& name, hid_t type, const Handle& space, const Handle& properties) {
    errno = 0;
    Handle array(H5Dcreate2(file.id(), name.c_str(), type, space.id(), H5P_DEFAULT, properties.id(),
                            H5P_DEFAULT),
                 H5Dclose);
    check(array.valid());
    return array;
  }

  // Writes an array that does not grow. `stored` and `given` are its types in the file and in
  // memory.
  void writeWhole(const std::string& name, hid_t stored, hid_t given, const void* entries,
                  const Shape& shape) {
    arrays.push_back(make(name, stored, spaceOf(shape), untimed(H5P_DATASET_CREATE)));
    // HDF5 cannot write zero entries.
    if (entryCount(shape) == 0) return;
    check(H5Dwrite(arrays.back().id(), given, H5S_ALL, H5S_ALL, H5P_DEFAULT, entries) >= 0);
  }

  void setAttribute(const std::string& object, const std::string& name, hid_t stored, hid_t given,
                    const void* value) {
    errno = 0;
    const Handle owner(H5Oopen(file.id(), object.c_str(), H5P_DEFAULT), H5Oclose);
    const Handle attribute(
        H5Acreate2(owner.id(), name.c_str(), stored, scalarSpace().id(), H5P_DEFAULT, H5P_DEFAULT),
        H5Aclose);
    check(attribute.valid() && H5Awrite(attribute.id(), given, value) >= 0);
  }

  std::filesystem::path shownPath;
  Handle file;
  std::vector<Handle> arrays;
  std::map<std::string, Series> series;
  bool failed = false;
};

ArrayWriter::ArrayWriter(const std::filesystem::path& path, std::filesystem::path shownPath,
                         Opening opening)
    : internals_(std::make_unique<Internals>()) {
  Internals& in = *internals_;
  in.shownPath = std::move(shownPath);
  const Handle access = accessProperties();
  errno = 0;
  in.file = Handle(
      opening == Opening::Extend
          ? H5Fopen(path.c_str(), H5F_ACC_RDWR, access.id())
          : H5Fcreate(path.c_str(), H5F_ACC_TRUNC, untimed(H5P_FILE_CREATE).id(), access.id()),
      H5Fclose);
  in.check(in.file.valid());
}

ArrayWriter::~ArrayWriter() {
  // After a failed write (disk full) HDF5 crashes when the file is closed. The file stays open; the
  // list keeps it reachable and is itself never destroyed.
  static auto* const kept = new std::vector<std::unique_ptr<Internals>>;
  if (internals_->failed) kept->push_back(std::move(internals_));
}

void ArrayWriter::addGroup(const std::string& name) {
  errno = 0;
  const Handle group(H5Gcreate2(internals_->file.id(), name.c_str(), H5P_DEFAULT,
                                untimed(H5P_GROUP_CREATE).id(), H5P_DEFAULT),
                     H5Gclose);
  internals_->check(group.valid());
}

void ArrayWriter::write(const std::string& name, std::span<const double> entries,
                        const Shape& shape) {
  internals_->writeWhole(name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, entries.data(), shape);
}

void ArrayWriter::write(const std::string& name, std::span<const int> entries, const Shape& shape) {
  internals_->writeWhole(name, H5T_STD_I32LE, H5T_NATIVE_INT, entries.data(), shape);
}

void ArrayWriter::writeChecked(const std::string& name, std::span<const double> entries) {
  write(name, entries, {entries.size()});
  setAttribute(name, kChecksum, checksum(entries));
}

void ArrayWriter::write(const std::string& name, const std::vector<std::string>& texts) {
  std::size_t longest = 1;
  for (const std::string& text : texts) longest = std::max(longest, text.size());
  std::string bytes;
  for (const std::string& text : texts)
    bytes.append(text).resize(bytes.size() + longest - text.size());
  const Handle type = textType(longest);
  internals_->writeWhole(name, type.id(), type.id(), bytes.data(), {texts.size()});
}

// A chunk holds whole rows, because reading is row by row.
void ArrayWriter::addSeries(const std::string& name, const Shape& rowShape) {
  const std::size_t rowBytes = std::max<std::size_t>(1, entryCount(rowShape)) * sizeof(double);
  // At least one row per chunk, and at most 1024 short rows: the first rows of a run reach the
  // disk.
  const std::size_t chunkRows = std::clamp<std::size_t>(kChunkBytes / rowBytes, 1, 1024);
  std::vector<hsize_t> chunk = withRows(chunkRows, rowShape);
  const std::vector<hsize_t> start = withRows(0, rowShape);
  const std::vector<hsize_t> most = withRows(H5S_UNLIMITED, rowShape);
  const int rank = static_cast<int>(chunk.size());

  const Handle properties = untimed(H5P_DATASET_CREATE);
  H5Pset_chunk(properties.id(), rank, chunk.data());
  H5Pset_shuffle(properties.id());
  H5Pset_deflate(properties.id(), kCompression);
  H5Pset_fletcher32(properties.id());  // one checksum per chunk
  const Handle space(H5Screate_simple(rank, start.data(), most.data()), H5Sclose);
  internals_->series[name] = {internals_->make(name, H5T_IEEE_F64LE, space, properties), rowShape,
                              0};
}

void ArrayWriter::append(const std::string& name, std::span<const double> rows) {
  Internals::Series& series = internals_->series.at(name);
  // A row without entries would divide by 0.
  const std::size_t count = rows.size() / std::max<std::size_t>(1, entryCount(series.rowShape));
  if (count == 0) return;
  errno = 0;
  const std::vector<hsize_t> lengths = withRows(series.rows + count, series.rowShape);
  internals_->check(H5Dset_extent(series.array.id(), lengths.data()) >= 0);
  const Handle inFile(H5Dget_space(series.array.id()), H5Sclose);
  const Handle inMemory = spaceOf({rows.size()});
  internals_->check(selectRows(inFile.id(), series.rows, count, series.rowShape) &&
                    H5Dwrite(series.array.id(), H5T_NATIVE_DOUBLE, inMemory.id(), inFile.id(),
                             H5P_DEFAULT, rows.data()) >= 0);
  series.rows += count;
}

void ArrayWriter::setAttribute(const std::string& object, const std::string& name,
                               const std::string& text) {
  const Handle type = textType(text.size());
  internals_->setAttribute(object, name, type.id(), type.id(), text.c_str());
}

void ArrayWriter::setAttribute(const std::string& object, const std::string& name, double number) {
  internals_->setAttribute(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &number);
}

// Everything is closed explicitly: destructors could not report errors.
void ArrayWriter::close() {
  errno = 0;
  // Arrays first: a file does not close while an array is open.
  for (Handle& array : internals_->arrays) internals_->check(array.close());
  for (auto& [name, series] : internals_->series) internals_->check(series.array.close());
  internals_->check(internals_->file.close());
}

namespace {

/// Whether a stored type is the writer's own type; other types are not converted.
using TypeCheck = bool (*)(const Handle& type);

bool isDouble(const Handle& type) {
  return H5Tequal(type.id(), H5T_IEEE_F64LE) > 0;
}

bool isInt(const Handle& type) {
  return H5Tequal(type.id(), H5T_STD_I32LE) > 0;
}

/// One text of an array of bytes.
std::string withoutPadding(const std::string& bytes, std::size_t first, std::size_t length) {
  return bytes.substr(first, std::min(length, bytes.find('\0', first) - first));
}

bool isText(const Handle& type) {
  return H5Tget_class(type.id()) == H5T_STRING && H5Tis_variable_str(type.id()) == 0;
}

}  // namespace

struct ArrayReader::Internals {
  [[noreturn]] void refuse(const std::string& found) const {
    throw InputError(fmt::format(
        "{}: error: {}. Give a complete trajectory.h5 from kirireel record", path.string(), found));
  }

  /// Arrays stay open: HDF5 caches the chunk that neighbouring rows share.
  const Handle& array(const std::string& name) {
    Handle& array = arrays[name];
    if (array.valid()) return array;
    if (!isOwn(name)) refuse(fmt::format("the array {} is missing", name));
    array = Handle(H5Dopen2(file.id(), name.c_str(), H5P_DEFAULT), H5Dclose);
    if (!array.valid()) refuse(fmt::format("the array {} is missing", name));
    requirePlainStorage(array, name);
    return array;
  }

  /// Whether the file itself holds an object of this name: links could point to other files.
  bool isOwn(const std::string& name) const {
    for (std::size_t end = name.find('/');; end = name.find('/', end + 1)) {
      H5L_info_t link;
      const std::string part = name.substr(0, end);
      if (H5Lexists(file.id(), part.c_str(), H5P_DEFAULT) <= 0) return false;
      if (H5Lget_info(file.id(), part.c_str(), &link, H5P_DEFAULT) < 0) return false;
      // Soft and external links may refer to other files.
      if (link.type != H5L_TYPE_HARD) return false;
      if (end == std::string::npos) return true;
    }
  }

  /// Rejects features that the writer never uses and HDF5 would follow: other files, other filters,
  /// chunks of any size.
  void requirePlainStorage(const Handle& array, const std::string& name) const {
    const Handle properties(H5Dget_create_plist(array.id()), H5Pclose);
    const H5D_layout_t layout = H5Pget_layout(properties.id());
    bool isPlain = layout == H5D_CONTIGUOUS && H5Pget_external_count(properties.id()) == 0;
    if (layout == H5D_CHUNKED) isPlain = hasPlainFilters(properties) && hasSmallChunks(properties);
    if (!isPlain) refuse(fmt::format("the array {} has another layout", name));
  }

  static bool hasPlainFilters(const Handle& properties) {
    for (int k = 0; k < H5Pget_nfilters(properties.id()); ++k) {
      std::size_t parameters = 0;
      const H5Z_filter_t filter = H5Pget_filter2(properties.id(), static_cast<unsigned>(k), nullptr,
                                                 &parameters, nullptr, 0, nullptr, nullptr);
      if (filter != H5Z_FILTER_SHUFFLE && filter != H5Z_FILTER_DEFLATE &&
          filter != H5Z_FILTER_FLETCHER32) {
        return false;
      }
    }
    return true;
  }

  bool hasSmallChunks(const Handle& properties) const {
    std::array<hsize_t, H5S_MAX_RANK> lengths{};
    const int rank =
        H5Pget_chunk(properties.id(), static_cast<int>(lengths.size()), lengths.data());
    return rank > 0 && isClaimable({lengths.begin(), lengths.begin() + rank});
  }

  /// Whether a file of this size can hold an array of this shape.
  bool isClaimable(const Shape& shape) const {
    // In doubles, as a product of lengths may overflow an integer.
    double bytes = sizeof(double);
    for (const std::size_t length : shape) bytes *= static_cast<double>(length);
    return bytes <= kMaxShrunk * fileBytes;
  }

  // HDF5 does not convert: only the writer's own types are accepted.
  void requireType(const Handle& array, const std::string& name, TypeCheck isRequested,
                   const char* shownType) const {
    const Handle type(H5Dget_type(array.id()), H5Tclose);
    if (!isRequested(type)) refuse(fmt::format("the array {} does not have {}", name, shownType));
  }

  // The lengths that the file claims, after a check that they are possible.
  Shape shapeOf(const Handle& array) const {
    const Handle space(H5Dget_space(array.id()), H5Sclose);
    std::vector<hsize_t> lengths(
        static_cast<std::size_t>(std::max(0, H5Sget_simple_extent_ndims(space.id()))));
    H5Sget_simple_extent_dims(space.id(), lengths.data(), nullptr);
    const Shape shape(lengths.begin(), lengths.end());
    if (!isClaimable(shape)) refuse("an array has more entries than its file");
    return shape;
  }

  void requireRead(herr_t code, const std::string& name) const {
    if (code < 0) refuse(fmt::format("the array {} is damaged", name));
  }

  /// The bytes per text of this type, after a check that the file can hold `count` of them.
  std::size_t textLength(const Handle& type, std::size_t count) const {
    const std::size_t length = H5Tget_size(type.id());
    if (!isClaimable({count, length / sizeof(double)})) {
      refuse("an array has more entries than its file");
    }
    return length;
  }

  /// Other format versions have no checksums for metadata.
  bool beginsAsOurs() const {
    std::string beginning(kBeginning.size(), '\0');
    openInputFile(path).read(beginning.data(), std::ssize(beginning));
    return beginning == kBeginning;
  }

  /// A missing attribute and one of another type are the same error: the file is not ours.
  Handle attribute(const std::string& object, const std::string& name,
                   TypeCheck isRequested) const {
    Handle attribute(
        H5Aopen_by_name(file.id(), object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
        H5Aclose);
    const Handle type(H5Aget_type(attribute.id()), H5Tclose);
    const Handle space(H5Aget_space(attribute.id()), H5Sclose);
    const bool isOurs = object == "/" || isOwn(object);
    if (!isOurs || !attribute.valid() || !isRequested(type) ||
        H5Sget_simple_extent_npoints(space.id()) != 1) {
      refuse(fmt::format("the attribute {} of {} is missing or of another kind", name,
                         object == "/" ? "the file itself" : object));
    }
    return attribute;
  }

  std::filesystem::path path;
  double fileBytes = 0;
  Handle file;
  std::map<std::string, Handle> arrays;
};

ArrayReader::ArrayReader(std::filesystem::path path) : internals_(std::make_unique<Internals>()) {
  Internals& in = *internals_;
  in.path = std::move(path);
  const Handle access = accessProperties();
  if (!isFile(in.path)) {
    throw InputError(fmt::format("{}: error: {}. Give a trajectory.h5 from kirireel record",
                                 in.path.string(), whyAbsent(in.path, "file")));
  }
  std::error_code error;
  in.fileBytes = static_cast<double>(std::filesystem::file_size(in.path, error));
  // Checks the bytes themselves, before HDF5 opens the file.
  if (!in.beginsAsOurs()) in.refuse("this is not an HDF5 file");
  in.file = Handle(H5Fopen(in.path.c_str(), H5F_ACC_RDONLY, access.id()), H5Fclose);
  if (!in.file.valid()) in.refuse("the file is incomplete or damaged");
}

ArrayReader::~ArrayReader() = default;

void ArrayReader::refuse(const std::string& found) const {
  internals_->refuse(found);
}

bool ArrayReader::has(const std::string& name) const {
  return internals_->isOwn(name);
}

bool ArrayReader::hasAttribute(const std::string& object, const std::string& name) const {
  return H5Aexists_by_name(internals_->file.id(), object.c_str(), name.c_str(), H5P_DEFAULT) > 0;
}

Shape ArrayReader::shape(const std::string& name) const {
  return internals_->shapeOf(internals_->array(name));
}

std::vector<double> ArrayReader::doubles(const std::string& name) const {
  const Handle& array = internals_->array(name);
  internals_->requireType(array, name, isDouble, "numbers of 64 bits");
  std::vector<double> entries(entryCount(internals_->shapeOf(array)));
  internals_->requireRead(
      H5Dread(array.id(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, entries.data()), name);
  return entries;
}

std::vector<double> ArrayReader::checkedDoubles(const std::string& name) const {
  std::vector<double> entries = doubles(name);
  // A CRC of 32 bits is a whole number that a double holds exactly.
  if (checksum(entries) != numberAttribute(name, kChecksum)) {
    refuse(fmt::format("the array {} is damaged", name));
  }
  return entries;
}

std::vector<int> ArrayReader::integers(const std::string& name) const {
  const Handle& array = internals_->array(name);
  internals_->requireType(array, name, isInt, "whole numbers of 32 bits");
  std::vector<int> entries(entryCount(internals_->shapeOf(array)));
  internals_->requireRead(
      H5Dread(array.id(), H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, entries.data()), name);
  return entries;
}

std::vector<std::string> ArrayReader::texts(const std::string& name) const {
  const Handle& array = internals_->array(name);
  internals_->requireType(array, name, isText, "texts of a fixed length");
  const std::size_t count = entryCount(internals_->shapeOf(array));
  const std::size_t length =
      internals_->textLength(Handle(H5Dget_type(array.id()), H5Tclose), count);
  std::string bytes(count * length, '\0');
  internals_->requireRead(
      H5Dread(array.id(), textType(length).id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, bytes.data()),
      name);
  std::vector<std::string> texts;
  for (std::size_t k = 0; k < count; ++k)
    texts.push_back(withoutPadding(bytes, k * length, length));
  return texts;
}

std::vector<double> ArrayReader::row(const std::string& name, std::size_t index) const {
  const Handle& array = internals_->array(name);
  Shape rowShape = internals_->shapeOf(array);
  if (rowShape.empty() || index >= rowShape.front()) {
    internals_->refuse(fmt::format("the array {} has no row {}", name, index));
  }
  rowShape.erase(rowShape.begin());
  internals_->requireType(array, name, isDouble, "numbers of 64 bits");
  std::vector<double> entries(entryCount(rowShape));
  const Handle inFile(H5Dget_space(array.id()), H5Sclose);
  const Handle inMemory = spaceOf({entries.size()});
  selectRows(inFile.id(), index, 1, rowShape);
  internals_->requireRead(H5Dread(array.id(), H5T_NATIVE_DOUBLE, inMemory.id(), inFile.id(),
                                  H5P_DEFAULT, entries.data()),
                          name);
  return entries;
}

std::string ArrayReader::textAttribute(const std::string& object, const std::string& name) const {
  const Handle attribute = internals_->attribute(object, name, isText);
  const std::size_t length =
      internals_->textLength(Handle(H5Aget_type(attribute.id()), H5Tclose), 1);
  std::string bytes(length, '\0');
  if (H5Aread(attribute.id(), textType(length).id(), bytes.data()) < 0) {
    internals_->refuse(fmt::format("the attribute {} is damaged", name));
  }
  return withoutPadding(bytes, 0, length);
}

double ArrayReader::numberAttribute(const std::string& object, const std::string& name) const {
  const Handle attribute = internals_->attribute(object, name, isDouble);
  double number = 0;
  if (H5Aread(attribute.id(), H5T_NATIVE_DOUBLE, &number) < 0) {
    internals_->refuse(fmt::format("the attribute {} is damaged", name));
  }
  return number;
}

std::string arrayLibraryVersion() {
  startLibrary();
  unsigned major = 0;
  unsigned minor = 0;
  unsigned release = 0;
  H5get_libversion(&major, &minor, &release);
  return fmt::format("{}.{}.{}", major, minor, release);
}

}  // namespace kirireel::trajectory
