// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/emulator/emulator.hpp"

#include <unistd.h>

#include <array>
#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <csignal>
#include <vector>

#include "base/error.hpp"
#include "base/measure/ledger.hpp"
#include "base/os/command_port.hpp"
#include "base/os/log.hpp"
#include "base/os/pty.hpp"
#include "base/rpc/io_thread.hpp"
#include "base/time/clock.hpp"
#include "base/time/stream_clock.hpp"
#include "fcu/emulator/emulator_control.hpp"
#include "fcu/emulator/served_folder.hpp"
#include "fcu/flight_controller.hpp"
#include "fcu/line/line_model.hpp"
#include "fcu/params/param_file.hpp"
#include "mavlink/common/hil_sensor.hpp"
#include "mavlink_gen/runtime/codec.hpp"

namespace cas::fcu {

namespace asio = boost::asio;
using base::Duration;
using base::RunTime;

namespace {

constexpr Duration kTick = std::chrono::milliseconds(5);
constexpr Duration kSaveDelay = std::chrono::milliseconds(300);
constexpr Duration kReplugPause = std::chrono::milliseconds(200);

}  // namespace

struct Emulator::Impl final : EmulatorView {
  Impl(const FcuConfig& configuration, EmulatorOptions emulator_options)
      : config(configuration),
        options(std::move(emulator_options)),
        pty(options.link),
        line(config.line, config.seed),
        master(io),
        timer(io),
        replug_timer(io),
        signals(io, SIGINT, SIGTERM) {
    if (options.files) files.emplace(*options.files);
    if (options.params) saved = ParamFile(*options.params).load();
    make_controller();
    if (options.control) {
      control = base::bind_command_port(
          [this] { return std::make_unique<EmulatorControl>(io, *this, *options.control); });
    }
    attach();
  }

  // EmulatorView
  FlightController& controller() override { return *fcu; }
  EmulatorLine& serial_line() override { return line; }
  const base::Histogram& update_time() const override { return update; }
  void hang_up(Duration length) override;
  std::string endpoints() const override;

  void make_controller();
  void save_params();
  void attach();
  void begin();
  void wait_readable();
  void wait_writable();
  void read_master();
  void take(std::span<const std::uint8_t> bytes, RunTime now);
  RunTime stream_time(const mav::PacketView& packet);
  void pump();
  void write_master();
  void arm_timer();
  void plug_in_after(Duration pause);
  void plug_in();
  void reboot();
  void finish();

  FcuConfig config;
  EmulatorOptions options;
  asio::io_context io{1};
  base::Pty pty;
  EmulatorLine line;
  std::optional<ServedFolder> files;
  std::unique_ptr<FlightController> fcu;
  asio::posix::stream_descriptor master;
  asio::steady_timer timer;
  asio::steady_timer replug_timer;
  asio::signal_set signals;
  std::unique_ptr<EmulatorControl> control;
  base::StreamClock stream;  // lockstep: the controller's clock
  base::PacketLedger ledger{0};
  base::Histogram update;
  std::vector<std::uint8_t> outgoing;  // arrived at this end of the line, not yet taken by the PTY
  RunTime next_tick{};
  std::optional<RunTime> armed_for;     // when the timer is set to go off
  std::vector<ParamFile::Entry> saved;  // values to start with
  std::uint64_t saved_revision = 0;
  std::optional<RunTime> save_at;
  bool reading = false;
  bool writing = false;
  bool plug_in_failed = false;  // the reason is in the log
};

// Set-up.

void Emulator::Impl::make_controller() {
  fcu = std::make_unique<FlightController>(config, [this](std::span<const std::uint8_t> packet) {
    line.send(packet, base::steady_now());
  });
  for (const ParamFile::Entry& entry : saved) {
    if (!fcu->set_param(entry.name, entry.value)) {
      base::log::warn("saved parameter " + entry.name + " is not taken");
    }
  }
  if (files) fcu->serve(*files);
  saved_revision = fcu->params_revision();
  if (!options.ledger) return;
  fcu->set_hil_observer([this](std::uint32_t id, std::uint64_t time_usec, bool sent) {
    const RunTime now = base::steady_now();
    sent ? ledger.sent(id, time_usec, now) : ledger.received(id, time_usec, now);
  });
}

void Emulator::Impl::save_params() {
  save_at.reset();
  if (!options.params || fcu->params_revision() == saved_revision) return;
  saved_revision = fcu->params_revision();
  if (!ParamFile(*options.params).save(fcu->params_text())) {
    base::log::warn("cannot save the parameters to " + options.params->string());
  }
}

void Emulator::Impl::attach() {
  master.assign(::dup(pty.master()));
  wait_readable();
}

std::string Emulator::Impl::endpoints() const {
  return "pty " + pty.slave_name() + " link " + pty.link().string();
}

// The loop.

/// Waits for all that may come: at first, and after a handler has lacked memory.
void Emulator::Impl::begin() {
  signals.cancel();
  signals.async_wait([this](const boost::system::error_code& error, int) {
    if (!error) io.stop();
  });
  if (control) control->begin();
  if (master.is_open()) {
    master.cancel();
    reading = writing = false;
    wait_readable();
  } else {
    plug_in_after(kReplugPause);
  }
  armed_for.reset();
  pump();
}

void Emulator::Impl::wait_readable() {
  if (reading || !master.is_open()) return;
  reading = true;
  master.async_wait(asio::posix::stream_descriptor::wait_read,
                    [this](const boost::system::error_code& error) {
                      if (error == asio::error::operation_aborted) return;
                      reading = false;
                      if (error) return;
                      read_master();
                      pump();
                    });
}

void Emulator::Impl::read_master() {
  // Read no more than the line has room for: the rest stays in the terminal and holds the peer
  // back.
  std::array<std::uint8_t, 4096> buffer;
  const RunTime now = base::steady_now();
  const std::size_t room = std::min(line.up_room(now), buffer.size());
  if (room == 0) return;  // the timer comes back when there is
  const ssize_t n = ::read(master.native_handle(), buffer.data(), room);
  if (n > 0) line.receive(std::span(buffer).first(static_cast<std::size_t>(n)), now);
}

void Emulator::Impl::take(std::span<const std::uint8_t> bytes, RunTime now) {
  if (config.pace == Pace::kRealtime) return fcu->on_bytes(bytes, now);
  fcu->on_bytes(bytes, [this](const mav::PacketView& packet) { return stream_time(packet); });
}

/// Lockstep: time goes on with the sensors, so the controller does the same in each run however the
/// bytes were cut on their way. It makes its own ticks, one with each answer.
RunTime Emulator::Impl::stream_time(const mav::PacketView& packet) {
  using mavlink::common::HilSensor;
  if (const auto sensor = mav::decode<HilSensor>(packet)) stream.on_sensor(sensor->time_usec);
  return stream.now();
}

void Emulator::Impl::pump() {
  const RunTime now = base::steady_now();
  std::array<std::uint8_t, 4096> buffer;
  while (const std::size_t n = line.up(buffer, now)) {
    const RunTime begin = base::steady_now();
    take(std::span(buffer).first(n), begin);
    update.add(base::steady_now() - begin);
  }
  if (now >= next_tick) {
    if (config.pace == Pace::kRealtime) fcu->tick(now);
    next_tick = now + kTick;
    pty.refresh_lock();
    if (fcu->params_revision() != saved_revision && !save_at) save_at = now + kSaveDelay;
    if (save_at && now >= *save_at) save_params();
  }
  if (fcu->take_reboot_request()) reboot();
  const RunTime sent_by = base::steady_now();
  while (const std::size_t n = line.down(buffer, sent_by)) {
    outgoing.insert(outgoing.end(), buffer.begin(),
                    buffer.begin() + static_cast<std::ptrdiff_t>(n));
  }
  write_master();
  if (line.up_room(now) > 0) wait_readable();
  arm_timer();
}

void Emulator::Impl::write_master() {
  if (outgoing.empty()) return;
  if (!master.is_open()) return outgoing.clear();
  const ssize_t n = ::write(master.native_handle(), outgoing.data(), outgoing.size());
  if (n > 0) outgoing.erase(outgoing.begin(), outgoing.begin() + n);
  if (outgoing.empty()) return;
  // The peer does not read and the terminal is full: the line drops whole packets from now on.
  line.hold(true);
  wait_writable();
}

void Emulator::Impl::wait_writable() {
  if (writing || !master.is_open()) return;
  writing = true;
  master.async_wait(asio::posix::stream_descriptor::wait_write,
                    [this](const boost::system::error_code& error) {
                      if (error == asio::error::operation_aborted) return;
                      writing = false;
                      if (error) return;
                      line.hold(false);
                      write_master();
                      pump();
                    });
}

void Emulator::Impl::arm_timer() {
  const RunTime now = base::steady_now();
  RunTime next = next_tick;
  if (const auto arrival = line.next_event(now)) next = std::min(next, *arrival);
  if (next == armed_for) return;  // setting it again costs two system calls with each packet
  armed_for = next;
  timer.expires_at(asio::steady_timer::time_point(next.time_since_epoch()));
  timer.async_wait([this](const boost::system::error_code& error) {
    if (error) return;
    armed_for.reset();
    if (line.up_room(base::steady_now()) > 0) read_master();
    pump();
  });
}

void Emulator::Impl::hang_up(Duration length) {
  boost::system::error_code ignored;
  master.close(ignored);
  reading = writing = false;
  pty.hang_up();
  line.hang_up();
  outgoing.clear();
  base::log::info("line hung up");
  plug_in_failed = false;
  plug_in_after(length);
}

void Emulator::Impl::plug_in_after(Duration pause) {
  replug_timer.expires_after(pause);
  replug_timer.async_wait([this](const boost::system::error_code& error) {
    if (!error) plug_in();
  });
}

void Emulator::Impl::plug_in() {
  try {
    pty.open();
  } catch (const base::ConfigError& error) {
    if (!plug_in_failed)
      base::log::error("line stays down until this is mended: " + std::string(error.what()));
    plug_in_failed = true;
    return plug_in_after(kReplugPause);
  }
  line.restore();
  attach();
  base::log::info("line is back: " + endpoints());
}

void Emulator::Impl::reboot() {
  base::log::info("reboot by command");
  save_params();
  // Everything is forgotten but the parameters.
  saved = ParamFile::parse(fcu->params_text());
  make_controller();
}

void Emulator::Impl::finish() {
  save_params();
  if (options.stats) write_stats(*options.stats, *this);
  if (options.ledger) ledger.write(*options.ledger);
}

Emulator::Emulator(const FcuConfig& config, EmulatorOptions options)
    : impl_(std::make_unique<Impl>(config, std::move(options))) {}
Emulator::~Emulator() = default;

std::string Emulator::endpoints() const { return impl_->endpoints(); }

void Emulator::run() {
  base::rpc::run_context(impl_->io, "controller", [this] { impl_->begin(); });
  impl_->finish();
}

}  // namespace cas::fcu
