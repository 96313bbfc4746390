// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/common/serial_wire.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <utility>

#include "base/error.hpp"
#include "base/os/log.hpp"
#include "base/os/pty_lock.hpp"
#include "base/os/serial_settings.hpp"

namespace cas::sim {
namespace {

constexpr base::Duration kBetweenTries = std::chrono::seconds(1);

std::size_t asked_bytes(int fd, unsigned long request) {
  int bytes = 0;
  return fd >= 0 && ::ioctl(fd, request, &bytes) == 0 && bytes > 0 ? static_cast<std::size_t>(bytes)
                                                                   : 0;
}

bool would_block(int error) { return error == EAGAIN || error == EWOULDBLOCK || error == EINTR; }

}  // namespace

std::unique_ptr<SerialWire> SerialWire::make(const base::ConfigNode& node, unsigned baud) {
  const auto pty = node.find("pty");
  const auto device = node.find("device");
  if (pty && device) device->fail("stands for the line; so does pty");
  const bool unlocked = node.get("unlocked_pty", false);
  if (pty) return make_pty(*pty);
  return open_device(device ? *device : node.at("device"), baud, unlocked);
}

std::unique_ptr<SerialWire> SerialWire::make_pty(const base::ConfigNode& link) {
  std::unique_ptr<SerialWire> wire(new SerialWire());
  const auto path = link.as<std::string>();
  try {
    wire->pty_.emplace(path);
  } catch (const base::ConfigError& error) {
    link.fail(error.what());
  }
  wire->endpoint_ = "pty " + path;
  return wire;
}

std::unique_ptr<SerialWire> SerialWire::open_device(const base::ConfigNode& device, unsigned baud,
                                                    bool unlocked_pty) {
  std::unique_ptr<SerialWire> wire(new SerialWire());
  wire->path_ = device.as<std::string>();
  wire->baud_ = baud;
  wire->unlocked_pty_ = unlocked_pty;
  wire->endpoint_ = "serial " + wire->path_;
  if (const std::string why = wire->open(); !why.empty()) {
    if (std::filesystem::exists(wire->path_)) device.fail(why);
    base::log::warn(wire->endpoint_ + ": not there; it is tried again once a second");
  }
  return wire;
}

std::string SerialWire::open() {
  base::Descriptor line(::open(path_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!line) return path_ + ": " + base::error_text(errno);
  if (!unlocked_pty_ && base::identify_pty(line.get()) &&
      base::pty_offer(path_, line.get()) != base::PtyOffer::kThis) {
    return path_ +
           " is a pseudo-terminal that no program of CAS offers; `pty` makes one, "
           "`unlocked_pty: true` takes it";
  }
  if (::flock(line.get(), LOCK_EX | LOCK_NB) != 0) {
    return path_ + " is in use: " + base::error_text(errno);
  }
  if (!base::make_serial_raw(line.get(), baud_)) {
    return path_ + " is no terminal: " + base::error_text(errno);
  }
  base::ask_serial_low_latency(line.get());
  base::flush_serial(line.get());
  device_ = std::move(line);
  return {};
}

void SerialWire::lose(int error) {
  ++counts_.lost_lines;
  base::log::error(endpoint_ + ": the line is gone (" + base::error_text(error) +
                   "); it is tried again once a second");
  device_.reset();
  rest_.clear();
  look_again_.reset();
}

void SerialWire::try_again(base::RunTime now) {
  if (look_again_ && now < *look_again_) return;
  look_again_ = now + kBetweenTries;
  if (open().empty()) base::log::info(endpoint_ + ": the line is back");
}

std::span<const std::uint8_t> SerialWire::read(base::RunTime now) {
  if (!is_up()) try_again(now);
  if (!is_up()) return {};
  const ssize_t size = ::read(descriptor(), buffer_.data(), buffer_.size());
  if (size > 0) return std::span(buffer_).first(static_cast<std::size_t>(size));
  const bool has_gone = size == 0 || !would_block(errno);
  if (has_gone && !pty_) lose(size == 0 ? EIO : errno);
  return {};
}

bool SerialWire::ready() {
  if (!is_up()) return false;
  if (!rest_.empty()) write(std::exchange(rest_, {}));
  return rest_.empty() && is_up();
}

void SerialWire::write(std::span<const std::uint8_t> bytes) {
  if (bytes.empty()) return;
  const ssize_t size = ::write(descriptor(), bytes.data(), bytes.size());
  if (size < 0 && !would_block(errno)) {
    ++counts_.write_errors;
    if (!pty_) lose(errno);
    return;
  }
  const auto rest = bytes.subspan(size > 0 ? static_cast<std::size_t>(size) : 0);
  rest_.assign(rest.begin(), rest.end());
}

std::size_t SerialWire::unsent() const { return pty_ ? 0 : asked_bytes(device_.get(), TIOCOUTQ); }

std::size_t SerialWire::unread() const { return pty_ ? asked_bytes(pty_->slave(), FIONREAD) : 0; }

}  // namespace cas::sim
