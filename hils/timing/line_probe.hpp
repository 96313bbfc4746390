// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "hils/timing/echo_stage.hpp"
#include "hils/timing/flood_stage.hpp"
#include "hils/timing/line_demand.hpp"
#include "hils/timing/load_stage.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"

namespace cas::hils {

/// Plan of a measurement.
struct ProbePlan {
  LineDemand demand{};
  base::Duration length = std::chrono::milliseconds(1500);  ///< of each stage
  std::uint64_t seed = 1;
};

/// Why a measurement ended early.
enum class ProbeEnd { kWhole, kSilent, kArmed, kNoAnswers };

/// The figures of a line.
struct LineFigures {
  ProbeEnd end = ProbeEnd::kWhole;
  mav::Source autopilot{};
  bool in_hil = false;
  double background_bytes_s = 0;  ///< board's own messages, without HIL answers
  EchoFigures ping{};
  EchoFigures timesync{};
  QuestionKind asked = QuestionKind::kPing;  ///< of throughput and load
  std::optional<base::Duration> frame{};     ///< arrival_frame() of the answers
  double to_bytes_s = 0;                     ///< throughput to the board
  double from_bytes_s = 0;                   ///< throughput from it
  std::vector<LoadFigures> loads{};          ///< rising, up to the first that the line did not keep
  std::vector<LoadFigures> slower{};         ///< rates tried instead, falling, up to one that fits
  std::uint64_t crc_errors = 0;
};

/// Measures a line to an autopilot: when to send which packet, and figures of the answers. Pure:
/// bytes and time in, bytes out.
///
///   listen --> PING --> TIMESYNC --> flood to the board, from it --> load 25, 50 ... 150 %
///                                                      `--> slower rates, where 100 % is too much
///
/// The probe sends HEARTBEAT, PING, TIMESYNC and V2_EXTENSION (ProbePackets), nothing that an
/// autopilot acts on, and ends at once when the autopilot is armed.
class LineProbe {
 public:
  LineProbe(const ProbePlan& plan, base::RunTime begin);

  /// Sends due packets and moves from stage to stage.
  void turn(base::RunTime now);
  /// Bytes off the line.
  void take(std::span<const std::uint8_t> bytes, base::RunTime now);
  /// Bytes to write.
  std::span<const std::uint8_t> unsent() const { return line_.packets.bytes(); }
  void sent(std::size_t bytes) { line_.packets.drop_first(bytes); }
  /// When to call turn() at the latest.
  base::RunTime wake() const;

  bool done() const { return phase_ == Phase::kDone; }
  /// Once it is done.
  const LineFigures& figures() const { return figures_; }

 private:
  enum class Phase {
    kListen,
    kBackground,
    kPing,
    kTimesync,
    kFloodTo,
    kFloodFrom,
    kLoad,
    kSlower,
    kDone
  };

  void on_packet(const mav::PacketView& packet, base::RunTime now);
  void on_heartbeat(const mav::PacketView& packet, base::RunTime now);
  void listen(base::RunTime now);
  void finish_stage(base::RunTime now);
  void finish_echoes();
  void begin_load(base::RunTime now);
  void begin_slower(base::RunTime now);
  bool slower_fits(double sensor_hz) const;
  void end(ProbeEnd why);
  template <class Stage, class... Arguments>
  void begin_stage(Phase phase, base::RunTime now, Arguments... arguments);

  ProbePlan plan_;
  ProbeLine line_;
  mav::PacketParser parser_;
  Phase phase_ = Phase::kListen;
  base::RunTime phase_begin_;
  base::RunTime next_heartbeat_;
  std::unique_ptr<ProbeStage> stage_;
  std::size_t background_bytes_ = 0;
  std::vector<base::RunTime> arrivals_;
  std::size_t slower_at_ = 0;  ///< place in usual_sensor_rates()
  LineFigures figures_;
};

}  // namespace cas::hils
