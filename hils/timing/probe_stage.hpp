// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <map>
#include <optional>

#include "base/time/clock.hpp"
#include "hils/timing/probe_packets.hpp"

namespace cas::hils {

/// State shared by the stages of a measurement: packets to send, and open questions.
class ProbeLine {
 public:
  /// @return the question's number
  std::uint32_t ask(QuestionKind kind, base::RunTime now) {
    packets.ask(kind, ++last_);
    open_.emplace(last_, now);
    return last_;
  }
  /// Closes a question, and those before it: a line keeps the order, so they are lost.
  /// @return its round trip; nullopt for one that is not open
  std::optional<base::Duration> answered(std::uint32_t number, base::RunTime now) {
    const auto found = open_.find(number);
    if (found == open_.end()) return std::nullopt;
    const base::Duration time = now - found->second;
    open_.erase(open_.begin(), std::next(found));
    return time;
  }
  std::size_t open() const { return open_.size(); }
  /// When the oldest open question was asked; nullopt: none is open.
  std::optional<base::RunTime> oldest() const {
    return open_.empty() ? std::nullopt : std::optional(open_.begin()->second);
  }
  /// Drops all open questions; late answers to them are ignored.
  void forget_open() { open_.clear(); }

  ProbePackets packets;

 private:
  std::map<std::uint32_t, base::RunTime> open_;  // numbers rise with time
  std::uint32_t last_ = 0;
};

/// A part of the measurement. Reads no clock.
class ProbeStage {
 public:
  /// After this time an answer counts as lost: longer than 4 kB, a board's send buffer, take at
  /// 57600 baud.
  static constexpr base::Duration kPatience = std::chrono::seconds(2);

  virtual ~ProbeStage() = default;

  /// Sends due packets.
  virtual void turn(base::RunTime now) = 0;
  /// An answer to an open question has come.
  virtual void on_answer(std::uint32_t number, base::RunTime now) = 0;
  /// Bytes have come, of whatever packets; before the answers among them.
  virtual void on_read(std::size_t bytes, base::RunTime now) = 0;
  /// When to call turn() at the latest.
  virtual base::RunTime wake() const = 0;
  virtual bool done() const = 0;
};

}  // namespace cas::hils
