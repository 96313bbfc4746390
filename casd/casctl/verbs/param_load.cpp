// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/verbs/param_load.hpp"

#include <fmt/format.h>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "base/read_file.hpp"
#include "base/text.hpp"
#include "casd/casctl/verbs/param_file.hpp"

namespace cas::casctl {
namespace {

using base::rpc::CallError;
using nlohmann::json;

/// The outcome for each parameter of a file.
struct Fate {
  json in_force = json::array();   ///< names
  json kept = json::array();       ///< {name, asked, value}: the vehicle keeps its own value
  json refused = json::array();    ///< {name, message}
  json not_found = json::array();  ///< names that the vehicle did not answer to
  json not_tried = json::array();  ///< names after the one that ended the load

  bool all() const {
    return kept.empty() && refused.empty() && not_found.empty() && not_tried.empty();
  }
};

/// As casd writes numbers: 9, not 9.0.
json number(double value) {
  constexpr double kExact = 9e15;
  if (value == std::floor(value) && std::abs(value) < kExact) {
    return static_cast<std::int64_t>(value);
  }
  return value;
}

/// Sets parameters one by one and notes the outcome of each.
class Loading {
 public:
  Loading(Session& session, std::vector<ParamWish> wishes, bool strict, bool not_hil)
      : session_(session), wishes_(std::move(wishes)), strict_(strict), not_hil_(not_hil) {}

  void run() {
    if (needs_component()) own_component_ = session_.vehicle_call("vehicle.state").at("component");
    if (strict_ && !is_ready()) {
      end();
      return;
    }
    for (next_ = 0; next_ < wishes_.size() && !ended_; ++next_) set(wishes_[next_]);
    end();
  }

  /// Counts the parameters after the newest one as not tried.
  void end() {
    for (; next_ < wishes_.size(); ++next_) fate_.not_tried.push_back(wishes_[next_].name);
  }

  const Fate& fate() const { return fate_; }
  bool fell_silent() const { return silent_; }

 private:
  bool needs_component() const {
    for (const ParamWish& wish : wishes_) {
      if (wish.component != 0) return true;
    }
    return false;
  }

  /// Whether a wish is refused here.
  bool is_refused(const ParamWish& wish) {
    if (!std::isfinite(wish.value)) {
      refuse(wish, "NaN or infinite, which no autopilot accepts");
      return true;
    }
    if (wish.component == 0 || wish.component == own_component_) return false;
    refuse(wish,
           fmt::format("it is of component {}; only those of the autopilot, component {}, are set",
                       wish.component, own_component_));
    return true;
  }

  /// Whether the vehicle answers to every name.
  bool is_ready() {
    for (const ParamWish& wish : wishes_) {
      if (!is_refused(wish)) ask(wish, "param.get", {{"name", wish.name}});
      if (silent_) break;
    }
    return fate_.all();
  }

  void set(const ParamWish& wish) {
    json params{{"name", wish.name}, {"value", wish.value}};
    if (not_hil_) params["not_hil"] = true;
    if (!is_refused(wish) && ask(wish, "param.set", params)) {
      fate_.in_force.push_back(wish.name);
    }
    ended_ = silent_ || (strict_ && !fate_.all());
  }

  /// @return whether it was answered; if not, why is noted
  bool ask(const ParamWish& wish, const std::string& method, const json& params) {
    try {
      session_.vehicle_call(method, params);
      return true;
    } catch (const CallError& error) {
      note(wish, error);
      return false;
    }
  }

  void note(const ParamWish& wish, const CallError& error) {
    switch (error.code()) {
      case base::rpc::kTimeout:
        fate_.not_found.push_back(wish.name);
        silent_ = is_silent(session_.vehicle_call("vehicle.state"));
        return;
      case base::rpc::kRefused:
      case base::rpc::kInvalidParams:
      case base::rpc::kInterlock:
        break;
      default:
        throw error;
    }
    const json data = json::parse(error.data_json(), nullptr, false);
    const json in_force = data.is_object() ? data.value("parameters", json::object()) : json();
    if (in_force.contains(wish.name)) {
      fate_.kept.push_back(
          {{"name", wish.name}, {"asked", number(wish.value)}, {"value", in_force[wish.name]}});
    } else {
      refuse(wish, error.what());
    }
  }

  void refuse(const ParamWish& wish, const std::string& why) {
    fate_.refused.push_back({{"name", wish.name}, {"message", why}});
  }

  Session& session_;
  std::vector<ParamWish> wishes_;
  bool strict_;
  bool not_hil_;
  int own_component_ = 0;
  std::size_t next_ = 0;
  bool ended_ = false;
  bool silent_ = false;
  Fate fate_;
};

std::string names_of(const json& names) {
  return base::joined(names, ", ", [](const json& name) { return name.get<std::string>(); });
}

/// A sentence that names the parameters in force, then a line for each kind of failure.
std::string fate_text(const Fate& fate, const std::string& file, std::size_t asked) {
  const std::string of_file = " parameters of " + file + " are in force";
  if (fate.all()) return fmt::format("{}{}", asked, of_file);
  std::string text = fmt::format("{} of {}{}", fate.in_force.size(), asked, of_file);
  if (!fate.in_force.empty()) text += ": " + names_of(fate.in_force);
  for (const json& each : fate.kept) {
    text += fmt::format("\nthe vehicle keeps {} = {} (asked: {})", each["name"].get<std::string>(),
                        each["value"].dump(), each["asked"].dump());
  }
  for (const json& each : fate.refused) {
    text +=
        "\nrefused: " + each["name"].get<std::string>() + ": " + each["message"].get<std::string>();
  }
  if (!fate.not_found.empty()) text += "\nnot found: " + names_of(fate.not_found);
  if (!fate.not_tried.empty()) text += "\nnot tried: " + names_of(fate.not_tried);
  return text;
}

void report_fate(const Session& session, const Fate& fate, const std::string& file,
                 std::size_t asked) {
  report(session.options(),
         {{"file", file},
          {"set", fate.in_force.size()},
          {"in_force", fate.in_force},
          {"kept", fate.kept},
          {"refused", fate.refused},
          {"not_found", fate.not_found},
          {"not_tried", fate.not_tried}},
         fate_text(fate, file, asked));
}

}  // namespace

int load_params(Session& session, const std::string& file, bool strict, bool not_hil) {
  constexpr std::size_t kMostBytes = std::size_t{16} << 20U;
  const std::string text = base::read_foreign_file(file, "parameter file", kMostBytes);
  std::vector<ParamWish> wishes = parse_param_file(text, file);
  const std::size_t asked = wishes.size();
  Loading loading(session, std::move(wishes), strict, not_hil);
  try {
    loading.run();
  } catch (...) {
    loading.end();
    if (!loading.fate().in_force.empty()) report_fate(session, loading.fate(), file, asked);
    throw;
  }
  report_fate(session, loading.fate(), file, asked);
  if (loading.fate().all()) return kDone;
  return loading.fell_silent() ? kTimeout : kRefused;
}

}  // namespace cas::casctl
