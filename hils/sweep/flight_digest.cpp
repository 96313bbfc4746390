// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/flight_digest.hpp"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <fstream>

#include "mavlink_gen/runtime/sha256.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;

void add_file(const fs::path& file, mav::Sha256& hash) {
  std::array<char, 1U << 16U> buffer{};
  std::ifstream stream(file, std::ios::binary);
  while (stream.read(buffer.data(), static_cast<std::streamsize>(buffer.size())),
         stream.gcount() > 0) {
    const auto size = static_cast<std::size_t>(stream.gcount());
    hash.update({reinterpret_cast<const std::uint8_t*>(buffer.data()), size});
  }
}

void add_ledger(const std::vector<base::LedgerEntry>& ledger, mav::Sha256& hash) {
  std::string text;
  for (const base::LedgerEntry& entry : ledger) {
    text += fmt::format("{},{},{},{}\n", static_cast<int>(entry.direction), entry.message_id,
                        entry.time_usec, entry.at_ns);
  }
  text += "\n";
  hash.update({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

std::string words_of(mav::Sha256& hash) {
  std::string text;
  for (const std::uint8_t byte : hash.finish()) text += fmt::format("{:02x}", byte);
  return text;
}

}  // namespace

std::string sha256_of_files(const std::vector<fs::path>& files) {
  mav::Sha256 hash;
  for (const fs::path& file : files) add_file(file, hash);
  return words_of(hash);
}

std::string truth_sha256(const RunResult& run) {
  std::vector<fs::path> files;
  for (const VehicleResult& vehicle : run.vehicles) files.push_back(vehicle.record.truth_csv);
  return sha256_of_files(files);
}

std::string run_sha256(const RunResult& run) {
  mav::Sha256 hash;
  for (const VehicleResult& vehicle : run.vehicles) {
    const RunRecord& record = vehicle.record;
    add_file(record.truth_csv, hash);
    add_file(record.flight_tlog, hash);
    add_ledger(record.simulator, hash);
    add_ledger(record.controller, hash);
  }
  return words_of(hash);
}

}  // namespace cas::hils
