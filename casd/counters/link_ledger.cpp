// SPDX-License-Identifier: BSD-3-Clause
#include "casd/counters/link_ledger.hpp"

#include <fmt/format.h>
#include <array>
#include <charconv>
#include <string_view>

#include "base/error.hpp"
#include "base/os/write_file.hpp"
#include "base/read_file.hpp"

namespace cas::casd {
namespace {

constexpr std::string_view kHeader = "link,event,message_id,time_usec,at_ns";
constexpr std::string_view kDropped = "dropped.";

constexpr std::size_t kUsualRow = 64;                      // bytes
constexpr std::size_t kMostBytes = std::size_t{1} << 30U;  // of a file

template <class Number>
void add_cell(std::string& text, Number number) {
  std::array<char, 24> digits;  // more than any number has
  const auto [end, error] = std::to_chars(digits.data(), digits.data() + digits.size(), number);
  text += ',';
  text.append(digits.data(), end);
}

void add_rows(std::string& text, const std::string& link, std::string_view event,
              const LinkLedger::Entries& entries, bool with_cause) {
  for (const LinkLedgerEntry& entry : entries) {
    text.append(link).append(",").append(event);
    if (with_cause) text.append(to_string(entry.cause));
    add_cell(text, entry.message_id);
    add_cell(text, entry.time_usec);
    add_cell(text, entry.at_ns);
    text += '\n';
  }
}

std::string_view take_line(std::string_view& text) {
  const std::size_t end = text.find('\n');
  const std::string_view line = text.substr(0, end);
  text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  return line;
}

std::string_view take_cell(std::string_view& line) {
  const std::size_t comma = line.find(',');
  const std::string_view cell = line.substr(0, comma);
  line.remove_prefix(comma == std::string_view::npos ? line.size() : comma + 1);
  return cell;
}

template <class Number>
bool take_number(std::string_view& line, Number& number) {
  const std::string_view cell = take_cell(line);
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), number);
  return error == std::errc{} && end == cell.data() + cell.size();
}

}  // namespace

void write_link_ledgers(const std::filesystem::path& file,
                        const std::map<std::string, const LinkLedger*>& ledgers) {
  std::size_t rows = 1;
  for (const auto& [name, ledger] : ledgers) {
    rows += ledger->received().size() + ledger->sent().size() + ledger->dropped().size();
  }
  std::string text;
  text.reserve(rows * kUsualRow);
  text.append(kHeader) += '\n';
  for (const auto& [name, ledger] : ledgers) {
    add_rows(text, name, "received", ledger->received(), false);
    add_rows(text, name, "sent", ledger->sent(), false);
    add_rows(text, name, kDropped, ledger->dropped(), true);
  }
  base::write_file(file, text, base::Durability::kCache);
}

std::map<std::string, LinkLedger> read_link_ledgers(const std::filesystem::path& file) {
  const std::string whole = base::read_foreign_file(file, "ledger of links", kMostBytes);
  std::string_view text = whole;
  if (take_line(text) != kHeader)
    throw base::ConfigError(file.string() + ": is no ledger of links");
  std::map<std::string, LinkLedger> ledgers;
  for (int number = 2; !text.empty(); ++number) {
    std::string_view line = take_line(text);
    const std::string_view link = take_cell(line);
    const std::string_view event = take_cell(line);
    LinkLedgerEntry entry;
    bool good = take_number(line, entry.message_id) && take_number(line, entry.time_usec) &&
                take_number(line, entry.at_ns);
    LinkLedger& ledger = ledgers[std::string(link)];
    if (event == "received") {
      ledger.received_.push_back(entry);
    } else if (event == "sent") {
      ledger.sent_.push_back(entry);
    } else {
      const CauseWords* words =
          event.starts_with(kDropped) ? find_cause(event.substr(kDropped.size())) : nullptr;
      good = good && words != nullptr;
      if (words != nullptr) entry.cause = words->cause;
      ledger.dropped_.push_back(entry);
    }
    if (!good) {
      throw base::ConfigError(
          fmt::format("{}:{}: not a row of a ledger of links", file.string(), number));
    }
  }
  return ledgers;
}

}  // namespace cas::casd
