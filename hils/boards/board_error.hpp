// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>
#include <string>

#include "hils/measure/judgement.hpp"

namespace cas::hils {

/// A board that is not there, does not boot, failed or is held by another: one sentence, and the
/// exit code of the case.
class BoardError : public std::runtime_error {
 public:
  BoardError(ExitCode code, const std::string& sentence)
      : std::runtime_error(sentence), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

}  // namespace cas::hils
