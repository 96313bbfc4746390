// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/services/ftp_server.hpp"

#include <algorithm>
#include <array>
#include <limits>

#include "mavlink_gen/services/address.hpp"

namespace cas::mav::services {

using mavlink::common::MavFtpErr;
using Opcode = mavlink::common::MavFtpOpcode;

namespace {

constexpr std::size_t kMaxRequests = 16;               // requests,
constexpr std::size_t kMaxSums = 4;                    // of them for checksums
constexpr std::size_t kMaxAnswers = 32;                // that are kept,
constexpr std::size_t kMaxAnswersOfOne = 4;            // of one client,
constexpr Duration kForget = std::chrono::seconds(5);  // and for so long
constexpr std::size_t kChecksumBytes = 64U << 10U;     // of one update: a fraction of a millisecond

constexpr FtpFailure kOk{};

FtpFailure fail(MavFtpErr code) { return {.code = code}; }

/// Makes a NAK of an answer.
void refuse(FtpPayload& reply, const FtpFailure& failure) {
  reply.opcode = Opcode::kNak;
  reply.set_bytes(std::array{static_cast<std::uint8_t>(failure.code), failure.error_number});
  if (failure.code != MavFtpErr::kFailerrno) reply.size = 1;
}

std::string entry_text(const FtpEntry& entry) {
  std::string text = (entry.folder ? "D" : "F") + entry.name;
  if (!entry.folder) text += "\t" + std::to_string(entry.size);
  return text + '\0';
}

}  // namespace

std::optional<std::string> ftp_path(std::string_view text) {
  std::string path;
  while (!text.empty()) {
    const std::size_t slash = std::min(text.find('/'), text.size());
    const std::string_view part = text.substr(0, slash);
    text.remove_prefix(std::min(slash + 1, text.size()));
    if (part == "..") return std::nullopt;
    if (part.empty() || part == ".") continue;
    if (!path.empty()) path += '/';
    path += part;
  }
  return path;
}

bool FtpServer::is_for_sum(const Request& request) {
  return request.payload.opcode == Opcode::kCalcfilecrc;
}

void FtpServer::on_request(const Message& message, Source from, Time now) {
  const Request request{from, ftp_payload(message)};
  if (request.payload.is_answer()) return;  // of another server
  const bool under_way = std::ranges::find(waiting_, request) != waiting_.end() ||
                         (checksum_ && checksum_->request == request);
  const auto sums = std::ranges::count_if(waiting_, is_for_sum);
  const bool full = waiting_.size() == kMaxRequests ||
                    (is_for_sum(request) && sums == static_cast<std::ptrdiff_t>(kMaxSums));
  if (!under_way && !full) {
    waiting_.push_back(request);
  } else if (!under_way) {
    ++dropped_;
  }
  update(now);
}

void FtpServer::update(Time now) {
  if (checksum_) step_checksum(now);
  while (now >= due_) {
    // One checksum at a time: requests for others wait, the rest passes them.
    const auto next = std::ranges::find_if(
        waiting_, [&](const Request& each) { return !checksum_ || !is_for_sum(each); });
    if (next == waiting_.end()) break;
    const Request request = *next;
    waiting_.erase(next);
    answer(request, now);
  }
  if (now >= due_) send_burst(now);
}

void FtpServer::answer(const Request& request, Time now) {
  std::erase_if(answered_, [&](const Answered& each) { return now - each.at > kForget; });
  const auto known =
      std::ranges::find(answered_, request, [](const Answered& each) { return each.request; });
  if (known != answered_.end()) return send(known->answer, request.from, now);
  FtpPayload reply;
  reply.session = request.payload.session;
  reply.offset = request.payload.offset;
  const FtpFailure failure = perform(request, reply, now);
  const bool later = request.payload.opcode == Opcode::kBurstreadfile ||
                     request.payload.opcode == Opcode::kCalcfilecrc;
  if (!later || failure.failed()) conclude(request, reply, failure, now);
}

FtpFailure FtpServer::perform(const Request& request, FtpPayload& reply, Time now) {
  const FtpPayload& asked = request.payload;
  if (asked.size > kFtpDataBytes) return fail(MavFtpErr::kInvaliddatasize);
  Session* session = find(request, now);
  switch (asked.opcode) {
    case Opcode::kNone:
      return kOk;
    case Opcode::kResetsession:
      close(request.from, std::nullopt);
      if (checksum_ && checksum_->request.from == request.from) checksum_.reset();
      std::erase_if(waiting_, [&](const Request& each) {
        return each.from == request.from && is_for_sum(each);
      });
      return kOk;
    case Opcode::kListdirectory:
      return list(asked, reply);
    case Opcode::kOpenfilero:
    case Opcode::kCreatefile:
      return open(request, reply, now);
    case Opcode::kCalcfilecrc:
      return begin_checksum(request, now);
    case Opcode::kRemovefile: {
      const auto path = ftp_path(asked.text());
      return path ? store_.remove(*path) : fail(MavFtpErr::kFilenotfound);
    }
    case Opcode::kTerminatesession:
      if (session == nullptr) return fail(MavFtpErr::kInvalidsession);
      close(request.from, asked.session);
      return kOk;
    case Opcode::kReadfile:
      if (session == nullptr) return fail(MavFtpErr::kInvalidsession);
      return read(*session, asked.offset, asked.size, reply);
    case Opcode::kBurstreadfile:
      if (session == nullptr) return fail(MavFtpErr::kInvalidsession);
      return begin_burst(*session, asked);
    case Opcode::kWritefile:
      if (session == nullptr) return fail(MavFtpErr::kInvalidsession);
      return write(*session, asked);
    default:
      return fail(MavFtpErr::kUnknowncommand);
  }
}

/// As many entries as fit into a piece, at least one, from the one asked for on.
FtpFailure FtpServer::list(const FtpPayload& asked, FtpPayload& reply) {
  const auto folder = ftp_path(asked.text());
  if (!folder) return fail(MavFtpErr::kFilenotfound);
  if (asked.offset == 0 || !listing_ || listing_->folder != *folder) {
    listing_.reset();
    Listing fresh{.folder = *folder, .entries = {}};
    const FtpFailure failure = store_.list(*folder, fresh.entries);
    if (failure.failed()) return failure;
    listing_ = std::move(fresh);
  }
  const std::span<const FtpEntry> entries = listing_->entries;
  if (asked.offset >= entries.size()) return fail(MavFtpErr::kEof);
  const std::size_t most = std::min(limits_.piece_bytes, kFtpDataBytes);
  std::string text;
  for (const FtpEntry& entry : entries.subspan(asked.offset)) {
    std::string next = entry_text(entry);
    if (next.size() > kFtpDataBytes) next = std::string("S") + '\0';  // no room for its name
    if (!text.empty() && text.size() + next.size() > most) break;
    text += next;
  }
  reply.set_text(text);
  return kOk;
}

/// Opens a file for reading, or a new or truncated one for writing.
FtpFailure FtpServer::open(const Request& request, FtpPayload& reply, Time now) {
  const auto path = ftp_path(request.payload.text());
  if (!path) return fail(MavFtpErr::kFilenotfound);
  const std::uint8_t id = session_for(request);
  const bool again = is_open(request.from, id);
  const bool full = !again && sessions_.size() >= std::min<std::size_t>(limits_.sessions, 256);
  const auto oldest = std::ranges::min_element(sessions_, {}, &Session::used);
  if (full && (oldest == sessions_.end() || now - oldest->used < limits_.idle_after)) {
    return fail(MavFtpErr::kNosessionsavailable);
  }
  const bool writing = request.payload.opcode == Opcode::kCreatefile;
  std::uint32_t length = 0;
  const FtpFailure failure = writing ? store_.create(*path) : store_.length(*path, length);
  if (failure.failed()) return failure;
  if (full) sessions_.erase(oldest);
  if (again) close(request.from, id);
  reply.session = id;
  if (!writing) reply.set_number(length);
  sessions_.push_back(
      {.owner = request.from, .id = reply.session, .path = *path, .writing = writing, .used = now});
  return kOk;
}

bool FtpServer::is_open(Source owner, std::uint8_t id) const {
  return std::ranges::any_of(sessions_, [&](const Session& session) {
    return session.owner == owner && session.id == id;
  });
}

/// Some clients count their sessions themselves and use the number that they named; one that names
/// an open one has lost track of it. Most name 0 always and use the number of the answer.
std::uint8_t FtpServer::session_for(const Request& request) const {
  std::uint8_t id = request.payload.session;
  if (id != 0) return id;
  for (int taken = 0; taken < 256 && is_open(request.from, id); ++taken) ++id;
  return id;
}

FtpFailure FtpServer::read(const Session& session, std::uint32_t offset, std::size_t size,
                           FtpPayload& reply) {
  // Offsets have 32 bits: the rest of a longer file is out of reach.
  const std::size_t reachable = std::numeric_limits<std::uint32_t>::max() - offset;
  std::array<std::uint8_t, kFtpDataBytes> buffer{};
  std::span<std::uint8_t> bytes = std::span(buffer).first(std::min(size, reachable));
  const FtpFailure failure = store_.read(session.path, offset, bytes);
  if (failure.failed()) return failure;
  if (bytes.empty() && size > 0) return fail(MavFtpErr::kEof);
  reply.set_bytes(bytes);
  return kOk;
}

FtpFailure FtpServer::write(const Session& session, const FtpPayload& asked) {
  if (!session.writing) return fail(MavFtpErr::kFileprotected);
  return store_.write(session.path, asked.offset, asked.bytes());
}

FtpFailure FtpServer::begin_burst(Session& session, const FtpPayload& asked) {
  session.burst = asked;
  if (asked.size == 0) session.burst->size = kFtpDataBytes;
  ++session.burst->seq;
  session.burst_left = std::max<std::size_t>(1, limits_.burst_packets);
  return kOk;
}

/// One packet of a burst, of each session in turn.
void FtpServer::send_burst(Time now) {
  for (std::size_t i = 0; i < sessions_.size(); ++i) {
    Session& session = sessions_[(next_burst_ + i) % sessions_.size()];
    if (!session.burst) continue;
    session.used = now;
    next_burst_ = (next_burst_ + i + 1) % sessions_.size();
    FtpPayload& at = *session.burst;
    FtpPayload reply{.seq = at.seq++,
                     .session = session.id,
                     .opcode = Opcode::kAck,
                     .req_opcode = Opcode::kBurstreadfile,
                     .offset = at.offset};
    const std::size_t piece = std::clamp<std::size_t>(limits_.piece_bytes, 1, at.size);
    const FtpFailure failure = read(session, at.offset, piece, reply);
    if (session.burst_left > 0) --session.burst_left;
    const bool enough = session.burst_left == 0 && reply.size == at.size;
    reply.burst_complete = failure.failed() || enough;
    if (failure.failed()) refuse(reply, failure);
    at.offset += reply.size;
    const Source to = session.owner;
    if (reply.burst_complete) session.burst.reset();
    return send(reply, to, now);
  }
}

FtpFailure FtpServer::begin_checksum(const Request& request, Time now) {
  const auto path = ftp_path(request.payload.text());
  if (!path) return fail(MavFtpErr::kFilenotfound);
  std::uint32_t length = 0;
  if (const FtpFailure failure = store_.length(*path, length); failure.failed()) return failure;
  checksum_ = {.request = request, .path = *path, .length = length};
  step_checksum(now);
  return kOk;
}

void FtpServer::step_checksum(Time now) {
  const std::size_t left = checksum_->length - checksum_->offset;
  std::vector<std::uint8_t> buffer(std::min(kChecksumBytes, left));
  std::span<std::uint8_t> bytes(buffer);
  const FtpFailure failure = store_.read(checksum_->path, checksum_->offset, bytes);
  checksum_->crc = ftp_crc32(bytes, checksum_->crc);
  checksum_->offset += static_cast<std::uint32_t>(bytes.size());
  if (!failure.failed() && bytes.size() == kChecksumBytes && left > kChecksumBytes) return;
  const Checksum ended = *std::exchange(checksum_, std::nullopt);
  FtpPayload reply;
  reply.set_number(ended.crc);
  conclude(ended.request, reply, failure, now);
}

/// The session that a request names, if its sender opened it.
FtpServer::Session* FtpServer::find(const Request& request, Time now) {
  for (Session& session : sessions_) {
    if (session.id != request.payload.session || session.owner != request.from) continue;
    session.used = now;
    return &session;
  }
  return nullptr;
}

/// @param id  of the session; nullopt: all of this owner
void FtpServer::close(Source owner, std::optional<std::uint8_t> id) {
  std::erase_if(sessions_, [&](const Session& session) {
    return session.owner == owner && (!id || session.id == *id);
  });
}

/// Sends the answer to a request, and keeps it for when the request comes again.
void FtpServer::conclude(const Request& request, FtpPayload reply, const FtpFailure& failure,
                         Time now) {
  reply.seq = static_cast<std::uint16_t>(request.payload.seq + 1);
  reply.req_opcode = request.payload.opcode;
  reply.opcode = Opcode::kAck;
  if (failure.failed()) refuse(reply, failure);
  const auto his = [&](const Answered& each) { return each.request.from == request.from; };
  if (std::ranges::count_if(answered_, his) == kMaxAnswersOfOne) {
    answered_.erase(std::ranges::find_if(answered_, his));
  }
  if (answered_.size() == kMaxAnswers) answered_.pop_front();
  answered_.push_back({request, reply, now});
  send(reply, request.from, now);
}

void FtpServer::send(const FtpPayload& payload, Source to, Time now) {
  const auto bytes = static_cast<double>(send_(addressed(ftp_message(payload), to)));
  if (limits_.bytes_per_s <= 0) return;
  const std::chrono::duration<double> taken(bytes / limits_.bytes_per_s);
  due_ = std::max(due_, now) + std::chrono::duration_cast<Duration>(taken);
}

}  // namespace cas::mav::services
