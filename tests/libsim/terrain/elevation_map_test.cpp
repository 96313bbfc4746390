// SPDX-License-Identifier: BSD-3-Clause
// Elevation files against the surfaces that they were written from.
#include "libsim/core/terrain/elevation_map.hpp"

#include <gmock/gmock.h>

#include <cmath>
#include <vector>

#include "tests/libsim/support/elevation_files.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

#if CAS_HAS_TIFF
#include <tiffio.h>
#endif

namespace cas::sim {
namespace {

namespace fs = std::filesystem;
using cas::test::refusal;
using test::write_hgt;
using testing::HasSubstr;

/// Even along both axes, so that bilinear interpolation is exact; whole metres on a grid of 100.
double slope_m(double lat_deg, double lon_deg) { return 100 * lat_deg + 300 * lon_deg; }

ElevationMap map_of(const fs::path& path) { return ElevationMap(std::span(&path, 1)); }

TEST(ElevationMap, ReadsHgtFilesBetweenTheirSamples) {
  const cas::test::TemporaryFolder folder;
  write_hgt(folder.path() / "N47E008.hgt", 101, 47, 8, slope_m);
  const ElevationMap map = map_of(folder.path());
  for (const double lat : {47.0, 47.123, 47.9999, 48.0}) {
    for (const double lon : {8.0, 8.5, 8.777, 9.0}) {
      EXPECT_NEAR(map.height_m(lat, lon).value(), slope_m(lat, lon), 1e-6) << lat << " " << lon;
    }
  }
  EXPECT_FALSE(map.height_m(46.9, 8.5).has_value());
  EXPECT_FALSE(map.height_m(47.5, 9.1).has_value());
}

TEST(ElevationMap, FillsASampleWithoutDataFromItsNeighbours) {
  const cas::test::TemporaryFolder folder;
  write_hgt(folder.path() / "S01W001.hgt", 11, -1, -1, [](double lat, double lon) {
    const bool is_hole = std::abs(lat + 0.5) < 1e-6 && std::abs(lon + 0.5) < 1e-6;
    return is_hole ? -32768.0 : 40.0;
  });
  EXPECT_DOUBLE_EQ(map_of(folder.path()).height_m(-0.5, -0.5).value(), 40);
}

TEST(ElevationMap, CrossesTheAntimeridianFromFileToFile) {
  const cas::test::TemporaryFolder folder;
  const auto height = [](double lat, double lon) { return 100 * lat + 100 * std::abs(lon); };
  write_hgt(folder.path() / "N10E179.hgt", 101, 10, 179, height);
  write_hgt(folder.path() / "N10W180.hgt", 101, 10, -180, height);
  const ElevationMap map = map_of(folder.path());
  EXPECT_NEAR(map.height_m(10.5, 179.995).value(), 1050 + 17999.5, 1e-6);
  EXPECT_NEAR(map.height_m(10.5, 180).value(), 1050 + 18000, 1e-6);
  EXPECT_NEAR(map.height_m(10.5, -179.995).value(), 1050 + 17999.5, 1e-6);
}

TEST(ElevationMap, RefusesWhatIsNoElevationFile) {
  const cas::test::TemporaryFolder folder;
  const auto says = [&](const fs::path& path) { return refusal([&] { map_of(path); }); };
  EXPECT_THAT(says(folder.path()), HasSubstr("holds no elevation file"));
  std::ofstream(folder.path() / "N47E008.hgt") << "abc";
  EXPECT_THAT(says(folder.path() / "N47E008.hgt"), HasSubstr("no square of 2-byte samples"));
  std::ofstream(folder.path() / "hill.hgt") << "abcdefgh";
  EXPECT_THAT(says(folder.path() / "hill.hgt"), HasSubstr("south-west corner"));
}

TEST(ElevationMap, NamesAFileThatWasCutAfterItWasOpened) {
  const cas::test::TemporaryFolder folder;
  const fs::path file = folder.path() / "N47E008.hgt";
  write_hgt(file, 101, 47, 8, slope_m);
  const ElevationMap map = map_of(file);
  fs::resize_file(file, 1000);
  EXPECT_THAT(refusal([&] { map.height_m(47.1, 8.5); }), HasSubstr("is cut"));
}

#if CAS_HAS_TIFF

constexpr std::uint16_t kGeographic = 2;
constexpr std::uint16_t kProjected = 1;

struct TiffForm {
  const char* name;
  bool tiled;
  bool is_float;
  bool is_point;  // the tie point is a sample, not a corner of its pixel
  std::uint16_t model = kGeographic;
  double tie_column = 0;
};

/// 50 x 40 samples, 0.01 degree apart; the tie point of the first is at 8 E, 48 N.
void write_geotiff(const fs::path& file, const TiffForm& form, double west = 8) {
  static const TIFFFieldInfo kFields[] = {
      {33550, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, const_cast<char*>("scale")},
      {33922, -1, -1, TIFF_DOUBLE, FIELD_CUSTOM, 1, 1, const_cast<char*>("tie")},
      {34735, -1, -1, TIFF_SHORT, FIELD_CUSTOM, 1, 1, const_cast<char*>("keys")},
      {42113, -1, -1, TIFF_ASCII, FIELD_CUSTOM, 1, 0, const_cast<char*>("nodata")}};
  constexpr std::uint32_t kColumns = 50;
  constexpr std::uint32_t kRows = 40;
  TIFF* const tiff = TIFFOpen(file.c_str(), "w");
  TIFFMergeFieldInfo(tiff, kFields, 4);
  TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, kColumns);
  TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, kRows);
  TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
  TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, form.is_float ? 32 : 16);
  TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, form.is_float ? SAMPLEFORMAT_IEEEFP : SAMPLEFORMAT_INT);
  TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
  TIFFSetField(tiff, TIFFTAG_PREDICTOR, form.is_float ? PREDICTOR_FLOATINGPOINT : 2);
  const double scale[3] = {0.01, 0.01, 0};
  const double tie[6] = {form.tie_column, 0, 0, west, 48, 0};
  const std::uint16_t keys[12] = {1,    1, 0, 2,
                                  1024, 0, 1, form.model,
                                  1025, 0, 1, static_cast<std::uint16_t>(form.is_point ? 2 : 1)};
  TIFFSetField(tiff, 33550, 3, scale);
  TIFFSetField(tiff, 33922, 6, tie);
  TIFFSetField(tiff, 34735, 12, keys);
  TIFFSetField(tiff, 42113, "-9999");
  const double middle = form.is_point ? 0 : 0.5;
  const auto height = [&](std::uint32_t row, std::uint32_t column) {
    if (row >= kRows || column >= kColumns) return -9999.0;
    if (row == 30 && column == 30) return -9999.0;
    return std::round(slope_m(48 - 0.01 * (row + middle), west + 0.01 * (column + middle)));
  };
  constexpr std::uint32_t kTile = 16;
  const std::uint32_t width = form.tiled ? kTile : kColumns;
  const std::uint32_t length = form.tiled ? kTile : 7;
  TIFFSetField(tiff, form.tiled ? TIFFTAG_TILEWIDTH : TIFFTAG_ROWSPERSTRIP,
               form.tiled ? width : length);
  if (form.tiled) TIFFSetField(tiff, TIFFTAG_TILELENGTH, length);
  for (std::uint32_t y = 0; y < kRows; y += length) {
    for (std::uint32_t x = 0; x < kColumns; x += width) {
      std::vector<float> floats;
      std::vector<std::int16_t> shorts;
      for (std::uint32_t i = 0; i < width * length; ++i) {
        floats.push_back(static_cast<float>(height(y + i / width, x + i % width)));
        shorts.push_back(static_cast<std::int16_t>(floats.back()));
      }
      void* const data = form.is_float ? static_cast<void*>(floats.data()) : shorts.data();
      const std::uint32_t rows = form.tiled ? length : std::min(length, kRows - y);
      const tmsize_t size = width * rows * (form.is_float ? 4 : 2);
      if (form.tiled) {
        TIFFWriteEncodedTile(tiff, TIFFComputeTile(tiff, x, y, 0, 0), data, size);
      } else {
        TIFFWriteEncodedStrip(tiff, TIFFComputeStrip(tiff, y, 0), data, size);
      }
    }
  }
  TIFFClose(tiff);
}

TEST(Geotiff, GivesTheHeightsBetweenItsSamples) {
  const TiffForm rows[] = {{"TiledFloat", true, true, false},
                           {"StripsOfInt16", false, false, false},
                           {"PixelIsPoint", false, true, true}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    const cas::test::TemporaryFolder folder;
    const fs::path file = folder.path() / "hill.tif";
    write_geotiff(file, row);
    const ElevationMap map = map_of(file);
    const double middle = row.is_point ? 0 : 0.005;
    const double rounding = row.is_point ? 1e-3 : 0.51;  // of heights to whole metres
    for (const auto& [lat, lon] : {std::pair{47.9, 8.1}, {47.915, 8.333}, {47.65, 8.45}}) {
      EXPECT_NEAR(map.height_m(lat - middle, lon + middle).value(),
                  slope_m(lat - middle, lon + middle), rounding);
    }
    EXPECT_FALSE(map.height_m(47.9, 8.6).has_value());
    // The sample without data is the mean of three corners of each of its cells.
    EXPECT_NEAR(map.height_m(47.7 - middle, 8.3 + middle).value(),
                slope_m(47.7 - middle, 8.3 + middle), 3);
  }
}

TEST(Geotiff, NeighboursMeetWithoutAStep) {
  const cas::test::TemporaryFolder folder;
  write_geotiff(folder.path() / "west.tif", {"", true, true, false}, 8);
  write_geotiff(folder.path() / "east.tif", {"", true, true, false}, 8.5);
  const ElevationMap map = map_of(folder.path());
  for (const double lon : {8.495, 8.498, 8.5, 8.502, 8.505}) {
    EXPECT_NEAR(map.height_m(47.905, lon).value(), slope_m(47.905, lon), 1.01) << lon;
  }
}

TEST(Geotiff, OfAnotherProjectionNamesTheRemedy) {
  const cas::test::TemporaryFolder folder;
  const fs::path file = folder.path() / "utm.tif";
  write_geotiff(file, {"", true, true, false, kProjected, 0});
  EXPECT_THAT(refusal([&] { map_of(file); }), HasSubstr("gdalwarp -t_srs EPSG:4326"));
}

TEST(Geotiff, ThatLiesNowhereOnEarthIsRefused) {
  const cas::test::TemporaryFolder folder;
  const fs::path file = folder.path() / "hill.tif";
  for (const double tie_column : {std::nan(""), 1e300, 1e5}) {
    write_geotiff(file, {.name = "nowhere",
                         .tiled = false,
                         .is_float = false,
                         .is_point = true,
                         .model = kGeographic,
                         .tie_column = tie_column});
    EXPECT_THAT(refusal([&] { map_of(file); }), HasSubstr("its place on Earth is not in degrees"))
        << tie_column;
  }
}

TEST(Geotiff, ThatIsCutIsNamed) {
  const cas::test::TemporaryFolder folder;
  const fs::path file = folder.path() / "hill.tif";
  write_geotiff(file, {"", false, true, false});
  std::string bytes(64, '\0');
  const ElevationMap map = map_of(file);
  std::fstream(file, std::ios::in | std::ios::out | std::ios::binary)
      .seekp(8)
      .write(bytes.data(), 64);
  EXPECT_THAT(refusal([&] { map.height_m(47.995, 8.005); }), HasSubstr("hill.tif: cannot be read"));
}

#endif

}  // namespace
}  // namespace cas::sim
