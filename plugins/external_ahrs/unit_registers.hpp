// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "plugins/external_ahrs/binary_output.hpp"

namespace cas::sim {

/// The unit's ASCII side: `$VNRRG,01*72` and the like, each line answered at once.
///
/// Understood: VNASY (pause and resume the packets), VNRRG of register 1 (the model), VNWRG of
/// registers 6 (its ASCII messages: it has none) and 75 to 77 (its packets). Any other line gets
/// the unit's error answer `$VNERR,code`.
class UnitRegisters {
 public:
  static constexpr std::size_t kOutputs = 3;

  /// Lines and bytes that the unit received.
  struct Counts {
    std::uint64_t lines = 0;          ///< whole, with the right checksum
    std::uint64_t refused = 0;        ///< of these: answered by an error
    std::uint64_t bad_checksums = 0;  ///< lines
    std::uint64_t garbage_bytes = 0;  ///< outside lines, or in lines that never ended
  };

  /// @param model  name in register 1
  explicit UnitRegisters(std::string model) : model_(std::move(model)) {}

  /// Takes bytes as they come, and appends the answers to `replies`.
  void feed(std::span<const std::uint8_t> bytes, std::string& replies);

  /// Whether packets flow: resumed, and a register asks for them.
  bool running() const;
  const std::array<BinaryOutput, kOutputs>& outputs() const { return outputs_; }
  /// Grows when a register of packets was written, or packets paused or resumed.
  unsigned revision() const { return revision_; }
  /// What the user's driver has asked so far, each line once, in order; at most 32 of them.
  const std::vector<std::string>& asked() const { return asked_; }
  /// The newest refusal in words; empty: none.
  const std::string& refusal() const { return refusal_; }
  const Counts& counts() const { return counts_; }

 private:
  void on_byte(char byte, std::string& replies);
  void drop_line();
  void on_line(std::string& replies);
  std::string answer(std::string_view body);
  std::string write_register(std::string_view body, std::span<const std::string_view> words);
  std::string error(const char* code, std::string why);
  void note(std::string_view body);

  std::string model_;
  bool in_line_ = false;
  std::string line_;  // behind the '$'
  bool paused_ = false;
  std::array<BinaryOutput, kOutputs> outputs_;
  unsigned revision_ = 0;
  std::vector<std::string> asked_;
  std::string refusal_;
  Counts counts_;
};

}  // namespace cas::sim
