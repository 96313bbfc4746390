// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/fence_keeper.hpp"

#include <fmt/format.h>

#include <exception>
#include <nlohmann/json.hpp>

#include "base/os/write_file.hpp"
#include "base/rpc/client.hpp"
#include "base/text.hpp"

namespace cas::hils {
namespace {

using Json = nlohmann::json;

/// As casctl loads it, in the order in which it is given back.
std::string file_text(const FenceParams& former) {
  std::string text = "# Parameters of the fence before the flight: NAME VALUE\n";
  for (auto each = former.rbegin(); each != former.rend(); ++each) {
    text += fmt::format("{} {}\n", each->first, each->second);
  }
  return text;
}

}  // namespace

std::optional<std::string> FenceKeeper::set(const FenceParams& wanted) {
  if (wanted.empty()) return "only the fences of PX4 and ArduPilot are known";
  try {
    FenceParams former;
    for (const auto& [name, value] : wanted) {
      former.emplace_back(name, call_("param.get", {{"name", name}}).at("value").get<double>());
    }
    former_ = std::move(former);
    base::write_file(file_, file_text(former_), base::Durability::kCache);
    for (const auto& [name, value] : wanted) call_("param.set", {{"name", name}, {"value", value}});
    return std::nullopt;
  } catch (const base::rpc::CallError& error) {
    return error.what();
  }
}

std::optional<std::string> FenceKeeper::restore(base::RunTime deadline) {
  std::string why;
  while (!former_.empty() && why.empty()) {
    const auto& [name, value] = former_.back();
    try {
      if (base::steady_now() > deadline) throw std::runtime_error("the vehicle does not answer");
      call_("param.set", {{"name", name}, {"value", value}});
      former_.pop_back();
    } catch (const std::exception& error) {
      why = error.what();
    }
  }
  if (former_.empty()) {
    std::error_code ignored;
    std::filesystem::remove(file_, ignored);
    return std::nullopt;
  }
  const std::string names = base::joined(former_, ", ", [](const auto& parameter) {
    return fmt::format("{} {}", parameter.first, parameter.second);
  });
  return fmt::format("the fence's parameters were not given back ({}): {}; {} has them", names, why,
                     file_.string());
}

}  // namespace cas::hils
