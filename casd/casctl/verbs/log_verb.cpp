// SPDX-License-Identifier: BSD-3-Clause
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "casd/casctl/session/text.hpp"
#include "casd/casctl/verbs/verbs.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

/// Flags of `log start`.
struct Recording {
  std::string file;
  double rotate_mib = 0;
  double rotate_minutes = 0;
  int keep = 0;
};

int start_log(Session& session, const Recording& recording) {
  json params = json::object();
  if (!recording.file.empty()) params["file"] = recording.file;
  if (recording.rotate_mib > 0) params["rotate_mib"] = recording.rotate_mib;
  if (recording.rotate_minutes > 0) params["rotate_minutes"] = recording.rotate_minutes;
  if (recording.keep > 0) params["keep"] = recording.keep;
  const json result = session.call("log.start", params);
  const std::string ended =
      result.contains("ended") ? "; ended the recording into " + result.value("ended", "?") : "";
  report(session.options(), result, recording_text(result) + ended);
  return kDone;
}

int stop_log(Session& session) {
  const json result = session.call("log.stop");
  const std::string file = result.value("file", "");
  const std::string figures =
      result.at("recorded").dump() + " packets into " + file +
      (result.value("left_out", 0) > 0 ? "; missing are " + result["left_out"].dump() : "");
  if (result.contains("ended")) {
    report(session.options(), result, "recorded " + figures);
  } else {
    report(session.options(), result,
           "no recording ran" + (file.empty() ? "" : "; the last one: " + figures));
  }
  return kDone;
}

int show_log(Session& session) {
  const json result = session.call("log.status");
  const std::string text = recording_text(result);
  const bool awaits = result.value("awaits_arming", false);
  if (result.value("active", false)) {
    report(session.options(), result, text);
  } else {
    report(session.options(), result,
           (awaits ? "not recording until a vehicle is armed" : "not recording") +
               (text.empty() ? "" : "; " + text));
  }
  return kDone;
}

}  // namespace

void add_log_verb(CommandLine& line) {
  const auto recording = std::make_shared<Recording>();
  CLI::App* const log = line.add_group("log", "Record all packets into a .tlog file");
  CLI::App* const start =
      line.add_verb(log, "start", "Start a new file (on casd's machine)", "casctl log start flight",
                    [recording](Session& session) { return start_log(session, *recording); });
  start->add_option("NAME", recording->file,
                    "Of the new file, after its date, in casd's folder for recordings");
  start->add_option("--rotate-mib", recording->rotate_mib, "Go on in the next file at this size")
      ->check(CLI::NonNegativeNumber);
  start
      ->add_option("--rotate-minutes", recording->rotate_minutes,
                   "Go on in the next file at this age")
      ->check(CLI::NonNegativeNumber);
  start->add_option("--keep", recording->keep, "Files of this recording that stay; 0: all")
      ->check(CLI::NonNegativeNumber);
  line.add_verb(log, "stop", "Stop recording", "casctl log stop", stop_log);
  line.add_verb(log, "status", "Show what is recorded", "casctl log status", show_log);
}

}  // namespace cas::casctl
