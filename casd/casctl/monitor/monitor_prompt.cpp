// SPDX-License-Identifier: BSD-3-Clause
#include <charconv>
#include <sstream>

#include "casd/casctl/monitor/monitor_model.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

std::optional<double> number(const std::string& text) {
  double value = 0;
  const auto end = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end.ec != std::errc() || end.ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

/// A verb of the prompt: the method, and the names of its arguments.
struct Verb {
  const char* word;
  const char* method;
  std::size_t needed;
  std::vector<const char*> numbers;  ///< after the word argument, where there is one
  const char* text = nullptr;        ///< name of the first argument when it is a word
};

const std::vector<Verb>& verbs() {
  static const std::vector<Verb> kVerbs{
      {"arm", "vehicle.arm", 0, {}},
      {"disarm", "vehicle.disarm", 0, {}},
      {"takeoff", "vehicle.takeoff", 1, {"altitude_m"}},
      {"land", "vehicle.land", 0, {}},
      {"hold", "vehicle.hold", 0, {}},
      {"rtl", "vehicle.rtl", 0, {}},
      {"goto", "vehicle.goto", 3, {"north_m", "east_m", "down_m", "yaw_deg"}},
      {"mode", "vehicle.mode", 1, {}, "mode"},
      {"setgain", "gain.set", 2, {"p", "i", "d"}, "loop"},
      {"message-interval", "vehicle.message_interval", 1, {"hz"}, "message"},
      {"param", "param.set", 2, {"value"}, "name"},
  };
  return kVerbs;
}

std::string usage(const Verb& verb) {
  std::string text = std::string("usage: ") + verb.word;
  std::size_t index = 0;
  const auto add = [&](const char* name) {
    text += index < verb.needed ? std::string(" ") + name : std::string(" [") + name + "]";
    ++index;
  };
  if (verb.text != nullptr) add(verb.text);
  for (const char* name : verb.numbers) add(name);
  return text;
}

}  // namespace

std::variant<PromptCall, std::string> parse_prompt(const std::string& line) {
  std::istringstream in(line);
  std::string word;
  in >> word;
  for (const Verb& verb : verbs()) {
    if (word != verb.word) continue;
    std::vector<std::string> given;
    for (std::string argument; in >> argument;) given.push_back(argument);
    const std::size_t words = verb.text == nullptr ? 0 : 1;
    if (given.size() < verb.needed || given.size() > words + verb.numbers.size())
      return usage(verb);
    PromptCall call{.method = verb.method};
    if (verb.text != nullptr) call.params[verb.text] = given[0];
    for (std::size_t i = words; i < given.size(); ++i) {
      const std::optional<double> value = number(given[i]);
      if (!value) return "'" + given[i] + "' is no number; " + usage(verb);
      call.params[verb.numbers[i - words]] = *value;
    }
    return call;
  }
  return "there is no command '" + word + "'; ? lists them";
}

}  // namespace cas::casctl
