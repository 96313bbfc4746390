// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/heightmap.hpp"

#include <png.h>

#include <fmt/format.h>
#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "base/error.hpp"
#include "base/read_file.hpp"

namespace cas::sim {

namespace {

/// A file of the largest image that is not compressed, with room for texts in it.
constexpr std::size_t kMostHeightmapBytes = 32U << 20U;

/// Brightness of the pixels, row by row.
struct GreyImage {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<double> values;
};

/// libpng's reader for one file; its errors become exceptions.
class PngReader {
 public:
  PngReader(std::string_view bytes, const std::string& file)
      : name_(file), size_(bytes.size()), rest_(bytes) {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, this, &on_error, &on_warning);
    info_ = png_create_info_struct(png_);
    png_set_read_fn(png_, this, &on_read);
  }
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  GreyImage read() {
    png_read_info(png_, info_);
    GreyImage image{.width = png_get_image_width(png_, info_),
                    .height = png_get_image_height(png_, info_),
                    .values = {}};
    require_size(image);
    png_set_expand(png_);  // palettes and fewer than 8 bits
    const int passes = png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    const std::size_t row_bytes = png_get_rowbytes(png_, info_);
    std::vector<std::uint8_t> bytes(row_bytes * image.height);
    for (int pass = 0; pass < passes; ++pass) {
      for (std::uint32_t row = 0; row < image.height; ++row) {
        whole_rows_ = row;
        png_read_row(png_, &bytes[row * row_bytes], nullptr);
      }
    }
    take_first_channel(bytes, row_bytes, image);
    return image;
  }

 private:
  void require_size(const GreyImage& image) const {
    const auto fits = [](std::uint32_t n) { return n >= 2 && n <= kLargestHeightmap; };
    if (fits(image.width) && fits(image.height)) return;
    throw base::ConfigError(
        fmt::format("{}: a heightmap has 2 to {} pixels along each edge, this one {} x {}", name_,
                    kLargestHeightmap, image.width, image.height));
  }

  void take_first_channel(const std::vector<std::uint8_t>& bytes, std::size_t row_bytes,
                          GreyImage& image) const {
    const std::size_t pixel_bytes = row_bytes / image.width;
    const bool wide = png_get_bit_depth(png_, info_) == 16;
    image.values.reserve(std::size_t{image.width} * image.height);
    for (std::size_t row = 0; row < image.height; ++row) {
      for (std::size_t column = 0; column < image.width; ++column) {
        const std::uint8_t* const pixel = &bytes[row * row_bytes + column * pixel_bytes];
        image.values.push_back(wide ? 256.0 * pixel[0] + pixel[1] : pixel[0]);
      }
    }
  }

  [[noreturn]] static void on_error(png_structp png, png_const_charp text) {
    const auto* const self = static_cast<const PngReader*>(png_get_error_ptr(png));
    throw base::ConfigError(self->name_ + ": is no PNG image: " + text);
  }
  static void on_warning(png_structp, png_const_charp) {}
  static void on_read(png_structp png, png_bytep out, png_size_t size) {
    auto* const self = static_cast<PngReader*>(png_get_io_ptr(png));
    if (size > self->rest_.size()) {
      throw base::ConfigError(fmt::format(
          "{}: the PNG file is cut: it ends behind {} bytes, and {} whole rows of pixels",
          self->name_, self->size_, self->whole_rows_));
    }
    std::memcpy(out, self->rest_.data(), size);
    self->rest_.remove_prefix(size);
  }

  const std::string& name_;
  std::size_t size_;
  std::string_view rest_;  // still to be read
  std::uint32_t whole_rows_ = 0;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

}  // namespace

TriangleMesh parse_heightmap(std::string_view bytes, const std::string& file,
                             const Eigen::Vector3d& size_m, const Eigen::Vector3d& offset_m) {
  const GreyImage image = PngReader(bytes, file).read();
  const double brightest = std::ranges::max(image.values);
  const double height_m = brightest > 0 ? size_m.z() / brightest : 0;  // of one step of brightness
  const Eigen::Vector3d first(-0.5 * size_m.x(), 0.5 * size_m.y(), 0);
  const Eigen::Vector3d step(size_m.x() / (image.width - 1), -size_m.y() / (image.height - 1), 0);
  TriangleMesh mesh;
  mesh.vertices.reserve(image.values.size());
  mesh.triangles.reserve(2 * image.values.size());
  for (std::uint32_t row = 0; row < image.height; ++row) {
    for (std::uint32_t column = 0; column < image.width; ++column) {
      const std::uint32_t a = row * image.width + column;
      const Eigen::Vector3d place(column * step.x(), row * step.y(), height_m * image.values[a]);
      mesh.vertices.push_back(offset_m + first + place);
      if (row == 0 || column == 0) continue;
      const std::uint32_t left = a - 1;
      const std::uint32_t above = a - image.width;
      mesh.triangles.push_back({left, a, above});  // counter-clockwise from above
      mesh.triangles.push_back({left, above, above - 1});
    }
  }
  return mesh;
}

TriangleMesh load_heightmap(const std::filesystem::path& file, const Eigen::Vector3d& size_m,
                            const Eigen::Vector3d& offset_m) {
  return parse_heightmap(base::read_foreign_file(file, "heightmap", kMostHeightmapBytes),
                         file.string(), size_m, offset_m);
}

}  // namespace cas::sim
