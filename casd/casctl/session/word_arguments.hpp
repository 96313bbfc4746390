// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "casd/casctl/session/command_line.hpp"

namespace cas::casctl {

/// Arguments of a verb that are words out of a list; another word is wrong usage.
struct WordArguments {
  std::string verb;                ///< as it was added to the command line
  std::string name;                ///< in the help: "TOPIC"
  std::string help;                ///< their meaning
  std::vector<std::string> known;  ///< the words that may be given
};

/// @param words  takes those given; outlives the parsing
Argument add_words(CommandLine& line, const WordArguments& arguments,
                   std::vector<std::string>& words);

}  // namespace cas::casctl
