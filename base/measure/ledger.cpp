// SPDX-License-Identifier: BSD-3-Clause
#include "base/measure/ledger.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <string>
#include <string_view>
#include <system_error>

#include "base/error.hpp"
#include "base/os/write_file.hpp"
#include "base/read_file.hpp"

namespace cas::base {

namespace {

constexpr std::string_view kHeader = "direction,message_id,time_usec,at_ns";
constexpr std::size_t kMostDigits = 20;
constexpr std::size_t kUsualRow = 40;                      // bytes
constexpr std::size_t kMostBytes = std::size_t{1} << 30U;  // of a file: an hour at 1 kHz has 0.3 GB

template <class Number>
void add_cell(std::string& text, Number number) {
  std::array<char, kMostDigits + 1> digits;
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), number);
  text += ',';
  text.append(digits.data(), end);
}

/// Takes ",NUMBER" from the front.
template <class Number>
bool take_cell(std::string_view& row, Number& number) {
  if (!row.starts_with(',')) return false;
  const char* const end_of_row = row.data() + row.size();
  const auto [end, error] = std::from_chars(row.data() + 1, end_of_row, number);
  row = std::string_view(end, static_cast<std::size_t>(end_of_row - end));
  return error == std::errc{};
}

bool parse_row(std::string_view row, LedgerEntry& entry) {
  if (!row.starts_with('s') && !row.starts_with('r')) return false;
  entry.direction =
      row.front() == 's' ? LedgerEntry::Direction::kSent : LedgerEntry::Direction::kReceived;
  row.remove_prefix(1);
  return take_cell(row, entry.message_id) && take_cell(row, entry.time_usec) &&
         take_cell(row, entry.at_ns) && row.empty();
}

/// Takes the first line, without its end.
std::string_view take_line(std::string_view& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return line;
}

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

std::string PacketLedger::csv() const {
  std::string text;
  text.reserve(kHeader.size() + 1 + kUsualRow * entries_.size());
  text.append(kHeader) += '\n';
  for (const LedgerEntry& entry : entries_) {
    text += entry.direction == LedgerEntry::Direction::kSent ? 's' : 'r';
    add_cell(text, entry.message_id);
    add_cell(text, entry.time_usec);
    add_cell(text, entry.at_ns);
    text += '\n';
  }
  return text;
}

void PacketLedger::write(const std::filesystem::path& file) const {
  write_file(file, csv(), Durability::kCache);
}

std::vector<LedgerEntry> PacketLedger::read(const std::filesystem::path& file) {
  const std::string whole = read_foreign_file(file, "packet ledger", kMostBytes);
  std::string_view text = whole;
  if (take_line(text) != kHeader) throw ConfigError(file.string() + ": is no packet ledger");
  std::vector<LedgerEntry> entries;
  entries.reserve(text.size() / kUsualRow);
  for (int number = 2; !text.empty(); ++number) {
    if (!parse_row(take_line(text), entries.emplace_back())) {
      throw ConfigError(file.string() + ":" + std::to_string(number) + ": is no ledger line");
    }
  }
  return entries;
}

}  // namespace cas::base
