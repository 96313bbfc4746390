// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "hils/programs/child_process.hpp"
#include "hils/run/run_places.hpp"

namespace cas::hils {

/// casweb beside a run, which shows it in a browser. A run does not end with it: nobody flies by
/// it.
class WebView {
 public:
  /// Starts casweb at its usual port, or at a free one where that is taken, and waits until it
  /// listens. @throws RunStopped, base::ConfigError
  explicit WebView(const RunPlaces& places);

  /// With the token: "http://127.0.0.1:5791/#k=...".
  const std::string& address() const { return address_; }

 private:
  bool start(const RunPlaces& places, const std::string& listen);

  std::unique_ptr<ChildProcess> casweb_;
  std::string address_;
};

}  // namespace cas::hils
