// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/completion_words.hpp"

#include <algorithm>
#include <string>

#include "casd/casctl/verbs/telemetry.hpp"
#include "mavlink_gen/services/ardupilot_modes.hpp"
#include "mavlink_gen/services/px4_modes.hpp"

namespace cas::casctl {
namespace {

using Words = base::cli::ArgumentWords;

/// Names of the loops in config/gains.yaml.
Words loops() {
  return {.known = {"rollrate", "pitchrate", "yawrate", "roll", "pitch", "yaw", "position",
                    "velocity", "altitude", "climb"}};
}

/// That PX4 or a vehicle of ArduPilot takes.
Words modes() {
  Words words;
  const auto add = [&words](const mav::services::FlightModeWord& mode) {
    const std::string word(mode.word);
    if (mode.asked_for && std::ranges::count(words.known, word) == 0) words.known.push_back(word);
  };
  std::ranges::for_each(mav::services::kPx4Modes, add);
  std::ranges::for_each(mav::services::kCopterModes, add);
  std::ranges::for_each(mav::services::kPlaneModes, add);
  std::ranges::for_each(mav::services::kRoverModes, add);
  std::ranges::for_each(mav::services::kSubModes, add);
  return words;
}

Words asked_of_casd(const std::string& kind) {
  return {.command = "casctl --timeout 3 words " + kind};
}

}  // namespace

base::cli::WordsByCommand completion_words() {
  return {{"gains", loops()},
          {"setgain", loops()},
          {"mode", modes()},
          {"watch", {.known = telemetry_topic_names(), .repeated = true}},
          {"message", asked_of_casd("messages")},
          {"message-interval", asked_of_casd("messages")},
          {"param get", asked_of_casd("parameters")},
          {"param set", asked_of_casd("parameters")},
          {"param list", asked_of_casd("parameters")}};
}

}  // namespace cas::casctl
