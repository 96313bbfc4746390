// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/session/recording_text.hpp"

#include <filesystem>

#include "casd/casctl/session/table.hpp"

namespace cas::casctl {

using nlohmann::json;

std::string recording_text(const json& recording) {
  const bool gaps = recording.value("left_out", 0) > 0;
  if (!recording.value("active", false)) {
    const std::string fault = recording.contains("paused")
                                  ? "CANNOT RECORD in " + recording.value("folder", "?") + ": " +
                                        recording.value("paused", "?")
                                  : "";
    if (!gaps) return fault;
    return fault + (fault.empty() ? "" : "; ") + recording["left_out"].dump() +
           " packets are missing in the last recording";
  }
  const std::string missing =
      gaps ? ", " + recording["left_out"].dump() + " packets are missing in it" : "";
  const std::string file = recording.value("file", "?");
  if (!recording.contains("paused")) {
    return "recording into " + file + ": " + count_text(recording, "recorded") + " packets" +
           missing;
  }
  return "recording PAUSED for " + duration_text(recording.value("paused_s", 0.0)) + ": " +
         recording["paused"].get<std::string>() + "; " +
         (file.empty() ? "there is no file yet"
                       : file + " has " + count_text(recording, "recorded") + " packets") +
         missing;
}

std::string autopilot_logs_text(const json& logs) {
  std::string text = "logs of autopilots in " + logs.value("folder", "?");
  if (logs.contains("paused")) {
    text += " PAUSED for " + duration_text(logs.value("paused_s", 0.0)) + ": " +
            logs.value("paused", "?");
  }
  const json vehicles = logs.value("vehicles", json::array());
  if (vehicles.empty()) text += "; no vehicle yet";
  for (const json& log : vehicles) {
    text += "\n  vehicle " + count_text(log, "vehicle") + ": ";
    text += log.contains("file")
                ? std::filesystem::path(log.value("file", "?")).filename().string() + ", " +
                      count_text(log, "bytes") + " bytes"
            : log.value("wanted", false) ? "asked, no data yet"
            : logs.contains("paused")    ? "waits for the folder"
                                         : "waits for its arming or its HEARTBEAT";
    if (log.contains("trouble")) text += "; it " + log.value("trouble", "?");
  }
  return text;
}

}  // namespace cas::casctl
