// SPDX-License-Identifier: BSD-3-Clause
#include <tiffio.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/read_file.hpp"
#include "libsim/core/terrain/elevation_file.hpp"

namespace cas::sim {

namespace {

namespace fs = std::filesystem;

// Tags and keys of OGC 19-008r4 (GeoTIFF 1.1) and of GDAL.
constexpr std::uint32_t kPixelScale = 33550;
constexpr std::uint32_t kTiePoint = 33922;
constexpr std::uint32_t kGeoKeys = 34735;
constexpr std::uint32_t kNoData = 42113;
constexpr std::uint16_t kModelType = 1024;
constexpr std::uint16_t kGeographic = 2;
constexpr std::uint16_t kRasterType = 1025;
constexpr std::uint16_t kPixelIsPoint = 2;
constexpr std::uint32_t kMostSamples = 1'000'000;  // along an edge
/// Beyond, a number is no height in metres.
constexpr double kHighest_m = 20'000;

/// What libtiff complained of last.
std::string& complaint() {
  thread_local std::string text;
  return text;
}

void on_error(const char* /*module*/, const char* format, va_list arguments) {
  char text[200];
  std::vsnprintf(text, sizeof(text), format, arguments);
  complaint() = text;
}

struct TiffCloser {
  void operator()(TIFF* tiff) const { TIFFClose(tiff); }
};
using OpenTiff = std::unique_ptr<TIFF, TiffCloser>;

[[noreturn]] void refuse(const fs::path& file, const std::string& sentence) {
  throw base::ConfigError(file.string() + ": " + sentence);
}

OpenTiff open_tiff(const fs::path& file) {
  TIFFSetErrorHandler(&on_error);
  TIFFSetWarningHandler(nullptr);  // tags that it does not know
  complaint().clear();
  const base::OpenFile opened = base::open_foreign_file(file, "elevation file");
  // m: read, not mapped, so that a file that is cut meanwhile ends in an error.
  OpenTiff tiff(TIFFFdOpen(dup(fileno(opened.get())), file.c_str(), "rm"));
  if (!tiff) refuse(file, "is no TIFF file: " + complaint());
  return tiff;
}

/// libtiff's name of a type of numbers.
template <class T>
constexpr TIFFDataType kTypeOf = TIFF_NOTYPE;
template <>
constexpr TIFFDataType kTypeOf<double> = TIFF_DOUBLE;
template <>
constexpr TIFFDataType kTypeOf<std::uint16_t> = TIFF_SHORT;
template <>
constexpr TIFFDataType kTypeOf<char> = TIFF_ASCII;

/// Numbers of a tag that libtiff does not know; empty: it is not there, or of another type, whose
/// bytes libtiff would hand out as they are.
template <class T>
std::vector<T> numbers_of(TIFF* tiff, std::uint32_t tag) {
  const TIFFField* const known = TIFFFindField(tiff, tag, TIFF_ANY);
  if (known == nullptr || TIFFFieldDataType(known) != kTypeOf<T>) return {};
  std::uint32_t count = 0;
  void* data = nullptr;
  if (TIFFGetField(tiff, tag, &count, &data) != 1 || data == nullptr) return {};
  const auto* const numbers = static_cast<const T*>(data);
  return {numbers, numbers + count};
}

template <class T>
T field(TIFF* tiff, std::uint32_t tag) {
  T value{};
  TIFFGetFieldDefaulted(tiff, tag, &value);
  return value;
}

/// A key of the directory of keys; 0: not there.
std::uint16_t geo_key(const std::vector<std::uint16_t>& keys, std::uint16_t id) {
  for (std::size_t at = 4; at + 3 < keys.size(); at += 4) {
    if (keys[at] == id && keys[at + 1] == 0) return keys[at + 3];
  }
  return 0;
}

/// Number of the samples that stand for no data.
std::optional<double> no_data_of(TIFF* tiff) {
  const std::vector<char> text = numbers_of<char>(tiff, kNoData);
  const char* const first = text.data();
  double value = 0;
  if (text.empty() || std::from_chars(first, first + text.size(), value).ec != std::errc()) {
    return std::nullopt;
  }
  return value;
}

/// Format of the samples in a file.
enum class Samples { kInt16, kUint16, kInt32, kFloat32, kFloat64 };

Samples samples_of(TIFF* tiff, const fs::path& file) {
  const auto bits = field<std::uint16_t>(tiff, TIFFTAG_BITSPERSAMPLE);
  const auto format = field<std::uint16_t>(tiff, TIFFTAG_SAMPLEFORMAT);
  const auto bands = field<std::uint16_t>(tiff, TIFFTAG_SAMPLESPERPIXEL);
  if (bands == 1) {
    if (format == SAMPLEFORMAT_INT && bits == 16) return Samples::kInt16;
    if (format == SAMPLEFORMAT_UINT && bits == 16) return Samples::kUint16;
    if (format == SAMPLEFORMAT_INT && bits == 32) return Samples::kInt32;
    if (format == SAMPLEFORMAT_IEEEFP && bits == 32) return Samples::kFloat32;
    if (format == SAMPLEFORMAT_IEEEFP && bits == 64) return Samples::kFloat64;
  }
  refuse(file,
         "an elevation file has one band of whole numbers of 16 or 32 bits or of floating-point "
         "ones of 32 or 64");
}

/// With a degree to spare on each side; false for what is no number.
bool is_on_earth(const ElevationGrid& grid) {
  return grid.step_lon_deg > 0 && grid.step_lat_deg > 0 && std::abs(grid.west_deg) <= 361 &&
         std::abs(grid.north_deg) <= 91 && grid.columns * grid.step_lon_deg <= 362 &&
         grid.rows * grid.step_lat_deg <= 182;
}

ElevationGrid grid_of(TIFF* tiff, const fs::path& file) {
  const auto scale = numbers_of<double>(tiff, kPixelScale);
  const auto tie = numbers_of<double>(tiff, kTiePoint);
  const auto keys = numbers_of<std::uint16_t>(tiff, kGeoKeys);
  if (scale.size() < 2 || tie.size() < 6 || geo_key(keys, kModelType) != kGeographic) {
    refuse(file,
           "is no GeoTIFF in degrees of latitude and longitude; `gdalwarp -t_srs EPSG:4326` makes "
           "one of another projection");
  }
  const auto columns = field<std::uint32_t>(tiff, TIFFTAG_IMAGEWIDTH);
  const auto rows = field<std::uint32_t>(tiff, TIFFTAG_IMAGELENGTH);
  const bool is_tiled = TIFFIsTiled(tiff) != 0;
  const auto block_columns = is_tiled ? field<std::uint32_t>(tiff, TIFFTAG_TILEWIDTH) : columns;
  const auto block_rows = is_tiled
                              ? field<std::uint32_t>(tiff, TIFFTAG_TILELENGTH)
                              : std::min(rows, field<std::uint32_t>(tiff, TIFFTAG_ROWSPERSTRIP));
  const auto is_size = [](std::uint32_t n) { return n >= 1 && n <= kMostSamples; };
  if (columns < 2 || rows < 2 || !is_size(columns) || !is_size(rows) || !is_size(block_columns) ||
      !is_size(block_rows) || std::uint64_t{block_columns} * block_rows > kMostBlockSamples) {
    refuse(file,
           "an elevation file has 2 to a million samples along an edge, and at most 16 "
           "million in a tile or strip");
  }
  // The tie point is a corner of a pixel, or the sample itself.
  const double middle = geo_key(keys, kRasterType) == kPixelIsPoint ? 0 : 0.5;
  const ElevationGrid grid{.west_deg = tie[3] + (middle - tie[0]) * scale[0],
                           .north_deg = tie[4] - (middle - tie[1]) * scale[1],
                           .step_lon_deg = scale[0],
                           .step_lat_deg = scale[1],
                           .columns = static_cast<int>(columns),
                           .rows = static_cast<int>(rows),
                           .block_columns = static_cast<int>(block_columns),
                           .block_rows = static_cast<int>(block_rows)};
  if (!is_on_earth(grid)) refuse(file, "its place on Earth is not in degrees");
  return grid;
}

template <class T>
void to_heights(const std::vector<std::uint8_t>& bytes, std::optional<double> no_data,
                std::span<float> out) {
  for (std::size_t i = 0; i < out.size(); ++i) {
    T raw;
    std::memcpy(&raw, &bytes[i * sizeof(T)], sizeof(T));
    const auto value = static_cast<double>(raw);
    const bool is_none = no_data && static_cast<float>(value) == static_cast<float>(*no_data);
    out[i] = is_none || !(std::abs(value) < kHighest_m) ? std::numeric_limits<float>::quiet_NaN()
                                                        : static_cast<float>(value);
  }
}

class GeotiffFile final : public ElevationFile {
 public:
  GeotiffFile(TIFF* tiff, const fs::path& file)
      : ElevationFile(grid_of(tiff, file)),
        file_(file),
        samples_(samples_of(tiff, file)),
        no_data_(no_data_of(tiff)) {}

  void read_block(int column, int row, std::span<float> out) const override {
    const OpenTiff tiff = open_tiff(file_);
    std::vector<std::uint8_t> bytes(out.size() * sizeof(double));
    if (read(tiff.get(), column, row, bytes) < 0) refuse(file_, "cannot be read: " + complaint());
    switch (samples_) {
      case Samples::kInt16:
        return to_heights<std::int16_t>(bytes, no_data_, out);
      case Samples::kUint16:
        return to_heights<std::uint16_t>(bytes, no_data_, out);
      case Samples::kInt32:
        return to_heights<std::int32_t>(bytes, no_data_, out);
      case Samples::kFloat32:
        return to_heights<float>(bytes, no_data_, out);
      case Samples::kFloat64:
        return to_heights<double>(bytes, no_data_, out);
    }
  }

 private:
  tmsize_t read(TIFF* tiff, int column, int row, std::vector<std::uint8_t>& bytes) const {
    const auto size = static_cast<tmsize_t>(bytes.size());
    const auto x = static_cast<std::uint32_t>(column * grid_.block_columns);
    const auto y = static_cast<std::uint32_t>(row * grid_.block_rows);
    if (TIFFIsTiled(tiff) != 0) {
      return TIFFReadEncodedTile(tiff, TIFFComputeTile(tiff, x, y, 0, 0), bytes.data(), size);
    }
    return TIFFReadEncodedStrip(tiff, TIFFComputeStrip(tiff, y, 0), bytes.data(), size);
  }

  fs::path file_;
  Samples samples_;
  std::optional<double> no_data_;
};

}  // namespace

void cas_open_geotiff(const fs::path& file, std::unique_ptr<ElevationFile>& out) {
  const OpenTiff tiff = open_tiff(file);
  out = std::make_unique<GeotiffFile>(tiff.get(), file);
}

}  // namespace cas::sim
