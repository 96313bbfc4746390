// SPDX-License-Identifier: BSD-3-Clause
#include "base/measure/ledger.hpp"

#include <cinttypes>
#include <cstdio>
#include <memory>
#include <string>

#include "base/error.hpp"
#include "base/os/write_file.hpp"

namespace cas::base {

namespace {

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, FileCloser>;

constexpr const char* kHeader = "direction,message_id,time_usec,at_ns\n";

}  // namespace

PacketLedger::PacketLedger(std::size_t expected) { entries_.reserve(expected); }

void PacketLedger::sent(std::uint32_t message_id, std::uint64_t time_usec, RunTime at) {
  entries_.push_back(
      {LedgerEntry::Direction::kSent, message_id, time_usec, at.time_since_epoch().count()});
}

void PacketLedger::received(std::uint32_t message_id, std::uint64_t time_usec, RunTime at) {
  entries_.push_back(
      {LedgerEntry::Direction::kReceived, message_id, time_usec, at.time_since_epoch().count()});
}

void PacketLedger::write(const std::filesystem::path& file) const {
  std::string text = kHeader;
  char line[80];
  for (const LedgerEntry& entry : entries_) {
    const int size = std::snprintf(line, sizeof line, "%c,%" PRIu32 ",%" PRIu64 ",%" PRId64 "\n",
                                   entry.direction == LedgerEntry::Direction::kSent ? 's' : 'r',
                                   entry.message_id, entry.time_usec, entry.at_ns);
    text.append(line, static_cast<std::size_t>(size));
  }
  write_file(file, text, Durability::kCache);
}

std::vector<LedgerEntry> PacketLedger::read(const std::filesystem::path& file) {
  const File in(std::fopen(file.c_str(), "r"));
  char line[128];
  if (!in || !std::fgets(line, sizeof line, in.get()))
    throw ConfigError(file.string() + ": is no packet ledger");
  std::vector<LedgerEntry> entries;
  int number = 1;
  while (std::fgets(line, sizeof line, in.get())) {
    ++number;
    LedgerEntry entry;
    char direction = 0;
    if (std::sscanf(line, "%c,%" SCNu32 ",%" SCNu64 ",%" SCNd64, &direction, &entry.message_id,
                    &entry.time_usec, &entry.at_ns) != 4 ||
        (direction != 's' && direction != 'r')) {
      throw ConfigError(file.string() + ":" + std::to_string(number) + ": is no ledger line");
    }
    entry.direction =
        direction == 's' ? LedgerEntry::Direction::kSent : LedgerEntry::Direction::kReceived;
    entries.push_back(entry);
  }
  return entries;
}

}  // namespace cas::base
