// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "hils/programs/child_process.hpp"
#include "hils/programs/supervisor.hpp"
#include "hils/run/run_paths.hpp"

namespace cas::hils {

/// "CAS was built without the page: CAUSE (docs/use/web.md)", with the cause that the build left
/// where the page would be, if it left one.
std::string built_without_page(const std::filesystem::path& page_folder);
/// That of this program, in the build tree and in an installation.
std::string built_without_page();

/// casweb beside a run, which shows it in a browser. A run goes on without it.
class WebView {
 public:
  /// Starts casweb at its usual port, or at a free one where that is taken, waits until it listens
  /// and says on standard error where the page is. The token is one of this run alone; only a
  /// terminal is shown it. Where casweb does not start it says why, and the run goes on.
  /// @throws RunStopped when the run is stopped meanwhile
  WebView(const RunPaths& paths, const Supervisor& supervisor);

  /// Whether casweb was started, and has ended.
  bool has_ended() const { return casweb_ && casweb_->poll_exit().has_value(); }

 private:
  /// @return whether it listens
  bool start(const RunPaths& paths, const Supervisor& supervisor, const std::string& listen);

  std::unique_ptr<ChildProcess> casweb_;
};

}  // namespace cas::hils
