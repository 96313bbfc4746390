// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

namespace CLI {
class App;
}

namespace cas::hils {

/// `hils campaign`: reads its flags, plans, flies by the sweep's engine and reports.
class CampaignCommand {
 public:
  /// Adds the subcommand to `app`, which outlives the object.
  explicit CampaignCommand(CLI::App& app);
  ~CampaignCommand();
  CampaignCommand(const CampaignCommand&) = delete;
  CampaignCommand& operator=(const CampaignCommand&) = delete;

  bool parsed() const;
  /// @return exit code @throws RunStopped, base::ConfigError
  int run() const;

 private:
  struct Flags;
  std::unique_ptr<Flags> flags_;
};

}  // namespace cas::hils
