// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "base/rpc/message.hpp"

namespace cas::hils {

/// The Unix socket of a run, for casweb: it reports the flight and takes faults by hand. A thread
/// of its own serves it from the data that the run showed last.
///
///   run.reference, run.status, fault.list   the data shown last
///   fault.inject                            waits until the run takes it and answers
///   topics fault, verdict                   published; run.told: the verdict has been passed on
class RunPort {
 public:
  using Json = base::rpc::Json;

  /// A client's request for a fault.
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
  /// Faults requested since the last look; each needs an answer.
  std::vector<FaultCall> take_faults();
  void answer(const FaultCall& call, Json result);
  void refuse(const FaultCall& call, int code, std::string sentence);
  /// From now on no fault is taken: those asked for are refused.
  void end_faults();
  /// Publishes the verdict and waits until its subscriber has passed it on, for two seconds at
  /// most.
  void tell_verdict(Json verdict);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cas::hils
