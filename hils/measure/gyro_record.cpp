// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/gyro_record.hpp"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <optional>
#include <string>

#include "base/error.hpp"
#include "hils/measure/csv_row.hpp"

namespace cas::hils {

std::vector<GyroSample> read_gyro(const std::filesystem::path& file) {
  constexpr std::size_t kLeastColumns = 4;  // time, then the gyro
  std::vector<GyroSample> samples;
  std::ifstream in(file);
  std::string line;
  next_line(in, line, file);  // header
  for (int number = 2; next_line(in, line, file); ++number) {
    const std::optional<std::vector<double>> row = parse_csv_row(line);
    if (!row || row->size() < kLeastColumns) {
      throw base::ConfigError(fmt::format("{}:{}: not a row of imu.csv", file.string(), number));
    }
    samples.push_back({.time_us = std::llround(row->front() * 1e6),
                       .rate_rad_s = {(*row)[1], (*row)[2], (*row)[3]}});
  }
  return samples;
}

}  // namespace cas::hils
