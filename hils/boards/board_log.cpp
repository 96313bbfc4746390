// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/board_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <chrono>
#include <cstdint>
#include <exception>
#include <optional>
#include <span>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "base/os/result_file.hpp"
#include "base/time/clock.hpp"
#include "casd/packet/own_station.hpp"
#include "hils/boards/board_device.hpp"
#include "hils/boards/board_session.hpp"
#include "hils/run/loopback_udp.hpp"
#include "mavlink/common/heartbeat.hpp"
#include "mavlink/common/table.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/services/address.hpp"
#include "mavlink_gen/services/ftp_exchange.hpp"

namespace cas::hils {

namespace {

using mav::services::FtpEntry;
using mav::services::FtpExchange;
using mav::services::FtpResult;
using mav::services::FtpTiming;
using mav::services::Outcome;

constexpr mav::Source kSelf = casd::kOwnStation;
constexpr base::Duration kBytesLook = std::chrono::milliseconds(2);
constexpr base::Duration kHeardPatience = std::chrono::seconds(5);
constexpr double kBytesOfMib = 1024.0 * 1024.0;
constexpr std::size_t kMostFolders = 3;  ///< that are looked into until one has a log
constexpr int kDepth = 2;                ///< of folders below that of the logs

/// An error ends only the transfer.
[[noreturn]] void fail(const std::string& why) { throw std::runtime_error(why); }

/// The files of a board, one transfer after the other, until a deadline.
class BoardFiles {
 public:
  BoardFiles(Supervisor& supervisor, const BoardLog& limits)
      : supervisor_(supervisor),
        deadline_(base::steady_now() + limits.timeout),
        parser_(mavlink::common::table()),
        encode_(kSelf),
        exchange_([this](const auto& message) { send(message); }, timing(limits),
                  static_cast<std::uint16_t>(base::steady_now().time_since_epoch().count())) {}

  std::uint16_t port() const { return port_.port(); }

  /// Until the autopilot has been heard. @throws std::runtime_error
  void find_autopilot() {
    const base::RunTime end = base::steady_now() + kHeardPatience;
    while (!board_ && base::steady_now() < end) look();
    if (!board_) fail("it says nothing");
  }
  /// @throws std::runtime_error
  std::vector<FtpEntry> list(const std::string& folder) {
    exchange_.list(folder, Clock::now(), done());
    return finish().entries;
  }
  std::vector<std::uint8_t> download(const std::string& path) {
    exchange_.download(path, Clock::now(), done());
    return finish().bytes;
  }

 private:
  using Clock = std::chrono::steady_clock;

  static FtpTiming timing(const BoardLog& limits) {
    FtpTiming timing;
    timing.whole_timeout = limits.timeout;
    timing.max_file_bytes = static_cast<std::uint32_t>(limits.largest_mib * kBytesOfMib);
    return timing;
  }
  void send(const FtpExchange::Message& message) {
    if (board_) port_.send(encode_(mav::services::addressed(message, *board_)));
  }
  FtpExchange::Done done() {
    outcome_.reset();
    return [this](const Outcome& outcome, const FtpResult& result) {
      outcome_ = outcome;
      result_ = result;
    };
  }
  FtpResult finish() {
    while (!outcome_) {
      look();
      if (base::steady_now() < deadline_) continue;
      exchange_.give_up(
          mav::services::failure(mav::services::OutcomeKind::kTimeout, "it was not done in time"));
    }
    if (!outcome_->ok()) fail(outcome_->message);
    return std::move(result_);
  }
  void look() {
    std::span<const std::uint8_t> bytes = port_.read();
    if (bytes.empty()) supervisor_.wait(kBytesLook);
    for (; !bytes.empty(); bytes = port_.read()) {
      parser_.feed(bytes, [this](const mav::PacketView& packet) { on_packet(packet); });
    }
    exchange_.tick(Clock::now());
  }
  void on_packet(const mav::PacketView& packet) {
    using mavlink::common::Heartbeat;
    using mavlink::common::MavAutopilot;
    if (!board_ && packet.message_id == Heartbeat::kId) {
      const auto heartbeat = mav::decode<Heartbeat>(packet);
      if (heartbeat && heartbeat->autopilot != MavAutopilot::kInvalid) board_ = packet.source;
    }
    if (board_ && packet.source == *board_) exchange_.on_packet(packet, kSelf, Clock::now());
  }

  Supervisor& supervisor_;
  base::RunTime deadline_;
  LoopbackUdp port_{"no UDP port can be opened"};
  mav::PacketParser parser_;
  mav::Encoder encode_;
  FtpExchange exchange_;
  std::optional<mav::Source> board_;
  std::optional<Outcome> outcome_;
  FtpResult result_;
};

bool begins_with_digit(const FtpEntry& entry) {
  return std::isdigit(static_cast<unsigned char>(entry.name.front())) != 0;
}

struct FoundLog {
  std::string path;
  std::uint32_t size = 0;
  bool among_undated = false;  ///< beside it are names without a date: one may be newer
};

/// The newest log of a folder or, `depth` deep, of its newest folders.
std::optional<FoundLog> find_log(BoardFiles& files, const std::string& folder, int depth) {
  const std::vector<FtpEntry> entries = newest_first(files.list(folder));
  const bool mixed =
      !entries.empty() && begins_with_digit(entries.front()) && !begins_with_digit(entries.back());
  std::size_t looked = 0;
  for (const FtpEntry& entry : entries) {
    if (!entry.folder || depth == 0 || looked++ == kMostFolders) continue;
    if (auto found = find_log(files, folder + "/" + entry.name, depth - 1)) {
      found->among_undated |= mixed;
      return found;
    }
  }
  for (const FtpEntry& entry : entries) {
    if (!entry.folder) return FoundLog{folder + "/" + entry.name, entry.size, mixed};
  }
  return std::nullopt;
}

/// @return the bytes @throws std::runtime_error, RunStopped
std::string fetch(Supervisor& supervisor, const Board& board, const std::filesystem::path& by_id,
                  const std::filesystem::path& file) {
  const auto device = find_device(board, by_id);
  if (!device) fail("the board is not there");
  BoardFiles files(supervisor, *board.log);
  BoardSession session(supervisor, board, *device, files.port());
  files.find_autopilot();
  if (session.look().armed) fail("it is armed");
  const std::optional<FoundLog> newest = find_log(files, board.log->folder, kDepth);
  if (!newest) fail(board.log->folder + " has no .ulg");
  const double mib = newest->size / kBytesOfMib;
  if (mib > board.log->largest_mib) {
    fail(fmt::format("{} has {:.1f} MiB, and its `largest_mib` is {:g}", newest->path, mib,
                     board.log->largest_mib));
  }
  const std::vector<std::uint8_t> bytes = files.download(newest->path);
  base::write_result({file.parent_path(), file.filename()},
                     std::string(bytes.begin(), bytes.end()));
  return fmt::format(
      "{}, {} bytes{}", newest->path, bytes.size(),
      newest->among_undated ? "; it may be of an earlier flight: others there have no date" : "");
}

}  // namespace

std::vector<FtpEntry> newest_first(std::vector<FtpEntry> entries) {
  std::erase_if(entries, [](const FtpEntry& entry) {
    return entry.name.empty() || entry.name.front() == '.' ||
           (!entry.folder && !entry.name.ends_with(".ulg"));
  });
  std::ranges::sort(entries, [](const FtpEntry& a, const FtpEntry& b) {
    return std::pair(begins_with_digit(a), std::string_view(a.name)) >
           std::pair(begins_with_digit(b), std::string_view(b.name));
  });
  return entries;
}

FetchedLog fetch_newest_log(Supervisor& supervisor, const Board& board,
                            const std::filesystem::path& by_id, const std::filesystem::path& file) {
  FetchedLog fetched;
  try {
    fetched.sentence = fmt::format("board '{}': its newest log is in {}: {}", board.name,
                                   file.filename().string(), fetch(supervisor, board, by_id, file));
    fetched.done = true;
  } catch (const std::exception& error) {
    const auto* stopped = dynamic_cast<const RunStopped*>(&error);
    if (stopped != nullptr && stopped->interrupted()) throw;
    fetched.sentence =
        fmt::format("board '{}': its log was not fetched: {}", board.name, error.what());
  }
  // Names come from the board, and a terminal obeys control characters.
  std::ranges::replace_if(
      fetched.sentence, [](unsigned char c) { return std::iscntrl(c) != 0; }, '?');
  return fetched;
}

}  // namespace cas::hils
