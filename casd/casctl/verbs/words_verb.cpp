// SPDX-License-Identifier: BSD-3-Clause
#include <iostream>
#include <memory>
#include <set>

#include "casd/casctl/verbs/verbs.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

/// Names of the messages that came in on any link.
std::set<std::string> heard_messages(Session& session) {
  std::set<std::string> names;
  for (const json& entry : all_messages(session)) {
    const std::string name = entry.value("name", "");
    if (entry.value("direction", "") == "rx" && !name.empty()) names.insert(name);
  }
  return names;
}

std::set<std::string> parameter_names(Session& session) {
  std::set<std::string> names;
  const json list = session.vehicle_call("param.list");
  for (const json& entry : list.at("parameters")) names.insert(entry.at("name"));
  return names;
}

/// Shells expand the words of a completion: a name from the wire with `$(...)` in it would run.
bool is_plain(const std::string& name) {
  constexpr const char* kPlain =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_.-";
  return !name.empty() && name.find_first_not_of(kPlain) == std::string::npos;
}

int print_words(Session& session, const std::string& kind) {
  const std::set<std::string> names =
      kind == "messages" ? heard_messages(session) : parameter_names(session);
  for (const std::string& name : names) {
    if (is_plain(name)) std::cout << name << '\n';
  }
  return kDone;
}

}  // namespace

void add_words_verb(CommandLine& line) {
  const auto kinds = std::make_shared<std::vector<std::string>>();
  line.add_verb("words", "Print words for the shells' completion", "casctl words messages",
                [kinds](Session& session) { return print_words(session, kinds->front()); })
      ->add_option("KIND", *kinds, "messages or parameters")
      ->check(one_of({"messages", "parameters"}))
      ->required()
      ->expected(1, 1);
}

}  // namespace cas::casctl
