// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/lidar/cloud_file.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace cas::sim {
namespace {

static_assert(std::endian::native == std::endian::little, "a point is written as it is in memory");

constexpr std::size_t kPointBytes = 5 * sizeof(float) + sizeof(std::uint16_t);

/// "x y z qw qx qy qz" of S in W when the scan began.
std::string viewpoint(const LidarScan& scan) {
  const Eigen::Vector3d& p = scan.p_WS;
  const Eigen::Quaterniond& q = scan.q_WS;
  return fmt::format("{:.6f} {:.6f} {:.6f} {:.9f} {:.9f} {:.9f} {:.9f}", p.x(), p.y(), p.z(), q.w(),
                     q.x(), q.y(), q.z());
}

std::string pcd_head(const std::string& count, const std::string& viewpoint) {
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n"
         "FIELDS x y z intensity t ring\nSIZE 4 4 4 4 4 2\nTYPE F F F F F U\n"
         "COUNT 1 1 1 1 1 1\nWIDTH " +
         count + "\nHEIGHT 1\nVIEWPOINT " + viewpoint + "\nPOINTS " + count + "\nDATA binary\n";
}

std::string ply_head(const std::string& count, const std::string& viewpoint) {
  return "ply\nformat binary_little_endian 1.0\ncomment viewpoint " + viewpoint +
         "\nelement vertex " + count +
         "\nproperty float x\nproperty float y\nproperty float z\nproperty float intensity\n"
         "property float t\nproperty ushort ring\nend_header\n";
}

template <class T>
void append(std::string& text, const T& value) {
  char bytes[sizeof(T)];
  std::memcpy(bytes, &value, sizeof(T));
  text.append(bytes, sizeof(T));
}

}  // namespace

std::string cloud_text(const LidarScan& scan, base::CloudForm form) {
  const std::string count = std::to_string(scan.points.size());
  const std::string place = viewpoint(scan);
  std::string text =
      form == base::CloudForm::kPcd ? pcd_head(count, place) : ply_head(count, place);
  text.reserve(text.size() + scan.points.size() * kPointBytes);
  for (const CloudPoint& point : scan.points) {
    for (const float value : point.p_S) append(text, value);
    append(text, point.cosine);
    append(text, point.time_s);
    append(text, point.ring);
  }
  return text;
}

std::string depth_text(const LidarScan& scan, const DepthPicture& picture) {
  constexpr double kMillimetres = 1000;
  constexpr double kMost_mm = 65535;
  std::string text = fmt::format("P5\n# viewpoint {}\n{} {}\n65535\n", viewpoint(scan),
                                 picture.width, picture.height);
  const std::size_t head = text.size();
  text.resize(head + 2 * picture.pixels());
  for (const CloudPoint& point : scan.points) {
    const auto pixel = picture.pixel_of(point.p_S.cast<double>());
    if (!pixel) continue;
    const auto depth_mm = static_cast<std::uint16_t>(
        std::min(std::round(kMillimetres * static_cast<double>(point.p_S.x())), kMost_mm));
    text[head + 2 * *pixel] = static_cast<char>(depth_mm >> 8U);  // the format's order
    text[head + 2 * *pixel + 1] = static_cast<char>(depth_mm & 0xFFU);
  }
  return text;
}

}  // namespace cas::sim
