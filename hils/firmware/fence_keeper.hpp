// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <utility>

#include "base/time/clock.hpp"
#include "hils/flight/geofence.hpp"

namespace cas::hils {

/// Puts an autopilot's own fence in force for a flight, and afterwards restores its parameters. The
/// old values stay in a file until then: if hils is killed, or the vehicle does not answer, `casctl
/// param load FILE` restores them.
class FenceKeeper {
 public:
  /// Calls a method of casd. @throws base::rpc::CallError for a refusal
  using Call = std::function<nlohmann::json(const std::string& method, nlohmann::json params)>;

  FenceKeeper(Call call, std::filesystem::path file)
      : call_(std::move(call)), file_(std::move(file)) {}

  /// Keeps the former values, then sets these. @return why it is not in force
  std::optional<std::string> set(const FenceParams& wanted);
  /// Restores the parameters that set() has changed, newest first. Gives up at the deadline if the
  /// vehicle does not answer. @return a sentence on parameters not restored
  std::optional<std::string> restore(base::RunTime deadline);

 private:
  Call call_;
  std::filesystem::path file_;
  FenceParams former_;
};

}  // namespace cas::hils
