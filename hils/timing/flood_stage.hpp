// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>

#include "hils/timing/byte_rate.hpp"
#include "hils/timing/probe_stage.hpp"

namespace cas::hils {

/// How many bytes a second the line carries. At most a few kilobytes are in flight, and answers
/// release the next ones, so no line or buffer overflows.
///
///   to the board:   padding and a question in turn; the answer says that the padding is through
///   from the board: questions alone, so that answers and telemetry fill the way back
class FloodStage final : public ProbeStage {
 public:
  enum class Way { kToBoard, kFromBoard };

  FloodStage(ProbeLine& line, Way way, QuestionKind kind, base::Duration length,
             base::RunTime begin)
      : line_(line), way_(way), kind_(kind), end_(begin + length), last_event_(begin) {
    rate_.add(0, begin);
  }

  void turn(base::RunTime now) override;
  void on_answer(std::uint32_t number, base::RunTime now) override;
  void on_read(std::size_t bytes, base::RunTime now) override;
  base::RunTime wake() const override {
    const base::RunTime given_up = last_event_ + kPatience;
    return ended_ ? given_up : std::min(end_, given_up);
  }
  bool done() const override { return done_; }

  double bytes_s() const { return rate_.bytes_s(); }

 private:
  /// Bytes in flight: 44 ms at 921600 baud. Less would not fill a line whose ends take a few
  /// milliseconds each; more only waits longer.
  static constexpr std::size_t kWindowBytes = 4096;
  static constexpr std::size_t kPaddingBytes = 230;

  struct Sent {
    std::uint32_t number = 0;
    std::size_t bytes = 0;
  };

  void release_up_to(std::uint32_t number);

  ProbeLine& line_;
  Way way_;
  QuestionKind kind_;
  base::RunTime end_;
  base::RunTime last_event_;
  std::deque<Sent> on_way_;
  std::size_t on_way_bytes_ = 0;
  std::size_t through_ = 0;
  ByteRate rate_;
  bool ended_ = false;  ///< nothing more is sent; answers may come
  bool done_ = false;
};

}  // namespace cas::hils
