// SPDX-License-Identifier: BSD-3-Clause
#include "hils/runs/runs_page.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "base/config/install_paths.hpp"
#include "base/read_file.hpp"
#include "hils/report/document.hpp"
#include "hils/report/number_text.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;
using OrderedJson = nlohmann::ordered_json;

Mood mood_of(const std::string& verdict) {
  if (verdict == "PASSED") return Mood::kGood;
  return verdict == "FAILED" ? Mood::kBad : Mood::kNeutral;
}

/// Address of a file of a run as seen from the page; empty where there is none.
std::string address(const fs::path& folder, const ListedRun& run, const char* name) {
  std::error_code none;
  if (!fs::is_regular_file(folder / run.folder / name, none)) return "";
  std::string text;
  for (const unsigned char c : (fs::path(run.folder) / name).lexically_normal().string()) {
    const bool plain = std::isalnum(c) != 0 || c == '/' || c == '-' || c == '_' || c == '.';
    text += plain ? std::string(1, static_cast<char>(c)) : fmt::format("%{:02X}", c);
  }
  return text;
}

OrderedJson run_json(const fs::path& folder, const ListedRun& run) {
  return {{"folder", run.folder},
          {"verdict", run.verdict},
          {"scenario", run.scenario},
          {"controller", run.controller},
          {"architecture", run.architecture},
          {"clock", run.clock},
          {"seed", run.seed},
          {"ended_s", run.ended_s},
          {"why", run.why},
          {"report", address(folder, run, "report.html")},
          {"replay", address(folder, run, "replay.html")},
          {"figures", run.figures},
          {"settings", run.settings}};
}

/// For a browser without a script.
Document plain_page(const fs::path& folder, const RunList& list) {
  Document page{.title = fmt::format("{} runs below {}", list.runs.size(), folder.string())};
  for (const std::string& sentence : list.unread) page.paragraph("Not read: " + sentence);
  Rows rows{{"Scenario", "verdict", "folder", "replay", "RMS error m", "why"}};
  for (const ListedRun& run : list.runs) {
    Cell verdict(run.verdict);
    verdict.mood = mood_of(run.verdict);
    Cell report(run.folder);
    report.address = address(folder, run, "report.html");
    Cell replay(address(folder, run, "replay.html").empty() ? "" : "replay");
    replay.address = address(folder, run, "replay.html");
    rows.push_back(
        {run.scenario, verdict, report, replay, fixed(run.figure("rms_position_m"), 3), run.why});
  }
  page.table("Runs, the latest first", std::move(rows), {}, Align::kLeft);
  return page;
}

/// No text of a run ends the element.
std::string script_safe(std::string text) {
  for (std::size_t i = 0; (i = text.find('<', i)) != std::string::npos;) {
    text.replace(i, 1, "\\u003c");
  }
  return text;
}

}  // namespace

std::string runs_page(const fs::path& folder, const RunList& list) {
  std::string html = write_html(plain_page(folder, list));
  const auto web = base::web_dir();
  const auto script = web ? base::read_file(*web / "runs.js") : std::nullopt;
  const auto style = web ? base::read_file(*web / "runs.css") : std::nullopt;
  if (!script || !style) return html;
  OrderedJson runs = OrderedJson::array();
  for (const ListedRun& run : list.runs) runs.push_back(run_json(folder, run));
  const OrderedJson data{{"folder", folder.string()}, {"runs", std::move(runs)}};
  const std::size_t end = std::min(html.rfind("</body>"), html.size());
  return html.insert(
      end, "<style>" + *style + "</style>\n<script type=\"application/json\" id=\"runs\">" +
               script_safe(data.dump(-1, ' ', false, OrderedJson::error_handler_t::replace)) +
               "</script>\n<script>" + *script + "</script>\n");
}

}  // namespace cas::hils
