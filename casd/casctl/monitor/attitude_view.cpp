// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/attitude_view.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "base/angles.hpp"
#include "casd/casctl/monitor/dot_canvas.hpp"
#include "casd/casctl/monitor/plot.hpp"
#include "casd/casctl/session/text.hpp"

namespace cas::casctl {
namespace {

/// A character is about twice as high as wide.
constexpr double kCellAspect = 0.5;

double full_circle(double degrees) {
  const double rest = std::fmod(degrees, 360);
  return rest < 0 ? rest + 360 : rest;
}

/// "N", "030", ...
std::string heading_text(int degrees) {
  switch (degrees) {
    case 0:
      return "N";
    case 90:
      return "E";
    case 180:
      return "S";
    case 270:
      return "W";
    default:
      return fmt::format("{:03}", degrees % 1000);
  }
}

std::string arrow(std::optional<double> yaw_deg, bool unicode) {
  constexpr const char* kArrows[] = {"↑", "↗", "→", "↘", "↓", "↙", "←", "↖"};
  constexpr const char* kAscii[] = {"^", "/", ">", "\\", "v", "/", "<", "\\"};
  if (!yaw_deg) return "o";
  const auto eighth = static_cast<std::size_t>(std::lround(full_circle(*yaw_deg) / 45)) % 8;
  return unicode ? kArrows[eighth] : kAscii[eighth];
}

/// The rectangle of a drawing, in metres, with the same scale along both axes.
struct Ground {
  Place middle;
  double metres_a_dot = 1;
};

Ground ground_of(const std::deque<Place>& trail, int width, int height) {
  constexpr double kLeastHalf_m = 2;
  Place low{0, 0};  // the origin is always on it
  Place high{0, 0};
  for (const Place& place : trail) {
    low = {std::min(low.north_m, place.north_m), std::min(low.east_m, place.east_m)};
    high = {std::max(high.north_m, place.north_m), std::max(high.east_m, place.east_m)};
  }
  constexpr double kMargin = 1.1;
  const double half_north = std::max((high.north_m - low.north_m) / 2 * kMargin, kLeastHalf_m);
  const double half_east = std::max((high.east_m - low.east_m) / 2 * kMargin, kLeastHalf_m);
  return {
      {(low.north_m + high.north_m) / 2, (low.east_m + high.east_m) / 2},
      std::max(2 * half_north / std::max(height - 1, 1), 2 * half_east / std::max(width - 1, 1))};
}

}  // namespace

double degrees_a_line(std::size_t rows) {
  for (const double degrees : {2.0, 5.0, 10.0}) {
    if (degrees * static_cast<double>(rows) >= 40) return degrees;
  }
  return 15;
}

Block horizon(const Attitude& attitude, std::size_t width, std::size_t rows, bool unicode) {
  const double roll = base::radians(attitude.roll_deg);
  const double line_deg = degrees_a_line(rows);
  const std::size_t middle_column = width / 2;
  const std::size_t middle_row = rows / 2;
  const auto middle_x = static_cast<double>(middle_column);
  const auto middle_y = static_cast<double>(middle_row);
  const char* ground = unicode ? "░" : ":";
  const char* edge = unicode ? "─" : "-";
  const std::string mark = unicode ? "━━╋━━" : "--+--";
  Block block;
  for (std::size_t y = 0; y < rows; ++y) {
    std::string text;
    for (std::size_t x = 0; x < width; ++x) {
      const double across = (static_cast<double>(x) - middle_x) * kCellAspect;
      const double up = middle_y - static_cast<double>(y);
      const double elevation =
          attitude.pitch_deg + line_deg * (up * std::cos(roll) - across * std::sin(roll));
      text += std::abs(elevation) <= line_deg / 2 ? edge : elevation < 0 ? ground : " ";
    }
    ScreenLine line;
    if (y == rows / 2 && width > 9) {
      // The mark is in the middle, with the view at both sides of it.
      const auto part = [&text](std::size_t from, std::size_t count) {
        std::string piece;
        std::size_t at = 0;
        for (const char c : text) {
          if ((static_cast<unsigned char>(c) & 0xC0U) != 0x80U) ++at;
          if (at > from && at <= from + count) piece += c;
        }
        return piece;
      };
      const std::size_t start = width / 2 - 2;
      line.add(part(0, start)).add(mark, Style::kGood).add(part(start + 5, width - start - 5));
    } else {
      line.add(text);
    }
    block.push_back(line);
  }
  return block;
}

Block heading_tape(double yaw_deg, std::size_t width, bool unicode) {
  constexpr double kWide_deg = 120;
  std::string text(width, ' ');
  const double degrees_a_column = kWide_deg / static_cast<double>(width);
  for (int heading = 0; heading < 360; heading += 30) {
    double off = full_circle(heading - yaw_deg);
    if (off > 180) off -= 360;
    const std::string label = heading_text(heading);
    const auto at = static_cast<long>(width / 2) + std::lround(off / degrees_a_column) -
                    static_cast<long>(label.size() / 2);
    if (at < 0 || at + static_cast<long>(label.size()) > static_cast<long>(width)) continue;
    text.replace(static_cast<std::size_t>(at), label.size(), label);
  }
  const std::string pointer = std::string(width / 2, ' ') + (unicode ? "▲" : "^");
  return {ScreenLine(text), ScreenLine(left(pointer, width), Style::kGood)};
}

Block top_view(const std::deque<Place>& trail, std::optional<double> yaw_deg, std::size_t width,
               std::size_t rows, bool unicode) {
  constexpr std::size_t kLabels = 11;  // "N -1234 m |"
  DotCanvas canvas(width - std::min(width, kLabels), rows > 1 ? rows - 1 : 0);
  const Ground ground = ground_of(trail, canvas.width(), canvas.height());
  const auto x_of = [&](const Place& place) {
    return static_cast<int>(std::lround(
        (place.east_m - ground.middle.east_m) / ground.metres_a_dot + (canvas.width() - 1) / 2.0));
  };
  const auto y_of = [&](const Place& place) {
    return static_cast<int>(
        std::lround((canvas.height() - 1) / 2.0 -
                    (place.north_m - ground.middle.north_m) / ground.metres_a_dot));
  };
  for (std::size_t i = 1; i < trail.size(); ++i) {
    canvas.line(x_of(trail[i - 1]), y_of(trail[i - 1]), x_of(trail[i]), y_of(trail[i]));
  }
  canvas.mark(x_of({}), y_of({}), "+");
  if (!trail.empty()) canvas.mark(x_of(trail.back()), y_of(trail.back()), arrow(yaw_deg, unicode));
  const double half_north = canvas.height() / 2.0 * ground.metres_a_dot;
  const double half_east = canvas.width() / 2.0 * ground.metres_a_dot;
  const auto label = [&](const char* axis, double value) {
    const int decimals = std::max(half_north, half_east) < 10 ? 1 : 0;
    const bool is_zero = std::abs(value) < 0.5 * std::pow(10, -decimals);  // and has no sign
    return std::string(axis) + " " + fixed(is_zero ? 0 : value, decimals) + " m";
  };
  return framed(
      canvas.lines(unicode), right(label("N", ground.middle.north_m + half_north), kLabels - 2),
      label("N", ground.middle.north_m - half_north), label("E", ground.middle.east_m - half_east),
      label("E", ground.middle.east_m + half_east), unicode);
}

}  // namespace cas::casctl
