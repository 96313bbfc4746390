// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/monitor/prompt.hpp"

#include <algorithm>
#include <charconv>
#include <optional>
#include <sstream>

#include "base/suggestion.hpp"
#include "base/text.hpp"
#include "casd/casctl/session/text.hpp"

namespace cas::casctl {
namespace {

using nlohmann::json;

struct PromptArgument {
  const char* name;  ///< of the usage
  const char* key;   ///< of the call's parameters
  bool is_number = true;
  bool is_needed = true;
};

/// A verb of the prompt, in the words that casctl takes on the command line.
struct PromptVerb {
  std::string words;
  const char* method;
  std::vector<PromptArgument> arguments{};
  bool of_vehicle = true;
};

const std::vector<PromptVerb>& verbs() {
  static const std::vector<PromptVerb> kVerbs{
      {"arm", "vehicle.arm"},
      {"disarm", "vehicle.disarm"},
      {"takeoff", "vehicle.takeoff", {{"ALT", "altitude_m"}}},
      {"land", "vehicle.land"},
      {"hold", "vehicle.hold"},
      {"rtl", "vehicle.rtl"},
      {"goto",
       "vehicle.goto",
       {{"NORTH", "north_m"},
        {"EAST", "east_m"},
        {"DOWN", "down_m"},
        {"YAW", "yaw_deg", true, false}}},
      {"mode", "vehicle.mode", {{"MODE", "mode", false}}},
      {"setgain",
       "gain.set",
       {{"LOOP", "loop", false}, {"P", "p"}, {"I", "i", true, false}, {"D", "d", true, false}}},
      {"param get", "param.get", {{"NAME", "name", false}}},
      {"param set", "param.set", {{"NAME", "name", false}, {"VALUE", "value"}}},
      {"message-interval",
       "vehicle.message_interval",
       {{"MESSAGE", "message", false}, {"HZ", "hz", true, false}}},
      {"log start", "log.start", {{"NAME", "file", false, false}}, false},
      {"log stop", "log.stop", {}, false},
  };
  return kVerbs;
}

std::optional<double> number(const std::string& text) {
  double value = 0;
  const auto end = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end.ec != std::errc() || end.ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string usage(const PromptVerb& verb) {
  std::string text = verb.words;
  for (const PromptArgument& argument : verb.arguments) {
    text += argument.is_needed ? std::string(" ") + argument.name
                               : std::string(" [") + argument.name + "]";
  }
  return text;
}

std::vector<std::string> split(const std::string& line) {
  std::istringstream in(line);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

/// How many of the words are those of the verb; 0: they are others.
std::size_t words_of(const PromptVerb& verb, const std::vector<std::string>& words) {
  const std::vector<std::string> own = split(verb.words);
  if (words.size() < own.size() || !std::equal(own.begin(), own.end(), words.begin())) return 0;
  return own.size();
}

/// The verb that these words begin with.
const PromptVerb* find_verb(const std::vector<std::string>& words) {
  const auto found = std::find_if(verbs().begin(), verbs().end(), [&](const PromptVerb& verb) {
    return words_of(verb, words) > 0;
  });
  return found == verbs().end() ? nullptr : &*found;
}

void add_word(std::vector<std::string>& to, const std::string& word) {
  if (std::find(to.begin(), to.end(), word) == to.end()) to.push_back(word);
}

/// The verbs' next words behind those that stand already.
std::vector<std::string> next_words(const std::vector<std::string>& standing) {
  std::vector<std::string> next;
  for (const PromptVerb& verb : verbs()) {
    const std::vector<std::string> own = split(verb.words);
    if (own.size() <= standing.size()) continue;
    if (std::equal(standing.begin(), standing.end(), own.begin())) {
      add_word(next, own[standing.size()]);
    }
  }
  return next;
}

/// Words for the first argument of a verb.
std::vector<std::string> argument_words(const PromptVerb& verb, const PromptWords& words,
                                        bool& wants_parameters) {
  const auto found = words.by_verb.find(verb.words);
  if (found == words.by_verb.end()) return {};
  if (!found->second.known.empty()) return found->second.known;
  if (found->second.command.ends_with("messages")) return words.messages;
  if (!found->second.command.ends_with("parameters")) return {};
  wants_parameters = words.parameters.empty();
  return words.parameters;
}

/// Common prefix of these words.
std::string common_beginning(const std::vector<std::string>& words) {
  std::string common = words.front();
  for (const std::string& word : words) {
    std::size_t same = 0;
    while (same < common.size() && same < word.size() && common[same] == word[same]) ++same;
    common.resize(same);
  }
  return common;
}

}  // namespace

std::variant<PromptCall, std::string> parse_prompt(const std::string& line) {
  std::vector<std::string> given = split(line);
  const PromptVerb* verb = find_verb(given);
  if (verb == nullptr) {
    const std::string word = given.empty() ? "" : given.front();
    const std::string next = base::joined(next_words({word}), ", ");
    if (!next.empty()) return "behind '" + word + "' stands one of " + next;
    const std::string meant = base::did_you_mean(word, next_words({}));
    return "there is no command '" + word + "'" + (meant.empty() ? "; ? lists them" : meant);
  }
  given.erase(given.begin(), given.begin() + static_cast<std::ptrdiff_t>(words_of(*verb, given)));
  const auto needed = static_cast<std::size_t>(
      std::count_if(verb->arguments.begin(), verb->arguments.end(),
                    [](const PromptArgument& argument) { return argument.is_needed; }));
  if (given.size() < needed || given.size() > verb->arguments.size()) {
    return "usage: " + usage(*verb);
  }
  PromptCall call{.method = verb->method, .of_vehicle = verb->of_vehicle};
  for (std::size_t i = 0; i < given.size(); ++i) {
    const PromptArgument& argument = verb->arguments[i];
    const std::optional<double> value = number(given[i]);
    if (argument.is_number && !value) {
      return "'" + given[i] + "' is no number; usage: " + usage(*verb);
    }
    // A message may be given by its id.
    const bool as_number = argument.is_number || (value && std::string(argument.key) == "message");
    call.params[argument.key] = as_number ? json(*value) : json(given[i]);
  }
  return call;
}

std::string answer_text(const PromptCall& call, const json& result) {
  if (call.method.starts_with("param.")) return param_text(result);
  if (call.method == "gain.set") return gains_text(result);
  if (call.method == "log.start") return "recording into " + result.value("file", "?");
  if (call.method == "log.stop") {
    return json(result.value("recorded", 0)).dump() + " packets recorded into " +
           result.value("file", "?");
  }
  const std::string word = result.value("result", "");
  return word.empty() ? "done" : word;
}

Completion complete(const std::string& line, const PromptWords& words) {
  Completion completion{.line = line};
  std::vector<std::string> standing = split(line);
  std::string begun;
  if (!standing.empty() && line.back() != ' ') {
    begun = standing.back();
    standing.pop_back();
  }
  const PromptVerb* verb = find_verb(standing);
  std::vector<std::string> possible;
  if (verb == nullptr) {
    possible = next_words(standing);
  } else {
    completion.usage = usage(*verb);
    if (standing.size() == split(verb->words).size()) {
      possible = argument_words(*verb, words, completion.wants_parameters);
    }
  }
  for (const std::string& word : possible) {
    if (base::lower(word).starts_with(base::lower(begun))) completion.offers.push_back(word);
  }
  if (completion.offers.empty()) return completion;
  const std::string common = common_beginning(completion.offers);
  if (common.size() >= begun.size()) {
    completion.line = line.substr(0, line.size() - begun.size()) + common;
  }
  if (completion.offers.size() == 1) completion.line += ' ';
  return completion;
}

std::vector<std::string> prompt_usages() {
  std::vector<std::string> all;
  for (const PromptVerb& verb : verbs()) all.push_back(usage(verb));
  return all;
}

}  // namespace cas::casctl
