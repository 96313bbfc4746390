// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/stl.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <utility>

#include "base/byte_order_mark.hpp"
#include "base/error.hpp"
#include "base/number_text.hpp"
#include "base/text.hpp"

namespace cas::sim {

namespace {

static_assert(std::endian::native == std::endian::little, "STL is read as it stands in memory");

using Corners = std::array<Eigen::Vector3d, 3>;

void add_triangle(TriangleMesh& mesh, const Corners& corners) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), corners.begin(), corners.end());
  mesh.triangles.push_back({first, first + 1, first + 2});
}

// Binary STL: 80 bytes, a count, then per triangle 12 floats (normal, three corners) and 2 bytes.
constexpr std::size_t kHeader = 84;
constexpr std::size_t kTriangle = 50;

/// Bytes of a binary file by its header.
std::size_t promised_bytes(std::string_view bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, sizeof(count));
  return kHeader + kTriangle * std::size_t{count};
}

/// The header of a binary file may begin with "solid", too: its size tells, then its bytes.
bool is_text(std::string_view bytes) {
  if (bytes.size() >= kHeader && promised_bytes(bytes) == bytes.size()) return false;
  std::string_view rest = base::without_byte_order_mark(bytes);
  const std::string first = base::lower(base::next_word(rest));
  if (first != "solid" && first != "facet") return false;
  return bytes.substr(0, 2 * kHeader).find('\0') == bytes.npos;
}

TriangleMesh parse_binary(std::string_view bytes, const std::string& file,
                          const MeshOptions& options) {
  const std::string has = fmt::format("; it has {} bytes", bytes.size());
  if (bytes.size() < kHeader) {
    throw base::ConfigError(fmt::format(
        "{}: is neither text STL nor binary STL, whose header has {} bytes{}: is it cut?", file,
        kHeader, has));
  }
  const std::size_t promised = promised_bytes(bytes);
  const std::size_t count = (promised - kHeader) / kTriangle;
  const std::string header =
      fmt::format("its header promises {} triangles, {} bytes{}", count, promised, has);
  if (promised > bytes.size()) {
    throw base::ConfigError(fmt::format("{}: the STL file is cut: {} and ends within triangle {}",
                                        file, header, (bytes.size() - kHeader) / kTriangle + 1));
  }
  if (promised < bytes.size()) {
    if (count == 0)
      throw base::ConfigError(file + ": no triangle is read of the STL file: " + header);
    options.warn(file + ": " + header + ": those behind the triangles are left out");
  }
  TriangleMesh mesh;
  for (std::size_t i = 0; i < count; ++i) {
    std::array<float, 12> values;
    std::memcpy(values.data(), bytes.data() + kHeader + i * kTriangle, sizeof(values));
    Corners corners;
    for (std::size_t c = 0; c < 3; ++c) {
      corners[c] = Eigen::Vector3f(&values[3 + 3 * c]).cast<double>();
      if (!corners[c].allFinite()) {
        throw base::ConfigError(
            fmt::format("{}: triangle {} has a corner that is not finite", file, i + 1));
      }
    }
    add_triangle(mesh, corners);
  }
  return mesh;
}

/// Reads text word by word.
class TextStl {
 public:
  TextStl(std::string_view text, const std::string& file, const MeshOptions& options)
      : text_(text), rest_(base::without_byte_order_mark(text)), file_(file), options_(options) {}

  TriangleMesh run() {
    for (std::string word = next(); !word.empty(); word = next()) take(word);
    if (in_facet_) fail("the STL file is cut: it ends within a facet");
    if (in_solid_ && mesh_.triangles.empty()) {
      fail("the STL file is cut: it has neither a facet nor an 'endsolid'");
    }
    if (in_solid_) options_.warn(place() + ": has no 'endsolid': the STL file may be cut here");
    return std::move(mesh_);
  }

 private:
  void take(const std::string& word) {
    if (word == "solid" || word == "endsolid") {
      if (in_facet_) fail("'" + word + "' within a facet");
      in_solid_ = word == "solid";
      rest_.remove_prefix(std::min(rest_.find_first_of("\r\n"), rest_.size()));  // a name
    } else if (word == "facet") {
      if (in_facet_) fail("a facet within a facet");
      in_facet_ = true;
      corner_ = 0;
      of_normal_ = 0;
    } else if (word == "vertex") {
      take_vertex();
    } else if (word == "endfacet") {
      if (!in_facet_ || corner_ != 3) {
        fail(fmt::format("a facet has three vertices, this one {}", corner_));
      }
      add_triangle(mesh_, corners_);
      in_facet_ = false;
    } else if (word == "normal") {
      of_normal_ = 3;
    } else if (in_facet_ && word != "outer" && word != "loop" && word != "endloop") {
      if (of_normal_ > 0) {
        --of_normal_;  // right or wrong: the corners make the facet
      } else if (!std::exchange(has_other_words_, true)) {
        options_.warn(place() + ": '" + word.substr(0, 20) +
                      "' is left out: of a facet three vertices of three numbers are read");
      }
    }
  }

  void take_vertex() {
    if (!in_facet_) fail("a vertex outside of a facet");
    if (corner_ == 3) fail("a facet has three vertices, this one more");
    for (double& coordinate : corners_[corner_]) {
      const std::string word = next();
      if (word.empty()) fail("the STL file is cut: it ends within a vertex");
      const auto value = base::number_of<double>(word);
      if (!value) fail(base::no_number(word));
      coordinate = *value;
    }
    ++corner_;
  }

  /// In small letters.
  std::string next() { return base::lower(base::next_word(rest_)); }

  std::string place() const {
    const std::string_view read = text_.substr(0, text_.size() - rest_.size());
    return fmt::format("{}:{}", file_, 1 + std::count(read.begin(), read.end(), '\n'));
  }
  [[noreturn]] void fail(const std::string& sentence) const {
    throw base::ConfigError(place() + ": " + sentence);
  }

  std::string_view text_;
  std::string_view rest_;  // of text_
  const std::string& file_;
  const MeshOptions& options_;
  TriangleMesh mesh_;
  Corners corners_;
  std::size_t corner_ = 0;
  int of_normal_ = 0;  // numbers of the facet's normal that are still to come
  bool in_solid_ = false;
  bool in_facet_ = false;
  bool has_other_words_ = false;
};

}  // namespace

TriangleMesh parse_stl(std::string_view bytes, const std::string& file,
                       const MeshOptions& options) {
  return is_text(bytes) ? TextStl(bytes, file, options).run() : parse_binary(bytes, file, options);
}

}  // namespace cas::sim
