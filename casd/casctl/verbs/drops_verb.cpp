// SPDX-License-Identifier: BSD-3-Clause
#include <cstdint>
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "casd/casctl/session/text.hpp"
#include "casd/casctl/verbs/verbs.hpp"
#include "casd/words/link_words.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

struct DropsWish {
  std::string link;
  int rows = 200;
};

/// The drops of one link, message and cause, whoever sent them.
struct DropKind {
  std::string link;
  std::string message;
  std::string cause;
  std::uint64_t count = 0;
};

std::string cause_text(const std::string& cause) {
  const casd::CauseWords* const words = casd::find_cause(cause);
  return words == nullptr ? "" : std::string(words->meaning);
}

/// All senders of a message together, in the order in which casd lists them.
std::vector<DropKind> kinds_of(const json& drops) {
  std::vector<DropKind> kinds;
  std::map<std::string, std::size_t> known;
  const auto add = [&](const json& entry, const std::string& message) {
    const std::string link = entry.value("link", "?");
    const std::string cause = entry.value("cause", "?");
    const auto [at, is_new] =
        known.try_emplace(json::array({link, message, cause}).dump(), kinds.size());
    if (is_new) kinds.push_back({link, message, cause});
    kinds[at->second].count += entry.value("count", std::uint64_t{0});
  };
  for (const json& entry : drops.at("dropped")) {
    const std::string name = entry.value("name", "");
    add(entry, name.empty() ? "message " + entry.at("id").dump() : name);
  }
  for (const json& entry : drops.at("unreadable")) add(entry, "-");
  return kinds;
}

void print_kinds(const std::vector<DropKind>& kinds, std::size_t rows) {
  Table table({"LINK", "MESSAGE", "COUNT", "CAUSE", "WHICH MEANS"});
  std::uint64_t hidden = 0;
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    const DropKind& kind = kinds[i];
    if (i >= rows) {
      hidden += kind.count;
      continue;
    }
    table.add(
        {kind.link, kind.message, std::to_string(kind.count), kind.cause, cause_text(kind.cause)});
  }
  if (table.empty()) {
    std::cout << "nothing was dropped\n";
    return;
  }
  table.print(std::cout);
  if (kinds.size() <= rows) return;
  std::cout << "and " << kinds.size() - rows << " more rows with " << hidden
            << " packets: --limit shows more of them, --link those of one link\n";
}

int show_drops(Session& session, const DropsWish& wish) {
  json params = json::object();
  if (!wish.link.empty()) params["link"] = wish.link;
  if (session.options().json) {
    params["limit"] = wish.rows;
    report(session.options(), session.call("link.drops", params), "");
    return kDone;
  }
  print_kinds(kinds_of(session.call("link.drops", params)), static_cast<std::size_t>(wish.rows));
  return kDone;
}

}  // namespace

void add_drops_verb(CommandLine& line) {
  const auto wish = std::make_shared<DropsWish>();
  CLI::App* const drops =
      line.add_verb("drops", "Show what was not passed on, and why", "casctl drops",
                    [wish](Session& session) { return show_drops(session, *wish); });
  drops->add_option("--link", wish->link, "Drops of this link only");
  drops->add_option("--limit", wish->rows, "Most rows")
      ->check(in_range(1, 5000))
      ->capture_default_str();
}

}  // namespace cas::casctl
