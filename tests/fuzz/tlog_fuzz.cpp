// SPDX-License-Identifier: BSD-3-Clause
// Any bytes as a telemetry log: the same records however it is cut into pieces, and each byte is in
// a record or was skipped.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <span>
#include <vector>

#include "mavlink/common/table.hpp"
#include "mavlink_gen/services/tlog.hpp"

namespace {

using cas::mav::services::TlogRecord;
using cas::mav::services::TlogSplitter;

/// The records, end to end. @param piece  bytes that are fed at a time
std::vector<std::uint8_t> records_of(std::span<const std::uint8_t> log, std::size_t piece) {
  std::vector<std::uint8_t> records;
  TlogSplitter splitter;
  const auto take = [&](bool whole) {
    while (const std::optional<TlogRecord> record = splitter.next(whole)) {
      cas::mav::services::append_tlog_record(record->unix_us, record->packet, records);
    }
  };
  for (auto rest = log; !rest.empty(); rest = rest.subspan(std::min(piece, rest.size()))) {
    splitter.feed(rest.first(std::min(piece, rest.size())));
    take(false);
  }
  take(true);
  if (records.size() + splitter.skipped_bytes() > log.size()) std::abort();
  return records;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span log(data, size);
  const std::vector<std::uint8_t> whole = records_of(log, size + 1);
  if (records_of(log, 7) != whole) std::abort();

  TlogSplitter splitter;
  splitter.feed(whole);
  const auto next = [&] { return splitter.next(true); };
  cas::mav::services::for_each_tlog_packet(next, mavlink::common::table(),
                                           [](std::uint64_t, const cas::mav::PacketView&) {});
  return 0;
}
