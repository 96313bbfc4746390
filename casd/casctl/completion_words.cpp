// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/completion_words.hpp"

#include "casd/casctl/verbs/telemetry.hpp"

namespace cas::casctl {
namespace {

using Words = base::cli::ArgumentWords;

/// Of config/gains.yaml.
Words loops() {
  return {.known = {"rollrate", "pitchrate", "yawrate", "roll", "pitch", "yaw", "position",
                    "velocity", "altitude", "climb"}};
}

/// That PX4 or ArduCopter take.
Words modes() {
  return {.known = {"MANUAL",  "ALTCTL",   "POSCTL", "ACRO",         "OFFBOARD",  "STABILIZED",
                    "READY",   "TAKEOFF",  "HOLD",   "LOITER",       "MISSION",   "RTL",
                    "LAND",    "PRECLAND", "FOLLOW", "STABILIZE",    "ALT_HOLD",  "AUTO",
                    "GUIDED",  "CIRCLE",   "DRIFT",  "SPORT",        "FLIP",      "AUTOTUNE",
                    "POSHOLD", "BRAKE",    "THROW",  "GUIDED_NOGPS", "SMART_RTL", "FLOWHOLD"}};
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
