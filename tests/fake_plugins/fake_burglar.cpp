// SPDX-License-Identifier: BSD-3-Clause
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <string>

#include "libsim/api/plugin.hpp"

namespace {

using namespace cas;

/// 0, or the errno of opening the file.
int error_of(const std::filesystem::path& file, const char* mode) {
  std::FILE* const opened = std::fopen(file.c_str(), mode);
  if (opened == nullptr) return errno;
  std::fclose(opened);
  return 0;
}

/// Reads the file `key` of the parameter `folder` and writes a new one beside it. Its figures say
/// what came of it. The parameter `named` is there to name the file.
class FakeBurglar final : public sim::Plugin {
 public:
  void configure(sim::PluginContext&, const base::ConfigNode& params) override {
    const std::filesystem::path folder = params.require<std::string>("folder");
    params.find("named");
    read_ = error_of(folder / "key", "r");
    write_ = error_of(folder / "new", "w");
  }
  void reset() override {}
  std::string stats_json() const override {
    return "{\"read\":" + std::to_string(read_) + ",\"write\":" + std::to_string(write_) + "}";
  }

 private:
  int read_ = -1;
  int write_ = -1;
};

}  // namespace

CAS_PLUGIN(FakeBurglar, "fake_burglar")
