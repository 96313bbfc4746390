// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/terrain/elevation_file.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/read_file.hpp"

namespace cas::sim {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kElevationFile = "elevation file";
constexpr std::int16_t kNoHeight = -32768;

std::string lower_extension(const fs::path& file) {
  std::string extension = file.extension().string();
  std::ranges::transform(extension, extension.begin(),
                         [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

/// Two or three digits of a name as degrees, by their letter. @return NaN: none
double degrees_of(const std::string& name, std::size_t at, std::size_t digits, char plus,
                  char minus) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  if (name.size() < at + 1 + digits) return none;
  const char letter = static_cast<char>(std::toupper(static_cast<unsigned char>(name[at])));
  if (letter != plus && letter != minus) return none;
  double value = 0;
  for (std::size_t i = at + 1; i <= at + digits; ++i) {
    if (std::isdigit(static_cast<unsigned char>(name[i])) == 0) return none;
    value = 10 * value + (name[i] - '0');
  }
  return letter == plus ? value : -value;
}

class HgtFile final : public ElevationFile {
 public:
  HgtFile(const ElevationGrid& grid, fs::path file) : ElevationFile(grid), file_(std::move(file)) {}

  void read_block(int /*column*/, int row, std::span<float> out) const override {
    const auto width = static_cast<std::size_t>(grid_.columns);
    const int first = row * grid_.block_rows;
    const auto rows = static_cast<std::size_t>(std::min(grid_.block_rows, grid_.rows - first));
    std::vector<std::uint8_t> bytes(2 * width * rows);
    const base::OpenFile file = base::open_foreign_file(file_, kElevationFile);
    const auto offset = static_cast<long>(2 * width * static_cast<std::size_t>(first));
    if (std::fseek(file.get(), offset, SEEK_SET) != 0 ||
        std::fread(bytes.data(), 1, bytes.size(), file.get()) != bytes.size()) {
      throw base::ConfigError(file_.string() + ": " + std::string(kElevationFile) + " is cut");
    }
    for (std::size_t i = 0; i < width * rows; ++i) {
      const auto height = static_cast<std::int16_t>(bytes[2 * i] << 8U | bytes[2 * i + 1]);
      out[i] = height == kNoHeight ? std::numeric_limits<float>::quiet_NaN() : height;
    }
  }

 private:
  fs::path file_;
};

/// The GeoTIFF reader beside this library. @return nullptr: it is not there
decltype(&cas_open_geotiff) open_geotiff_reader() {
  Dl_info self{};
  // In a statically linked program the name has no folder; dlopen then searches its path.
  const auto* const inside = reinterpret_cast<const void*>(&open_geotiff_reader);
  const fs::path folder =
      dladdr(inside, &self) != 0 ? fs::path(self.dli_fname).parent_path() : fs::path();
  void* const library = dlopen((folder / CAS_SIM_TERRAIN_FILE).c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) return nullptr;
  return reinterpret_cast<decltype(&cas_open_geotiff)>(dlsym(library, kOpenGeotiff));
}

}  // namespace

bool is_elevation_file(const fs::path& file) {
  const std::string extension = lower_extension(file);
  return extension == ".hgt" || extension == ".tif" || extension == ".tiff";
}

std::unique_ptr<ElevationFile> open_hgt(const fs::path& file) {
  const std::string name = file.filename().string();
  const double south = degrees_of(name, 0, 2, 'N', 'S');
  const double west = degrees_of(name, 3, 3, 'E', 'W');
  if (!(std::abs(south) <= 90) || !(std::abs(west) <= 180)) {
    throw base::ConfigError(file.string() +
                            ": the name of an HGT file begins with its south-west corner, such as "
                            "N47E008");
  }
  const base::OpenFile opened = base::open_foreign_file(file, kElevationFile);
  std::fseek(opened.get(), 0, SEEK_END);
  const auto bytes = static_cast<double>(std::ftell(opened.get()));
  const int n = static_cast<int>(std::lround(std::sqrt(bytes / 2)));
  constexpr int kMostSamples = 20'000;  // along an edge
  if (n < 2 || n > kMostSamples || 2.0 * n * n != bytes) {
    throw base::ConfigError(file.string() + ": " + std::string(kElevationFile) +
                            " is no square of 2-byte samples; an HGT file has 1201 x 1201 or "
                            "3601 x 3601 of them");
  }
  constexpr int kBlockRows = 16;
  const double step = 1.0 / (n - 1);
  return std::make_unique<HgtFile>(ElevationGrid{.west_deg = west,
                                                 .north_deg = south + 1,
                                                 .step_lon_deg = step,
                                                 .step_lat_deg = step,
                                                 .columns = n,
                                                 .rows = n,
                                                 .block_columns = n,
                                                 .block_rows = kBlockRows},
                                   file);
}

std::unique_ptr<ElevationFile> open_elevation_file(const fs::path& file) {
  if (lower_extension(file) == ".hgt") return open_hgt(file);
  static const auto open_geotiff = open_geotiff_reader();
  if (open_geotiff == nullptr) {
    throw base::ConfigError(file.string() +
                            ": GeoTIFF files cannot be read, because libcas_sim_terrain, which "
                            "needs libtiff, is not there; HGT files can");
  }
  std::unique_ptr<ElevationFile> opened;
  open_geotiff(file, opened);
  return opened;
}

}  // namespace cas::sim
