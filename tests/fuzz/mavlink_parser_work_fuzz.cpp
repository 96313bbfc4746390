// SPDX-License-Identifier: BSD-3-Clause
// Looks for the bytes that cost the packet parser most: an input that raises the work for each byte
// counts as new coverage. More than two reads and three headers for each byte are a fault.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"

namespace {

using namespace cas::mav;

constexpr std::size_t kMaxReads = 2;
constexpr std::size_t kMaxHeaders = 3;
constexpr std::size_t kSteps = 64;  // of work for each byte that libFuzzer tells apart

#ifdef __linux__
__attribute__((section("__libfuzzer_extra_counters")))
#endif
std::uint8_t reached[(kMaxReads + kMaxHeaders) * kSteps + 2];

/// Tells libFuzzer how dear the input was.
void reach(std::size_t first, std::uint64_t work, std::size_t bytes, std::size_t most) {
  const auto step = std::min<std::uint64_t>(work * kSteps / bytes, most * kSteps);
  reached[first + step] = 1;
}

void feed(std::span<const std::uint8_t> bytes, std::size_t piece) {
  PacketParser parser(mavlink::common::table());
  for (std::size_t i = 0; i < bytes.size(); i += piece) {
    parser.feed(bytes.subspan(i, std::min(piece, bytes.size() - i)), [](const PacketView&) {});
  }
  const auto& stats = parser.stats();
  if (stats.summed_bytes > kMaxReads * bytes.size()) std::abort();
  if (stats.headers > kMaxHeaders * bytes.size()) std::abort();
  reach(0, stats.summed_bytes, bytes.size(), kMaxReads);
  reach(kMaxReads * kSteps + 1, stats.headers, bytes.size(), kMaxHeaders);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  for (const std::size_t piece : {size, std::size_t{1}, std::size_t{8}}) feed({data, size}, piece);
  return 0;
}
