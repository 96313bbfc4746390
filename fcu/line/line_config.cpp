// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/line/line_config.hpp"

#include <chrono>

#include "base/config/config_whole.hpp"

namespace cas::fcu {
namespace {

using namespace std::chrono_literals;

/// A UART with the driver's send buffer and receive ring of a flight controller's.
LineConfig uart(const std::string& name, double baud) {
  LineConfig line;
  line.preset = name;
  line.baud = baud;
  line.send_buffer_bytes = 4096;
  line.receive_fifo_bytes = 4096;
  return line;
}

base::Duration microseconds(const base::ConfigNode& node, std::string_view key,
                            base::Duration fallback) {
  constexpr double kHour_us = 3.6e9;
  return base::from_seconds(1e-6 * node.get_in(key, 1e6 * base::to_seconds(fallback), 0, kHour_us));
}

}  // namespace

LineConfig LineConfig::from_preset(const std::string& name) {
  if (name == "ideal") return {};
  if (name == "baud_921600") return uart(name, 921600);
  if (name == "baud_460800") return uart(name, 460800);
  if (name == "baud_115200") return uart(name, 115200);
  if (name == "usb") {
    LineConfig line;
    line.preset = name;
    line.baud = 12e6 / 8 * 10 * 0.8;  // full speed, protocol overhead taken off
    line.batch = 1ms;
    line.send_buffer_bytes = 16384;
    line.receive_fifo_bytes = 16384;
    return line;
  }
  throw base::ConfigError("line preset '" + name +
                          "' is unknown; there are ideal, usb, baud_921600, baud_460800, "
                          "baud_115200");
}

LineConfig LineConfig::parse(const base::ConfigNode& node) {
  LineConfig line;
  const auto preset = node.get<std::string>("preset", "ideal");
  try {
    line = from_preset(preset);
  } catch (const base::ConfigError& error) {
    node.at("preset").fail(error.what());
  }
  line.baud = node.get_in("baud", line.baud, 0, 100e6);
  line.clock_drift_ppm = node.get_in("clock_drift_ppm", line.clock_drift_ppm, -50000, 50000);
  line.extra_delay = microseconds(node, "extra_delay_us", line.extra_delay);
  line.jitter = microseconds(node, "jitter_us", line.jitter);
  line.batch = microseconds(node, "batch_us", line.batch);
  line.stall_every = microseconds(node, "stall_every_us", line.stall_every);
  line.stall_length = microseconds(node, "stall_length_us", line.stall_length);
  line.bit_error_rate = node.get_in("bit_error_rate", line.bit_error_rate, 0, 0.5);
  line.burst_begin = node.get_in("burst_begin", line.burst_begin, 0, 1);
  line.burst_end = node.get_in("burst_end", line.burst_end, 1e-9, 1);
  line.burst_loss = node.get_in("burst_loss", line.burst_loss, 0, 1);
  line.packet_loss = node.get_in("packet_loss", line.packet_loss, 0, 1);
  const auto get_bytes = [&node](std::string_view key, std::size_t fallback, std::size_t least) {
    return base::get_whole_in<std::size_t>(node, key, fallback, least, 1'000'000'000);
  };
  line.send_buffer_bytes = get_bytes("send_buffer_bytes", line.send_buffer_bytes, 0);
  line.receive_fifo_bytes = get_bytes("receive_fifo_bytes", line.receive_fifo_bytes, 0);
  line.receive_trigger_bytes = get_bytes("receive_trigger_bytes", line.receive_trigger_bytes, 1);
  node.reject_unused();
  return line;
}

}  // namespace cas::fcu
