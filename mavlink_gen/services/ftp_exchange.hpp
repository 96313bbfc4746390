// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "mavlink_gen/runtime/packet.hpp"
#include "mavlink_gen/services/ftp_payload.hpp"
#include "mavlink_gen/services/outcome.hpp"
#include "mavlink_gen/services/time.hpp"

namespace cas::mav::services {

/// Timeouts, tries and size limits of a transfer.
struct FtpTiming {
  Duration answer_timeout = std::chrono::milliseconds(300);
  Duration checksum_timeout = std::chrono::seconds(2);  ///< a server reads the whole file for one
  int tries = 10;                                       ///< of the first request, and of a checksum
  /// A server that has answered once is given up after so long without anything new.
  Duration silence = std::chrono::seconds(10);
  /// A transfer that is not whole by then is given up, however much still comes.
  Duration whole_timeout = std::chrono::hours(1);
  std::uint32_t max_file_bytes = 256U << 20U;
  std::size_t max_entries = 8192;  ///< of a folder
};

/// Result of a file transfer; if it failed, the data received until then.
struct FtpResult {
  std::vector<FtpEntry> entries{};    ///< of list()
  std::vector<std::uint8_t> bytes{};  ///< of download() and upload(); those that are missing are 0
  bool checked = false;               ///< the server's checksum of the file agrees
};

/// Answers that were left out.
struct FtpOddities {
  std::uint64_t malformed = 0;  ///< of impossible size, or without a required part
  std::uint64_t stray = 0;      ///< to no request: another number, session or operation
  std::uint64_t outside = 0;    ///< pieces beyond the end of the file
};

/// The file transfer protocol (https://mavlink.io/en/services/ftp.html) with one vehicle, from the
/// ground station's side. One transfer at a time. Every wait has a deadline and a bound on tries.
///
/// A download is OpenFileRO, then bursts; lost pieces are requested by ReadFile. A server without
/// bursts is read piece by piece; one that has restarted meanwhile has the file opened again. At
/// the end the file is closed and its checksum compared, where the server can compute one.
class FtpExchange {
 public:
  using Message = mavlink::common::FileTransferProtocol;
  using Send = std::function<void(const Message&)>;
  /// Called once, when the transfer has ended.
  using Done = std::function<void(const Outcome&, const FtpResult&)>;

  /// @param first_number  of the requests. A program that is started again and again gives another
  ///                      each time (from a clock): a server repeats its answer to a request that
  ///                      it knows.
  explicit FtpExchange(Send send, FtpTiming timing = {}, std::uint16_t first_number = 0)
      : send_(std::move(send)), timing_(timing), seq_(first_number) {}

  /// Entries of a folder. Names that would lead out of it are left out.
  void list(const std::string& path, Time now, Done done);
  void download(const std::string& path, Time now, Done done);
  /// Creates the file, or replaces it.
  void upload(const std::string& path, std::vector<std::uint8_t> bytes, Time now, Done done);
  void remove(const std::string& path, Time now, Done done);
  /// Closes all open files at the server, at servers that follow the standard also those of other
  /// clients; FtpServer closes only the caller's. Files left open by a crashed client may block
  /// others.
  void reset(Time now, Done done);

  /// Takes in a packet of the vehicle. @param self  packets for others are left out
  void on_packet(const PacketView& packet, Source self, Time now);
  void tick(Time now);
  /// When tick() has something to do; nullopt while nothing is under way.
  std::optional<Time> deadline() const;
  /// Ends the transfer with this outcome.
  void give_up(const Outcome& outcome);
  bool busy() const { return transfer_.has_value(); }
  const FtpOddities& oddities() const { return oddities_; }

 private:
  using Opcode = mavlink::common::MavFtpOpcode;
  struct Transfer {
    const char* doing = "";  ///< "reading", ...
    std::string path{};
    Done done{};
    FtpResult result{};
    FtpPayload last{};  ///< request to repeat; its opcode is the current step of the transfer
    int sent = 0;
    bool answered = false;  ///< any request was
    Time news{};            ///< when the last request was answered, or a burst brought something
    bool behind_burst = false;  ///< the last request was for a burst
    Time deadline{};
    Time give_up{};  ///< of the transfer as a whole
    std::optional<std::uint8_t> session{};
    int openings = 0;
    std::uint32_t entries = 0;              ///< of a list: those that came, skipped ones too
    std::optional<std::uint32_t> length{};  ///< of a download, once it is known
    std::map<std::uint32_t, std::uint32_t> gaps{};  ///< of a download: missing bytes, begin to end
    std::uint32_t written = 0;                      ///< of an upload
    std::optional<std::uint16_t> first_burst{};     ///< after it come the numbers of bursts
    std::uint32_t burst_bytes = 0;                  ///< that the newest burst has brought
    bool bursts = true;                             ///< the server knows bursts
  };

  void start(Opcode opcode, Transfer transfer, Time now);
  void ask(Opcode opcode, Time now);
  void say(Time now);
  void take_next_number();
  void send_last(Time now);
  void on_ack(const FtpPayload& answer, Time now);
  void on_nak(const FtpPayload& answer, Time now);
  void on_burst(const FtpPayload& answer, Time now);
  void on_entries(const FtpPayload& answer, Time now);
  void on_open(const FtpPayload& answer, Time now);
  void on_piece(const FtpPayload& answer, Time now);
  void on_closed(Time now);
  void on_checksum(const FtpPayload& answer);
  std::uint32_t take(const FtpPayload& piece);
  void read_on(Time now);
  void write_on(Time now);
  void refuse(const std::string& why);
  void finish(const Outcome& outcome);
  std::string progress() const;

  Send send_;
  FtpTiming timing_;
  FtpOddities oddities_;
  std::uint16_t seq_;  ///< the newest number of either side
  std::optional<Transfer> transfer_;
};

}  // namespace cas::mav::services
