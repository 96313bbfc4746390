// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

namespace CLI {
class App;
}

namespace cas::base::cli {

/// A verb of a program. The variables of its flags live as long as `run`.
struct Verb {
  const CLI::App* asked;     ///< of the program's command line
  std::function<int()> run;  ///< runs the verb; @return exit code
};

/// The one of these that the command line asks for; nullptr: none.
const Verb* find_asked(const std::vector<Verb>& verbs);

}  // namespace cas::base::cli
