// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/session/word_arguments.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <optional>

#include "base/suggestion.hpp"

namespace cas::casctl {
namespace {

/// Why a word is wrong; nullopt if it is known.
std::optional<std::string> fault_of(const std::string& word,
                                    const std::vector<std::string>& known) {
  if (std::find(known.begin(), known.end(), word) != known.end()) return std::nullopt;
  const std::string meant = base::did_you_mean(word, known);
  if (!meant.empty()) return "there is no '" + word + "'" + meant;
  std::string words;
  for (const std::string& each : known) words += " " + each;
  return "there is no '" + word + "'; there is" + words;
}

}  // namespace

Argument add_words(CommandLine& line, const WordArguments& arguments,
                   std::vector<std::string>& words) {
  CLI::App* verb = line.app().get_subcommand(arguments.verb);
  return Argument(verb->add_option(arguments.name, words, arguments.help)
                      ->check([known = arguments.known](const std::string& word) {
                        return fault_of(word, known).value_or("");  // CLI11: empty is no error
                      }));
}

}  // namespace cas::casctl
