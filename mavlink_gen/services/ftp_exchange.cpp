// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/ftp_exchange.hpp"

#include <algorithm>
#include <charconv>
#include <string_view>
#include <utility>

#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/services/address.hpp"

namespace cas::mav::services {

using mavlink::common::MavFtpErr;

namespace {

/// A server that restarts again and again costs so many openings of one file.
constexpr int kMaxOpenings = 4;
/// Pieces that would tear the file into more parts are left out.
constexpr std::size_t kMaxGaps = 4096;
/// Numbers that a new transfer skips: late packets of an older burst have lower numbers.
constexpr std::uint16_t kSkippedNumbers = 1024;
/// Numbers that the request behind a burst skips: each packet of a burst takes one, also those that
/// were lost, and ArduPilot's server answers a request of the number before its last one with that
/// packet.
constexpr std::uint16_t kNumbersOfABurst = 512;

FtpFailure failure_of(const FtpPayload& nak) {
  if (nak.size == 0) return {.code = MavFtpErr::kFail};
  return {.code = static_cast<MavFtpErr>(nak.data[0]),
          .error_number = nak.size > 1 ? nak.data[1] : std::uint8_t{0}};
}

/// "F", the name, and of a file a tab and its size. @return nullopt when it is to be skipped
std::optional<FtpEntry> parse_entry(std::string_view text) {
  if (text.empty() || (text[0] != 'F' && text[0] != 'D')) return std::nullopt;
  const std::size_t tab = std::min(text.find('\t'), text.size());
  FtpEntry entry{.folder = text[0] == 'D', .name = std::string(text.substr(1, tab - 1))};
  if (tab < text.size()) {
    std::from_chars(text.data() + tab + 1, text.data() + text.size(), entry.size);
  }
  // A caller that writes files under these names must stay in its folder.
  const bool leads_out = entry.name.empty() || entry.name == "." || entry.name == ".." ||
                         entry.name.find('/') != std::string::npos;
  return leads_out ? std::nullopt : std::optional(std::move(entry));
}

}  // namespace

void FtpExchange::list(const std::string& path, Time now, Done done) {
  start(Opcode::kListdirectory, {.doing = "listing", .path = path, .done = std::move(done)}, now);
}

void FtpExchange::download(const std::string& path, Time now, Done done) {
  start(Opcode::kOpenfilero, {.doing = "reading", .path = path, .done = std::move(done)}, now);
}

void FtpExchange::upload(const std::string& path, std::vector<std::uint8_t> bytes, Time now,
                         Done done) {
  start(Opcode::kCreatefile,
        {.doing = "writing",
         .path = path,
         .done = std::move(done),
         .result = {.bytes = std::move(bytes)}},
        now);
}

void FtpExchange::remove(const std::string& path, Time now, Done done) {
  start(Opcode::kRemovefile, {.doing = "removing", .path = path, .done = std::move(done)}, now);
}

void FtpExchange::reset(Time now, Done done) {
  start(Opcode::kResetsession, {.doing = "closing all files", .done = std::move(done)}, now);
}

void FtpExchange::start(Opcode opcode, Transfer transfer, Time now) {
  const auto fail = [&](OutcomeKind kind, const char* why) {
    transfer.done(failure(kind, why), transfer.result);
  };
  if (transfer_) return fail(OutcomeKind::kRefused, "another file transfer is under way");
  if (transfer.path.empty() != (opcode == Opcode::kResetsession) ||
      transfer.path.size() > kFtpDataBytes) {
    return fail(OutcomeKind::kInvalid, "a path has 1 to 239 bytes");
  }
  if (transfer.result.bytes.size() > timing_.max_file_bytes) {
    return fail(OutcomeKind::kInvalid, "the file is larger than may be written");
  }
  transfer_ = std::move(transfer);
  transfer_->give_up = now + timing_.whole_timeout;
  seq_ = static_cast<std::uint16_t>(seq_ + kSkippedNumbers);
  ask(opcode, now);
}

/// The next request: the open session's number, or the path.
void FtpExchange::ask(Opcode opcode, Time now) {
  Transfer& transfer = *transfer_;
  transfer.last = {.session = transfer.session.value_or(0), .opcode = opcode};
  if (opcode == Opcode::kListdirectory) transfer.last.offset = transfer.entries;
  if (opcode != Opcode::kTerminatesession) transfer.last.set_text(transfer.path);
  say(now);
}

/// Sends `last` as a new request.
void FtpExchange::say(Time now) {
  take_next_number();
  transfer_->sent = 1;
  transfer_->news = now;
  send_last(now);
}

/// Gives `last` a number that the server has not used.
void FtpExchange::take_next_number() {
  const std::uint16_t step = transfer_->behind_burst ? kNumbersOfABurst : 1;
  transfer_->last.seq = seq_ = static_cast<std::uint16_t>(seq_ + step);
  transfer_->behind_burst = transfer_->last.opcode == Opcode::kBurstreadfile;
}

void FtpExchange::send_last(Time now) {
  const bool checksum = transfer_->last.opcode == Opcode::kCalcfilecrc;
  transfer_->deadline = now + (checksum ? timing_.checksum_timeout : timing_.answer_timeout);
  send_(ftp_message(transfer_->last));
}

void FtpExchange::on_packet(const PacketView& packet, Source self, Time now) {
  if (packet.message_id != Message::kId) return;
  const auto message = decode<Message>(packet);
  if (!message || !is_for(*message, self)) return;
  const FtpPayload answer = ftp_payload(*message);
  if (!answer.is_answer()) return;  // another client's
  if (answer.size > kFtpDataBytes) {
    ++oddities_.malformed;
    return;
  }
  if (transfer_ && transfer_->first_burst && answer.req_opcode == Opcode::kBurstreadfile) {
    return on_burst(answer, now);
  }
  if (!transfer_ || answer.req_opcode != transfer_->last.opcode ||
      answer.seq != static_cast<std::uint16_t>(transfer_->last.seq + 1)) {
    ++oddities_.stray;
    return;
  }
  seq_ = answer.seq;
  transfer_->answered = true;
  if (answer.opcode == Opcode::kNak) return on_nak(answer, now);
  on_ack(answer, now);
}

void FtpExchange::on_ack(const FtpPayload& answer, Time now) {
  Transfer& transfer = *transfer_;
  switch (transfer.last.opcode) {
    case Opcode::kListdirectory:
      return on_entries(answer, now);
    case Opcode::kOpenfilero:
      return on_open(answer, now);
    case Opcode::kReadfile:
      return on_piece(answer, now);
    case Opcode::kCreatefile:
      transfer.session = answer.session;
      return write_on(now);
    case Opcode::kWritefile:
      transfer.written += transfer.last.size;
      return write_on(now);
    case Opcode::kTerminatesession:
      return on_closed(now);
    case Opcode::kCalcfilecrc:
      return on_checksum(answer);
    default:
      return finish({});
  }
}

void FtpExchange::on_nak(const FtpPayload& answer, Time now) {
  Transfer& transfer = *transfer_;
  const FtpFailure why = failure_of(answer);
  const Opcode asked = transfer.last.opcode;
  if (asked == Opcode::kTerminatesession) return on_closed(now);
  if (asked == Opcode::kCalcfilecrc) return finish({});  // a server without checksums
  if (asked == Opcode::kListdirectory && why.code == MavFtpErr::kEof) return finish({});
  if (asked == Opcode::kBurstreadfile && why.code == MavFtpErr::kUnknowncommand) {
    transfer.bursts = false;
    return read_on(now);
  }
  if (asked == Opcode::kReadfile && why.code == MavFtpErr::kEof) {
    return refuse("the file has become shorter meanwhile");
  }
  if (why.code == MavFtpErr::kInvalidsession && transfer.session &&
      transfer.openings < kMaxOpenings) {  // the server has restarted
    transfer.session.reset();
    transfer.first_burst.reset();
    transfer.written = 0;
    return ask(transfer.length ? Opcode::kOpenfilero : Opcode::kCreatefile, now);
  }
  refuse("the vehicle says that " + describe(why));
}

void FtpExchange::on_entries(const FtpPayload& answer, Time now) {
  Transfer& transfer = *transfer_;
  const std::uint32_t before = transfer.entries;
  std::string_view rest(reinterpret_cast<const char*>(answer.data.data()), answer.size);
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find('\0'), rest.size());
    if (end > 0) {
      ++transfer.entries;
      if (auto entry = parse_entry(rest.substr(0, end))) {
        transfer.result.entries.push_back(std::move(*entry));
      }
    }
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  if (transfer.entries == before) return finish({});  // some end a list with an empty answer
  if (transfer.entries > timing_.max_entries) {
    return refuse("the folder has more than " + std::to_string(timing_.max_entries) + " entries");
  }
  ask(Opcode::kListdirectory, now);
}

void FtpExchange::on_open(const FtpPayload& answer, Time now) {
  Transfer& transfer = *transfer_;
  transfer.session = answer.session;
  ++transfer.openings;
  if (answer.size < 4) {
    ++oddities_.malformed;
    return refuse("the vehicle does not tell the file's length");
  }
  const std::uint32_t length = answer.number();
  if (length > timing_.max_file_bytes) {
    return refuse("the file has " + std::to_string(length) + " bytes, more than may be read");
  }
  if (transfer.length && *transfer.length != length) {
    return refuse("the file has changed its length meanwhile");
  }
  if (!transfer.length && length > 0) transfer.gaps[0] = length;
  transfer.length = length;
  read_on(now);
}

/// Asks for missing bytes: the rest of the file by a burst, a gap before it by a read.
void FtpExchange::read_on(Time now) {
  Transfer& transfer = *transfer_;
  if (transfer.gaps.empty()) return ask(Opcode::kTerminatesession, now);
  const auto [begin, end] = *transfer.gaps.begin();
  // A burst that brought nothing is not asked for again at once.
  const bool fruitless =
      transfer.last.opcode == Opcode::kBurstreadfile && transfer.burst_bytes == 0;
  const bool burst = transfer.bursts && end == transfer.length && !fruitless;
  transfer.last = {.session = *transfer.session,
                   .opcode = burst ? Opcode::kBurstreadfile : Opcode::kReadfile,
                   .size = static_cast<std::uint8_t>(
                       std::min<std::uint32_t>(burst ? kFtpDataBytes : end - begin, kFtpDataBytes)),
                   .offset = begin};
  transfer.burst_bytes = 0;
  say(now);
  if (burst && !transfer.first_burst) transfer.first_burst = transfer.last.seq;
}

/// A packet of a burst. It counts by its offset, in whatever order and however late it comes.
void FtpExchange::on_burst(const FtpPayload& answer, Time now) {
  Transfer& transfer = *transfer_;
  // Numbers begin again after 65 535: those that count are a window that goes along with the
  // newest.
  if (static_cast<std::uint16_t>(seq_ - *transfer.first_burst) > 0x4000) {
    transfer.first_burst = static_cast<std::uint16_t>(seq_ - 0x2000);
  }
  const auto since = static_cast<std::uint16_t>(answer.seq - *transfer.first_burst);
  const bool nak = answer.opcode == Opcode::kNak;
  if (since == 0 || since > 0x7FFF || (!nak && answer.session != transfer.session)) {
    ++oddities_.stray;
    return;
  }
  if (static_cast<std::int16_t>(answer.seq - seq_) > 0) seq_ = answer.seq;
  const bool waiting = transfer.last.opcode == Opcode::kBurstreadfile;
  if (nak) {
    if (!waiting) return;
    // The end may belong to an older burst and be late: ask for missing bytes in either case.
    if (failure_of(answer).code == MavFtpErr::kEof) return read_on(now);
    return on_nak(answer, now);
  }
  if (const std::uint32_t fresh = take(answer)) {
    transfer.burst_bytes += fresh;
    transfer.sent = 1;
    transfer.news = now;
    transfer.deadline = now + timing_.answer_timeout;
  }
  const bool reading = waiting || transfer.last.opcode == Opcode::kReadfile;
  if ((waiting && answer.burst_complete) || (reading && transfer.gaps.empty())) read_on(now);
}

void FtpExchange::on_piece(const FtpPayload& answer, Time now) {
  const FtpPayload& asked = transfer_->last;
  if (answer.session != asked.session || answer.offset != asked.offset) {
    ++oddities_.stray;
    return;
  }
  if (answer.size == 0) return refuse("the file has become shorter meanwhile");
  take(answer);
  read_on(now);
}

/// Takes in a piece of the file. @return how many of its bytes were missing
std::uint32_t FtpExchange::take(const FtpPayload& piece) {
  Transfer& transfer = *transfer_;
  if (piece.size == 0 || piece.offset >= *transfer.length) {
    ++oddities_.outside;
    return 0;
  }
  const std::uint32_t begin = piece.offset;
  const std::uint32_t end = begin + std::min<std::uint32_t>(piece.size, *transfer.length - begin);
  std::uint32_t fresh = 0;
  auto gap = transfer.gaps.upper_bound(begin);
  if (gap != transfer.gaps.begin()) --gap;
  while (gap != transfer.gaps.end() && gap->first < end) {
    const auto [from, to] = *gap;
    const std::uint32_t low = std::max(from, begin);
    const std::uint32_t high = std::min(to, end);
    if (low >= high) {
      ++gap;
      continue;
    }
    if (from < low && high < to && transfer.gaps.size() >= kMaxGaps) break;
    auto& bytes = transfer.result.bytes;
    if (bytes.size() < high) bytes.resize(high);
    std::copy_n(piece.data.begin() + (low - begin), high - low, bytes.begin() + low);
    fresh += high - low;
    gap = transfer.gaps.erase(gap);
    if (from < low) transfer.gaps[from] = low;
    if (high < to) transfer.gaps[high] = to;
  }
  return fresh;
}

void FtpExchange::write_on(Time now) {
  Transfer& transfer = *transfer_;
  if (transfer.last.opcode == Opcode::kCreatefile) ++transfer.openings;
  const auto rest = std::span<const std::uint8_t>(transfer.result.bytes).subspan(transfer.written);
  if (rest.empty()) return ask(Opcode::kTerminatesession, now);
  transfer.last = {
      .session = *transfer.session, .opcode = Opcode::kWritefile, .offset = transfer.written};
  transfer.last.set_bytes(rest);
  say(now);
}

/// The session counts as closed even if TerminateSession was refused or lost.
void FtpExchange::on_closed(Time now) {
  transfer_->session.reset();
  ask(Opcode::kCalcfilecrc, now);
}

void FtpExchange::on_checksum(const FtpPayload& answer) {
  if (answer.size < 4) {
    ++oddities_.malformed;
    return finish({});
  }
  FtpResult& result = transfer_->result;
  result.checked = answer.number() == ftp_crc32(result.bytes);
  if (result.checked) return finish({});
  refuse("the file at the vehicle has another checksum: it has changed meanwhile, or was damaged");
}

void FtpExchange::tick(Time now) {
  if (!transfer_) return;
  Transfer& transfer = *transfer_;
  if (now >= transfer.give_up) {
    return finish(failure(OutcomeKind::kTimeout, progress() + "; the rest would take too long"));
  }
  if (now < transfer.deadline) return;
  const Opcode asked = transfer.last.opcode;
  if (asked == Opcode::kBurstreadfile && transfer.burst_bytes > 0) return read_on(now);
  const bool often_enough = transfer.sent >= timing_.tries;
  if (often_enough && asked == Opcode::kCalcfilecrc)
    return finish({});  // the file is too long for it
  if (often_enough && asked == Opcode::kTerminatesession) return on_closed(now);
  if (transfer.answered ? now - transfer.news >= timing_.silence : often_enough) {
    return finish(failure(OutcomeKind::kTimeout, progress() + ", then nothing more came"));
  }
  // A server may repeat its old answer to a known number instead of a new burst: take a new number.
  if (asked == Opcode::kBurstreadfile) take_next_number();
  ++transfer.sent;
  send_last(now);
}

std::optional<Time> FtpExchange::deadline() const {
  if (!transfer_) return std::nullopt;
  return std::min(transfer_->deadline, transfer_->give_up);
}

void FtpExchange::give_up(const Outcome& outcome) {
  if (transfer_) finish(outcome);
}

void FtpExchange::refuse(const std::string& why) {
  finish(failure(OutcomeKind::kRefused, progress() + ": " + why));
}

void FtpExchange::finish(const Outcome& outcome) {
  const Transfer ended = std::move(*transfer_);
  transfer_.reset();    // the callback may begin another one
  if (ended.session) {  // whether this one arrives is not waited for
    send_(ftp_message(
        {.seq = ++seq_, .session = *ended.session, .opcode = Opcode::kTerminatesession}));
  }
  ended.done(outcome, ended.result);
}

/// "reading '/log/a.ulg', 478 of 1000 bytes".
std::string FtpExchange::progress() const {
  const Transfer& transfer = *transfer_;
  std::string text = transfer.doing;
  if (!transfer.path.empty()) text += " '" + transfer.path + "'";
  if (transfer.length) {
    std::uint32_t missing = 0;
    for (const auto& [begin, end] : transfer.gaps) missing += end - begin;
    text += ", " + std::to_string(*transfer.length - missing) + " of " +
            std::to_string(*transfer.length) + " bytes";
  } else if (!transfer.result.bytes.empty()) {
    text += ", " + std::to_string(transfer.written) + " of " +
            std::to_string(transfer.result.bytes.size()) + " bytes";
  }
  return text;
}

}  // namespace cas::mav::services
