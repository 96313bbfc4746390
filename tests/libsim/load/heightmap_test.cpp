// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/heightmap.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <vector>

#include "libsim/core/load/world_loader.hpp"
#include "tests/libsim/support/crate.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::sim {
namespace {

using testing::HasSubstr;

using Height = std::function<double(unsigned row, unsigned column)>;  // 0 to 1

/// Writes a greyscale image of 16 bits, or the same in colour with 8.
std::filesystem::path write_png(const std::filesystem::path& file, unsigned width, unsigned height,
                                const Height& value, bool coloured = false) {
  std::FILE* const out = std::fopen(file.c_str(), "wb");
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_init_io(png, out);
  png_set_IHDR(png, info, width, height, coloured ? 8 : 16,
               coloured ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  for (unsigned row = 0; row < height; ++row) {
    std::vector<std::uint8_t> bytes;
    for (unsigned column = 0; column < width; ++column) {
      const double v = value(row, column);
      if (coloured) {
        bytes.insert(bytes.end(), {static_cast<std::uint8_t>(std::lround(255 * v)), 0, 7});
      } else {
        const auto grey = static_cast<unsigned>(std::lround(65535 * v));
        bytes.push_back(static_cast<std::uint8_t>(grey >> 8U));
        bytes.push_back(static_cast<std::uint8_t>(grey & 0xFFU));
      }
    }
    png_write_row(png, bytes.data());
  }
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  std::fclose(out);
  return file;
}

/// White in the first row, black in the last.
double slope(unsigned row, unsigned) { return 1.0 - row / 8.0; }

TEST(Heightmap, FirstRowLiesNorthAndWhiteIsHigh) {
  const cas::test::TemporaryFolder folder;
  const auto file = write_png(folder.path() / "h.png", 5, 9, slope);
  const TriangleMesh mesh = load_heightmap(file, {4, 16, 2}, {10, 20, 1});
  ASSERT_EQ(mesh.vertices.size(), 45u);
  EXPECT_EQ(mesh.triangles.size(), 64u);
  EXPECT_TRUE(mesh.vertices.front().isApprox(Eigen::Vector3d(8, 28, 3)));
  EXPECT_TRUE(mesh.vertices[4].isApprox(Eigen::Vector3d(12, 28, 3)));
  EXPECT_TRUE(mesh.vertices.back().isApprox(Eigen::Vector3d(12, 12, 1)));
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3d n =
        (mesh.vertices[b] - mesh.vertices[a]).cross(mesh.vertices[c] - mesh.vertices[a]);
    EXPECT_GT(n.z(), 0) << "triangles face up";
  }
}

TEST(Heightmap, TheBrightestPixelHasTheWholeHeight) {
  const cas::test::TemporaryFolder folder;
  const auto half = [](unsigned row, unsigned column) { return 0.5 * slope(row, column); };
  for (const bool coloured : {false, true}) {
    const auto file = write_png(folder.path() / "h.png", 3, 9, half, coloured);
    const TriangleMesh mesh = load_heightmap(file, {4, 16, 2}, {0, 0, 1});
    EXPECT_NEAR(mesh.vertices.front().z(), 3, 1e-12);
    EXPECT_NEAR(mesh.vertices[12].z(), 2, 0.02) << "half of it";
    EXPECT_NEAR(mesh.vertices.back().z(), 1, 1e-12);
  }
  const auto black = write_png(folder.path() / "b.png", 3, 3, [](unsigned, unsigned) { return 0; });
  EXPECT_EQ(load_heightmap(black, {4, 16, 2}, {0, 0, 1}).vertices[4].z(), 1);
}

TEST(Heightmap, ReadsTheRedOfAColouredImage) {
  const cas::test::TemporaryFolder folder;
  const auto file = write_png(folder.path() / "h.png", 3, 9, slope, true);
  EXPECT_NEAR(load_heightmap(file, {1, 1, 1}, {0, 0, 0}).vertices[3].z(), 1 - 1 / 8.0, 1 / 255.0);
}

TEST(Heightmap, RefusesWhatIsNoImageAndWhatIsTooLarge) {
  const cas::test::TemporaryFolder folder;
  const auto text = folder.write("text.png", "no image");
  const auto refusal = [](const std::filesystem::path& file) {
    return cas::test::refusal([&] { load_heightmap(file, {1, 1, 1}, {0, 0, 0}); });
  };
  EXPECT_THAT(refusal(text), HasSubstr("text.png: is no PNG image"));
  EXPECT_THAT(refusal(folder.path() / "none.png"), HasSubstr("cannot be read"));
  const auto flat = [](unsigned, unsigned) { return 0.0; };
  EXPECT_THAT(refusal(write_png(folder.path() / "thin.png", 1, 9, flat)),
              HasSubstr("2 to 1025 pixels along each edge, this one 1 x 9"));
  const auto whole = write_png(folder.path() / "whole.png", 65, 65, slope);
  std::filesystem::resize_file(whole, std::filesystem::file_size(whole) / 2);
  EXPECT_THAT(refusal(whole), HasSubstr("whole.png: the PNG file is cut: it ends behind "));
  std::filesystem::resize_file(whole, 20);
  EXPECT_THAT(refusal(whole), HasSubstr("behind 20 bytes, and 0 whole rows of pixels"));
}

/// A world of heightmaps with these heights, all of one image.
std::string world_of(const std::vector<double>& heights) {
  std::string text = "<sdf version='1.9'><world name='w'>";
  for (std::size_t i = 0; i < heights.size(); ++i) {
    text += "<model name='m" + std::to_string(i) +
            "'><static>true</static><link name='l'><collision name='c'><geometry><heightmap><uri>"
            "h.png</uri><size>32 32 " +
            std::to_string(heights[i]) +
            "</size></heightmap></geometry></collision></link></model>";
  }
  return text + "</world></sdf>";
}

TEST(Heightmap, OfManyModelsIsLoadedOnce) {
  const cas::test::TemporaryFolder folder;
  write_png(folder.path() / "h.png", 3, 9, slope);
  const WorldModel model = load_sdf_world(folder.write("w.sdf", world_of({4, 4, 5})), {});
  ASSERT_EQ(model.statics.size(), 3u);
  const auto triangles = [&](std::size_t i) {
    return std::get<Mesh>(model.statics[i].geometry).triangles;
  };
  EXPECT_EQ(triangles(0), triangles(1));
  EXPECT_NE(triangles(0), triangles(2)) << "of another height";
}

TEST(Heightmap, RefusesAWorldOfMoreTrianglesThanAreSimulated) {
  const cas::test::TemporaryFolder folder;
  write_png(folder.path() / "h.png", 1025, 1025, [](unsigned, unsigned) { return 0.0; });
  const auto refusal = [&](const std::vector<double>& heights) {
    return cas::test::refusal(
        [&] { load_sdf_world(folder.write("w.sdf", world_of(heights)), {}); });
  };
  EXPECT_EQ(refusal({1, 2, 2, 2}), "") << "two that differ";
  EXPECT_THAT(refusal({1, 2, 3}),
              HasSubstr("the world has 6291456 triangles, and at most 5000000 are simulated"));
}

TEST(Heightmap, OfAWorldFileCarriesAVehicle) {
  const cas::test::TemporaryFolder folder;
  // Flat at half the height but for a hill in the north.
  write_png(folder.path() / "h.png", 65, 65,
            [](unsigned row, unsigned) { return row < 16 ? 1.0 : 32768 / 65535.0; });
  const auto file = folder.write(
      "w.sdf",
      "<sdf version='1.9'><world name='w'><model name='m'><static>true</static><link name='l'>"
      "<collision name='c'><geometry><heightmap><uri>h.png</uri><size>32 32 4</size>"
      "<pos>0 0 -2</pos></heightmap></geometry></collision></link></model></world></sdf>");
  const WorldModel model = load_sdf_world(file, {});
  ASSERT_EQ(model.statics.size(), 1u);
  const auto world = test::make_world(model);
  world->add_vehicle(test::crate(), {.x_m = 0.3, .z_m = 0.1, .yaw_deg = 20});
  world->add_vehicle(test::crate(), {.x_m = 0.3, .y_m = 14, .z_m = 2.1});
  world->start();
  for (int i = 0; i < 2000; ++i) world->advance(1e-3);
  EXPECT_NEAR(world->state(VehicleId{0}).p_WB.z(), 0.05, 3e-3);
  EXPECT_NEAR(world->state(VehicleId{1}).p_WB.z(), 2.05, 3e-3);
  EXPECT_EQ(world->state(VehicleId{0}).v_WB.norm(), 0.0) << "at rest";
}

}  // namespace
}  // namespace cas::sim
