// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "mavlink_gen/runtime/packet.hpp"
#include "mavlink_gen/services/ftp_payload.hpp"
#include "mavlink_gen/services/time.hpp"

namespace cas::mav::services {

/// The files that an FtpServer serves. Paths have been checked: relative to the top ("log/a.ulg";
/// the top itself is empty), without "." and "..". A store of a disk must not follow symbolic links
/// that lead out of its folder.
class FtpStore {
 public:
  virtual ~FtpStore() = default;
  virtual FtpFailure list(const std::string& folder, std::vector<FtpEntry>& entries) = 0;
  /// The length of a file.
  virtual FtpFailure length(const std::string& path, std::uint32_t& bytes) = 0;
  /// @param out  destination; shortened to the bytes read, at the file's end to nothing
  virtual FtpFailure read(const std::string& path, std::uint32_t offset,
                          std::span<std::uint8_t>& out) = 0;
  /// Makes a file of length 0; truncates an existing one.
  virtual FtpFailure create(const std::string& path) = 0;
  virtual FtpFailure write(const std::string& path, std::uint32_t offset,
                           std::span<const std::uint8_t> bytes) = 0;
  virtual FtpFailure remove(const std::string& path) = 0;
};

/// A store in which nothing can be changed: create, write and remove fail as kFileprotected. Base
/// of the stores whose files our controller offers.
class ReadOnlyFtpStore : public FtpStore {
 public:
  FtpFailure create(const std::string&) final { return kProtected; }
  FtpFailure write(const std::string&, std::uint32_t, std::span<const std::uint8_t>) final {
    return kProtected;
  }
  FtpFailure remove(const std::string&) final { return kProtected; }

 private:
  static constexpr FtpFailure kProtected{.code = mavlink::common::MavFtpErr::kFileprotected};
};

/// How much of a line an FtpServer takes, and how many files are open at once.
struct FtpServerLimits {
  /// All packets together; 0: answers at once, and of a burst one packet with each update().
  double bytes_per_s = 0;
  /// Data bytes in one packet of a burst or a list: shorter packets let others through on a slow
  /// line. A read request gets its full size.
  std::size_t piece_bytes = kFtpDataBytes;
  std::size_t sessions = 4;
  Duration idle_after = std::chrono::seconds(30);  ///< then another client may have the session
  /// Packets of a burst, after which the client asks for more. If pieces are shorter than
  /// requested, the burst goes on to the end of the file: some clients take its end for the file's.
  std::size_t burst_packets = 256;
};

/// The vehicle's side of the file transfer protocol (https://mavlink.io/en/services/ftp.html):
/// lists, reads, writes and removes files of a store. Answers and bursts share one pace, answers
/// first; checksums of large files are computed in parts, one file after the other. Clients have
/// their own sessions, each with the number that its opening names, or with the next free one if
/// that is 0 and taken; a request that comes again within 5 s gets the same answer again. Folders
/// are not made, files are not renamed or cut.
class FtpServer {
 public:
  using Message = mavlink::common::FileTransferProtocol;
  /// @return the bytes that the packet takes of the line
  using Send = std::function<std::size_t(const Message&)>;

  FtpServer(FtpStore& store, Send send, FtpServerLimits limits = {})
      : store_(store), send_(std::move(send)), limits_(limits) {}

  /// @param from  the client
  void on_request(const Message& message, Source from, Time now);
  /// Sends due packets; call it every few milliseconds.
  void update(Time now);
  /// Requests that no room was left for; their senders ask again.
  std::uint64_t dropped() const { return dropped_; }

 private:
  struct Request {
    Source from;
    FtpPayload payload;
    friend bool operator==(const Request&, const Request&) = default;
  };
  struct Session {
    Source owner;
    std::uint8_t id = 0;
    std::string path{};
    bool writing = false;
    Time used{};
    std::optional<FtpPayload> burst{};  ///< the packet to send next, without its data
    std::size_t burst_left = 0;         ///< packets
  };
  struct Answered {
    Request request;
    FtpPayload answer;
    Time at;
  };
  struct Checksum {
    Request request;
    std::string path;
    std::uint32_t length = 0;  ///< when it was asked for
    std::uint32_t offset = 0;
    std::uint32_t crc = 0;
  };
  struct Listing {
    std::string folder;
    std::vector<FtpEntry> entries;
  };

  static bool is_for_sum(const Request& request);
  void send_burst(Time now);
  void answer(const Request& request, Time now);
  FtpFailure perform(const Request& request, FtpPayload& reply, Time now);
  FtpFailure list(const FtpPayload& asked, FtpPayload& reply);
  FtpFailure open(const Request& request, FtpPayload& reply, Time now);
  bool is_open(Source owner, std::uint8_t id) const;
  std::uint8_t session_for(const Request& request) const;
  FtpFailure read(const Session& session, std::uint32_t offset, std::size_t size,
                  FtpPayload& reply);
  FtpFailure write(const Session& session, const FtpPayload& asked);
  FtpFailure begin_burst(Session& session, const FtpPayload& asked);
  FtpFailure begin_checksum(const Request& request, Time now);
  void step_checksum(Time now);
  Session* find(const Request& request, Time now);
  void close(Source owner, std::optional<std::uint8_t> id);
  void conclude(const Request& request, FtpPayload reply, const FtpFailure& failure, Time now);
  void send(const FtpPayload& payload, Source to, Time now);

  FtpStore& store_;
  Send send_;
  FtpServerLimits limits_;
  std::deque<Request> waiting_;
  std::vector<Session> sessions_;
  std::deque<Answered> answered_;  ///< the last few of each client, newest last
  std::optional<Checksum> checksum_;
  std::optional<Listing> listing_;  ///< the last: of a long folder several pages are asked for
  std::size_t next_burst_ = 0;
  Time due_{};
  std::uint64_t dropped_ = 0;
};

/// A request's path below the top; empty for the top itself. @return nullopt when it leads out of
/// it
std::optional<std::string> ftp_path(std::string_view text);

}  // namespace cas::mav::services
