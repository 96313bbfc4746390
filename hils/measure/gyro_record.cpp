// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/gyro_record.hpp"

#include <cmath>
#include <cstddef>

#include "hils/measure/csv_file.hpp"

namespace cas::hils {

std::vector<GyroSample> read_gyro(const std::filesystem::path& file) {
  constexpr std::size_t kLeastColumns = 4;  // time, then the gyro
  std::vector<GyroSample> samples;
  CsvFile csv(file);
  for (auto row = csv.next(kLeastColumns); !row.empty(); row = csv.next(kLeastColumns)) {
    samples.push_back(
        {.time_us = std::llround(row[0] * 1e6), .rate_rad_s = {row[1], row[2], row[3]}});
  }
  return samples;
}

}  // namespace cas::hils
