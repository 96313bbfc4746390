// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <chrono>
#include <iostream>
#include <memory>
#include <thread>
#include <utility>

#include "base/rpc/message.hpp"
#include "base/text.hpp"
#include "casd/casctl/session/text.hpp"
#include "casd/casctl/verbs/verbs.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;
using nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

constexpr auto kPoll = std::chrono::milliseconds(50);
/// For the next packet of a message whose values casd does not remember.
constexpr auto kPatience = std::chrono::seconds(3);

struct MessageWish {
  std::string name;  ///< or id
  int system = 0;    ///< 0: any, or that of --vehicle
};

using base::is_number;
using base::upper;

/// As casd takes it: a name in capitals, or an id.
json asked_message(const MessageWish& wish) {
  if (is_number(wish.name)) return std::strtoull(wish.name.c_str(), nullptr, 10);
  return upper(wish.name);
}

int wanted_system(const Session& session, const MessageWish& wish) {
  return wish.system != 0 ? wish.system : session.options().vehicle.value_or(0);
}

/// "ATTITUDE of system 1".
std::string wanted_text(const Session& session, const MessageWish& wish) {
  const int system = wanted_system(session, wish);
  const std::string name = is_number(wish.name) ? "message " + wish.name : upper(wish.name);
  return system == 0 ? name : name + " of system " + std::to_string(system);
}

/// The entry of message.list that came last; null when none has come.
json newest_sender(const json& messages, const json& asked, int system) {
  json newest;
  for (const json& entry : messages) {
    if (entry.value("direction", "") != "rx") continue;
    if (system != 0 && entry.value("system", 0) != system) continue;
    const bool is_it = asked.is_string() ? upper(entry.value("name", "")) == asked
                                         : entry.value("id", json()) == asked;
    if (!is_it) continue;
    if (newest.is_null() || entry.value("age_s", 0.0) < newest.value("age_s", 0.0)) newest = entry;
  }
  return newest;
}

/// @throws base::rpc::CallError when no dialect has the message
void require_message(Session& session, const json& asked) {
  const json links = session.call("link.list");
  if (links.empty()) return;
  session.call(
      "message.value",
      {{"link", links.at(0).at("name")}, {"message", asked}, {"system", 0}, {"component", 0}});
}

/// The last sender of the message. With --wait it waits for the first one.
json find_sender(Session& session, const MessageWish& wish) {
  const json asked = asked_message(wish);
  const std::string what = wanted_text(session, wish);
  bool is_known = false;
  for (;;) {
    const json messages = all_messages(session);
    const json sender = newest_sender(messages, asked, wanted_system(session, wish));
    if (!sender.is_null()) return sender;
    if (!std::exchange(is_known, true)) require_message(session, asked);
    if (!session.may_wait()) break;
    session.wait_because("no " + what + " has come yet", kPoll);
  }
  if (session.options().wait) throw WaitTimeout("no " + what + " came in time");
  throw std::runtime_error("no " + what +
                           " has come yet; `casctl monitor --once` lists what comes");
}

/// message.value, as soon as there are values.
json newest_value(Session& session, const json& sender, const std::string& what) {
  const json params{{"link", sender.at("link")},
                    {"message", sender.at("id")},
                    {"system", sender.at("system")},
                    {"component", sender.at("component")}};
  for (const auto end = Clock::now() + kPatience;;) {
    json value = session.call("message.value", params);
    if (!value.at("fields").is_null()) return value;
    if (Clock::now() >= end && !session.may_wait()) break;
    std::this_thread::sleep_for(kPoll);
  }
  throw WaitTimeout(what + " came last " + duration_text(sender.value("age_s", 0.0)) +
                    " before this look and not since; casd keeps its values only while somebody "
                    "looks");
}

void print_json(const json& value, const json& sender) {
  ordered_json answer;
  answer["name"] = value.at("name");
  answer["id"] = value.at("id");
  for (const char* key : {"link", "system", "component"}) answer[key] = sender.at(key);
  answer["age_s"] = value.at("age_s");
  answer["fields"] = ordered_json::object();
  answer["units"] = ordered_json::object();
  for (const json& field : value.at("fields")) {
    const auto name = field.at("name").get<std::string>();
    answer["fields"][name] = field.at("value");
    if (field.contains("units")) answer["units"][name] = field["units"];
  }
  std::cout << answer.dump(-1, ' ', false, ordered_json::error_handler_t::replace) << '\n';
}

std::string cell(const json& value) {
  if (value.is_null()) return "-";
  return value.is_string() ? value.get<std::string>()
                           : value.dump(-1, ' ', false, json::error_handler_t::replace);
}

void print_table(const json& value, const json& sender) {
  std::cout << value.value("name", "?") << " (" << value.at("id") << ") from "
            << sender.at("system") << "/" << sender.at("component") << " on link "
            << sender.value("link", "?") << ", " << duration_text(value.value("age_s", 0.0))
            << " ago\n";
  Table table({"FIELD", "VALUE", "UNIT"});
  for (const json& field : value.at("fields")) {
    table.add({field.value("name", "?"), cell(field.at("value")), field.value("units", "")});
  }
  table.print(std::cout);
}

int show_message(Session& session, const MessageWish& wish) {
  const json sender = find_sender(session, wish);
  const json value = newest_value(session, sender, wanted_text(session, wish));
  if (session.options().json) {
    print_json(value, sender);
  } else {
    print_table(value, sender);
  }
  return kDone;
}

}  // namespace

void add_message_verb(CommandLine& line) {
  const auto wish = std::make_shared<MessageWish>();
  CLI::App* const verb =
      line.add_verb("message", "Show the newest message of a kind with all its fields",
                    "casctl message GPS_RAW_INT --json",
                    [wish](Session& session) { return show_message(session, *wish); });
  verb->add_option("NAME", wish->name, "Name or id, of any dialect that casd knows")->required();
  verb->add_option("--system", wish->system, "System id of its sender; left out: who sent it last")
      ->check(in_range(0, 255));
}

}  // namespace cas::casctl
