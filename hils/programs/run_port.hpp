// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "base/rpc/message.hpp"

namespace cas::hils {

/// The Unix socket on which a run publishes its state and takes faults by hand; casweb is its
/// client. A separate thread serves it from the last published state.
///
///   run.reference, run.status, fault.list   what was shown
///   fault.inject                            waits until the run takes it and answers
///   topics fault, verdict                   published; run.told: the verdict has been passed on
class RunPort {
 public:
  using Json = base::rpc::Json;

  /// A requested fault.
  struct FaultCall {
    std::string params;  ///< JSON
    base::rpc::Reply reply;
  };

  /// @throws base::ConfigError
  explicit RunPort(const std::filesystem::path& socket);
  ~RunPort();
  RunPort(const RunPort&) = delete;
  RunPort& operator=(const RunPort&) = delete;

  /// The answer of a method from now on.
  void show(const std::string& method, Json answer);
  void publish(const std::string& topic, Json params);
  /// Faults requested since the last call; each needs an answer.
  std::vector<FaultCall> take_faults();
  void answer(const FaultCall& call, Json result);
  void refuse(const FaultCall& call, int code, std::string sentence);
  /// From now on no fault is taken: those asked for are refused.
  void end_faults();
  /// Publishes the verdict and waits, at most two seconds, until its receiver has forwarded it.
  void tell_verdict(Json verdict);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cas::hils
