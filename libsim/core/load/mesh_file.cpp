// SPDX-License-Identifier: BSD-3-Clause
#include "libsim/core/load/mesh_file.hpp"

#include <algorithm>
#include <bit>
#include <cctype>
#include <cstring>
#include <limits>
#include <sstream>
#include <string>

#include "base/byte_order_mark.hpp"
#include "base/error.hpp"
#include "base/read_file.hpp"
#include "libsim/core/load/collada.hpp"

namespace cas::sim {

namespace {

static_assert(std::endian::native == std::endian::little, "STL is read as it stands in memory");

/// Five million triangles of binary STL.
constexpr std::size_t kMostBytes = 256U << 20U;

[[noreturn]] void fail(const std::filesystem::path& file, const std::string& sentence) {
  throw base::ConfigError(file.string() + ": " + sentence);
}

void add_triangle(TriangleMesh& mesh, const std::array<Eigen::Vector3d, 3>& corners) {
  const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), corners.begin(), corners.end());
  mesh.triangles.push_back({first, first + 1, first + 2});
}

// Binary STL: 80 bytes, a count, then per triangle 12 floats (normal, three corners) and 2 bytes.
constexpr std::size_t kStlHeader = 84;
constexpr std::size_t kStlTriangle = 50;

std::uint32_t stl_count(const std::string& bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + 80, sizeof(count));
  return count;
}

bool is_binary_stl(const std::string& bytes) {
  return bytes.size() >= kStlHeader &&
         bytes.size() == kStlHeader + kStlTriangle * std::size_t{stl_count(bytes)};
}

TriangleMesh parse_binary_stl(const std::string& bytes) {
  TriangleMesh mesh;
  for (std::size_t i = 0; i < stl_count(bytes); ++i) {
    std::array<float, 12> values;
    std::memcpy(values.data(), bytes.data() + kStlHeader + i * kStlTriangle, sizeof(values));
    std::array<Eigen::Vector3d, 3> corners;
    for (std::size_t c = 0; c < 3; ++c) {
      corners[c] = Eigen::Vector3f(&values[3 + 3 * c]).cast<double>();
    }
    add_triangle(mesh, corners);
  }
  return mesh;
}

TriangleMesh parse_text_stl(const std::filesystem::path& file, const std::string& bytes) {
  TriangleMesh mesh;
  std::istringstream in(bytes);
  std::array<Eigen::Vector3d, 3> corners;
  std::size_t corner = 0;
  for (std::string word; in >> word;) {
    if (word != "vertex") continue;
    Eigen::Vector3d& v = corners[corner];
    if (!(in >> v.x() >> v.y() >> v.z())) fail(file, "is neither binary nor text STL");
    if (++corner < 3) continue;
    add_triangle(mesh, corners);
    corner = 0;
  }
  return mesh;
}

/// "7", "7/1/3" or "-1": vertex number, counted from 1 or from the end.
std::uint32_t obj_index(const std::filesystem::path& file, const std::string& word,
                        std::size_t vertices) {
  const long number = std::strtol(word.c_str(), nullptr, 10);
  const long index = number < 0 ? static_cast<long>(vertices) + number : number - 1;
  if (index < 0 || index >= static_cast<long>(vertices))
    fail(file, "face names no vertex: " + word);
  return static_cast<std::uint32_t>(index);
}

TriangleMesh parse_obj(const std::filesystem::path& file, const std::string& bytes) {
  TriangleMesh mesh;
  std::istringstream lines{std::string(base::without_byte_order_mark(bytes))};
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word;
    words >> word;
    if (word == "v") {
      Eigen::Vector3d v;
      if (!(words >> v.x() >> v.y() >> v.z())) fail(file, "vertex without three numbers");
      mesh.vertices.push_back(v);
    } else if (word == "f") {
      std::vector<std::uint32_t> face;
      while (words >> word) face.push_back(obj_index(file, word, mesh.vertices.size()));
      for (std::size_t i = 2; i < face.size(); ++i) {
        mesh.triangles.push_back({face[0], face[i - 1], face[i]});
      }
    }
  }
  return mesh;
}

}  // namespace

TriangleMesh load_mesh(const std::filesystem::path& file, const Eigen::Vector3d& scale) {
  const std::string bytes = base::read_foreign_file(file, "mesh", kMostBytes);
  std::string kind = file.extension().string();
  std::transform(kind.begin(), kind.end(), kind.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  TriangleMesh mesh;
  if (kind == ".stl") {
    mesh = is_binary_stl(bytes) ? parse_binary_stl(bytes) : parse_text_stl(file, bytes);
  } else if (kind == ".obj") {
    mesh = parse_obj(file, bytes);
  } else if (kind == ".dae") {
    mesh = parse_collada(bytes, file.string());
  } else {
    fail(file, "mesh format is not supported; convert it to STL, OBJ or COLLADA");
  }
  if (mesh.triangles.empty()) fail(file, "mesh has no triangle");
  for (Eigen::Vector3d& v : mesh.vertices) {
    v = v.cwiseProduct(scale);
    if (!v.allFinite()) fail(file, "mesh has a vertex that is not finite");
  }
  return mesh;
}

Box bounding_box(const TriangleMesh& mesh, Eigen::Vector3d& centre) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector3d high = -low;
  for (const Eigen::Vector3d& v : mesh.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  centre = 0.5 * (low + high);
  return Box{high - low};
}

}  // namespace cas::sim
