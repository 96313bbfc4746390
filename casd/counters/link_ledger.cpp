// SPDX-License-Identifier: BSD-3-Clause
#include "casd/counters/link_ledger.hpp"

#include <charconv>
#include <fstream>
#include <optional>
#include <sstream>
#include <string_view>

#include "base/error.hpp"
#include "base/os/write_file.hpp"

namespace cas::casd {
namespace {

constexpr std::string_view kHeader = "link,event,message_id,time_usec,at_ns";
constexpr std::string_view kDropped = "dropped.";

void write_entries(std::ostream& out, const std::string& link, const std::string& event,
                   const LinkLedger::Entries& entries, bool with_cause) {
  for (const LinkLedgerEntry& entry : entries) {
    out << link << ',' << event;
    if (with_cause) out << to_string(entry.cause);
    out << ',' << entry.message_id << ',' << entry.time_usec << ',' << entry.at_ns << '\n';
  }
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
  std::ostringstream out;
  out << kHeader << '\n';
  for (const auto& [name, ledger] : ledgers) {
    write_entries(out, name, "received", ledger->received(), false);
    write_entries(out, name, "sent", ledger->sent(), false);
    write_entries(out, name, std::string(kDropped), ledger->dropped(), true);
  }
  base::write_file(file, out.view(), base::Durability::kCache);
}

std::map<std::string, LinkLedger> read_link_ledgers(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string text;
  if (!in || !std::getline(in, text) || text != kHeader) {
    throw base::ConfigError(file.string() + ": is no ledger of links");
  }
  std::map<std::string, LinkLedger> ledgers;
  for (int number = 2; std::getline(in, text); ++number) {
    std::string_view line(text);
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
      const auto cause = event.starts_with(kDropped)
                             ? kDropCauseWords.find(event.substr(kDropped.size()))
                             : std::nullopt;
      good = good && cause.has_value();
      entry.cause = cause.value_or(DropCause::kAge);
      ledger.dropped_.push_back(entry);
    }
    if (!good) {
      throw base::ConfigError(file.string() + ":" + std::to_string(number) +
                              ": not a row of a ledger of links");
    }
  }
  return ledgers;
}

}  // namespace cas::casd
