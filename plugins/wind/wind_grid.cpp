// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/wind/wind_grid.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>

#include "plugins/common/number_csv.hpp"

namespace cas::sim {
namespace {

constexpr std::size_t kMostBytes = std::size_t{256} << 20U;
constexpr const char* kHeader = "x_m,y_m,z_m,u_m_s,v_m_s,w_m_s";

struct Row {
  Eigen::Vector3d place;
  Eigen::Vector3d wind;
};

std::vector<Row> read_rows(NumberCsv& csv) {
  std::vector<Row> rows;
  for (std::array<double, 6> v{}; csv.next(v);) {
    rows.push_back({{v[0], v[1], v[2]}, {v[3], v[4], v[5]}});
  }
  if (rows.empty()) csv.fail("has no place");
  return rows;
}

/// The two neighbours of a value on an axis, and the share of the upper one.
struct Between {
  std::size_t low;
  std::size_t high;
  double share;

  Between(const std::vector<double>& axis, double value) {
    const auto above = std::upper_bound(axis.begin(), axis.end(), value);
    high = std::min(static_cast<std::size_t>(above - axis.begin()), axis.size() - 1);
    low = high == 0 || axis[high] <= value ? high : high - 1;
    share = low == high ? 0 : (value - axis[low]) / (axis[high] - axis[low]);
  }
};

}  // namespace

WindGrid WindGrid::load(const std::filesystem::path& file) {
  NumberCsv csv(file, "wind grid", kMostBytes, kHeader);
  const std::vector<Row> rows = read_rows(csv);
  WindGrid grid;
  std::size_t places = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    std::vector<double>& axis = grid.axes_[a];
    for (const Row& row : rows) axis.push_back(row.place[static_cast<Eigen::Index>(a)]);
    std::sort(axis.begin(), axis.end());
    axis.erase(std::unique(axis.begin(), axis.end()), axis.end());
    places *= axis.size();
  }
  if (places != rows.size()) {
    csv.fail(fmt::format("has {} places, and the {} values of x, {} of y and {} of z make {}",
                         rows.size(), grid.axes_[0].size(), grid.axes_[1].size(),
                         grid.axes_[2].size(), places));
  }
  grid.wind_W_.resize(places);
  std::vector<bool> filled(places, false);
  for (const Row& row : rows) {
    std::array<std::size_t, 3> cell{};
    for (std::size_t a = 0; a < 3; ++a) {
      const std::vector<double>& axis = grid.axes_[a];
      cell[a] = static_cast<std::size_t>(
          std::lower_bound(axis.begin(), axis.end(), row.place[static_cast<Eigen::Index>(a)]) -
          axis.begin());
    }
    const std::size_t at = grid.index(cell);
    if (filled[at]) csv.fail("names a place twice");
    filled[at] = true;
    grid.wind_W_[at] = row.wind;
  }
  return grid;
}

Eigen::Vector3d WindGrid::at(const Eigen::Vector3d& p_W) const {
  const std::array<Between, 3> sides{Between(axes_[0], p_W.x()), Between(axes_[1], p_W.y()),
                                     Between(axes_[2], p_W.z())};
  Eigen::Vector3d wind = Eigen::Vector3d::Zero();
  for (unsigned corner = 0; corner < 8; ++corner) {
    std::array<std::size_t, 3> cell{};
    double weight = 1;
    for (unsigned a = 0; a < 3; ++a) {
      const bool upper = (corner >> a & 1U) != 0;
      cell[a] = upper ? sides[a].high : sides[a].low;
      weight *= upper ? sides[a].share : 1 - sides[a].share;
    }
    if (weight > 0) wind += weight * wind_W_[index(cell)];
  }
  return wind;
}

std::size_t WindGrid::index(const std::array<std::size_t, 3>& cell) const {
  return cell[0] + axes_[0].size() * (cell[1] + axes_[1].size() * cell[2]);
}

}  // namespace cas::sim
