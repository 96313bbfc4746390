// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/serial_link.hpp"

#include <poll.h>
#include <unistd.h>

#include <fmt/format.h>
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <span>
#include <string>
#include <utility>

#include "base/error.hpp"
#include "base/os/pty_lock.hpp"
#include "base/os/serial_settings.hpp"
#include "casd/link/blocking_tx_port.hpp"
#include "casd/link/turn_meter.hpp"
#include "casd/transport/serial_device.hpp"
#include "casd/transport/stream_writer.hpp"

namespace cas::casd {
namespace {

constexpr std::size_t kLineReadBytes = 16 * 1024;
constexpr int kBlockingPatience_ms = kBlockingPatience / std::chrono::milliseconds(1);
// Faster changes in the folder of a missing device are handled together.
constexpr base::Duration kBetweenLooks = std::chrono::milliseconds(10);
// A line that breaks sooner is reopened only then: it may break each time.
constexpr base::Duration kLeastLineUptime = std::chrono::milliseconds(50);

}  // namespace

SerialLink::SerialLink(LinkContext context)
    : core_(std::move(context)),
      port_(core_.make_port()),
      path_watch_(core_.config().device),
      search_(core_.config().baud),
      parser_(make_parser()),
      buffer_(kLineReadBytes) {}

void SerialLink::watch(PollSet& set, base::RunTime) {
  if (!fd_) {
    set.wake_by(core_.backoff().next());
    poll_entry_ = set.add(path_watch_.descriptor(), POLLIN);
    return;
  }
  if (unattached_) {
    poll_entry_ = set.add(fd_, POLLIN);
    set.wake_by(search_.due());
    return;
  }
  poll_entry_ = set.add(fd_, static_cast<short>(POLLIN | (port_->wants_room() ? POLLOUT : 0)));
  set.wake_by(port_->due());
  set.wake_by(pause_.due());
  set.wake_by(core_.next_second());
}

void SerialLink::serve(const PollSet& set, base::RunTime now) {
  const short events = set.revents(poll_entry_);
  if (!fd_) {
    if ((events & POLLIN) != 0 && path_watch_.take_changes()) {
      core_.backoff().reset();
      core_.backoff().look_at(std::max(now, tried_at_ + kBetweenLooks));
    }
    if (core_.backoff().due(now)) open(now);
    return;
  }
  if (unattached_) return listen(events, now);
  if ((events & (POLLIN | POLLHUP | POLLERR)) != 0) {
    core_.blocking() ? read_blocking(now) : read(now);
  }
  if (fd_ && port_->broken()) close("writing failed", now);
  if (fd_ && ((events & POLLOUT) != 0 || port_->due() <= now)) port_->carry_on(now);
  if (fd_ && pause_.due() <= now) end_pause(now);
  if (!core_.second_due(now)) return;
  core_.on_second(now);
  if (fd_ && port_->wants_room()) port_->carry_on(now);  // it may stand still for good
}

void SerialLink::open(base::RunTime now) {
  const LinkConfig& config = core_.config();
  SerialRefusal refusal;
  base::Descriptor line;
  tried_at_ = now;
  search_.begin(now);
  const bool found = path_watch_.found_by([&] {
    line = open_serial(config.device,
                       {.baud = search_.rate(),
                        .flow_control = config.flow_control,
                        .unlocked_pty = config.unlocked_pty},
                       refusal);
    return static_cast<bool>(line);
  });
  if (!found) return core_.went_down(refusal.sentence, now);
  fd_ = OpenDescriptor(line.get());
  opened_at_ = now;
  parser_.reset();
  if (search_.found()) return begin(std::move(line), now);
  unattached_ = std::move(line);
  core_.went_down(
      config.device + ": listens for MAVLink at " + words_of_rates(config.baud) + " baud", now);
}

/// Searches the rate at which packets come.
void SerialLink::listen(short events, base::RunTime now) {
  if ((events & (POLLIN | POLLHUP | POLLERR)) != 0) {
    const ssize_t count = ::read(fd_.get(), buffer_.data(), buffer_.size());
    if (count == 0) return close("hung up", now);
    if (count < 0 && errno != EAGAIN && errno != EINTR) return close(base::error_text(errno), now);
    const std::span bytes(buffer_.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    std::size_t packets = 0;
    parser_.feed(bytes, [&](const mav::PacketView&) { ++packets; });
    if (search_.heard(packets)) {
      begin(std::move(unattached_), now);
      parser_.reset();
      core_.ingress().take(parser_, bytes, now);
      core_.ingress().deliver(now);
      return;
    }
  }
  if (!search_.advance(now)) return;
  parser_.reset();
  if (!base::set_serial_baud(fd_.get(), search_.rate())) close(base::error_text(errno), now);
}

/// The rate is known: packets go both ways from now on.
void SerialLink::begin(base::Descriptor line, base::RunTime now) {
  const LinkConfig& config = core_.config();
  const unsigned baud = search_.rate();
  const OpenDescriptor opened = std::exchange(fd_, {});  // until the port has the line
  // A pseudo-terminal has no line, and its count of unsent bytes no meaning.
  const bool pty = base::identify_pty(opened.get()).has_value();
  const auto kind = pty ? StreamWriter::Kind::kPseudoTerminal : StreamWriter::Kind::kSerial;
  const bool has_rate = !pty || config.pace_pty || core_.blocking();
  port_->attach(std::make_unique<StreamWriter>(std::move(line), kind), now,
                has_rate ? paced_bytes_s(config, baud) : 0);
  fd_ = opened;
  core_.counters().baud.set(baud);
  core_.went_up(config.device + (baud > 0 ? fmt::format(" {}", baud) : ""));
}

void SerialLink::read(base::RunTime now) {
  const ssize_t count = ::read(fd_.get(), buffer_.data(), buffer_.size());
  if (count > 0) {
    port_->heard(now);
    const std::uint64_t before = parser_.stats().packets;
    core_.ingress().take(parser_, {buffer_.data(), static_cast<std::size_t>(count)}, now);
    core_.ingress().deliver(now);
    pause_.after_read(parser_, now);
    return check_rate(static_cast<std::size_t>(count), before, now);
  }
  if (count < 0 && (errno == EAGAIN || errno == EINTR)) return;
  close(count == 0 ? "hung up" : base::error_text(errno), now);
}

/// The vehicle may have come back from a restart with another rate.
void SerialLink::check_rate(std::size_t bytes, std::uint64_t packets_before, base::RunTime now) {
  if (search_.fits(bytes, parser_.stats().packets - packets_before, now)) return;
  close(fmt::format("no packets at {} baud any more", search_.rate()), now);
}

// Reads byte by byte and waits for the rest of a packet that has begun, as programs with one thread
// do (MAVLink's own C examples among them).
void SerialLink::read_blocking(base::RunTime now) {
  bool waited = false;
  const std::uint64_t before = parser_.stats().packets;
  std::size_t bytes = 0;
  do {
    const ssize_t count = ::read(fd_.get(), buffer_.data(), 1);
    if (count > 0) {
      ++bytes;
      port_->heard(now);
      core_.ingress().take(parser_, {buffer_.data(), 1}, now);
    } else if (count < 0 && (errno == EAGAIN || errno == EINTR)) {
      pollfd more{fd_.get(), POLLIN, 0};
      waited = true;
      count_wanted_wait();
      if (!parser_.inside_packet() || ::poll(&more, 1, kBlockingPatience_ms) <= 0) break;
    } else {
      core_.ingress().deliver(now);
      return close(count == 0 ? "hung up" : base::error_text(errno), now);
    }
  } while (!waited || parser_.inside_packet());
  core_.ingress().deliver(now);
  pause_.after_read(parser_, now);
  check_rate(bytes, before, now);
}

void SerialLink::end_pause(base::RunTime now) {
  pause_.release(core_.ingress(), parser_,
                 [&](const mav::PacketView& packet) { core_.ingress().take_packet(packet, now); });
  core_.ingress().deliver(now);
}

void SerialLink::close(const std::string& reason, base::RunTime now) {
  fd_ = {};
  unattached_.reset();
  port_->detach(now);
  core_.went_down(reason, now);
  // The device may have come back before its path was watched.
  core_.backoff().look_at(std::max(now, opened_at_ + kLeastLineUptime));
}

}  // namespace cas::casd
