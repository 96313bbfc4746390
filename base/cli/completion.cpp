// SPDX-License-Identifier: BSD-3-Clause
#include "base/cli/completion.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

namespace cas::base::cli {

namespace {

/// Within single quotes of a shell.
std::string single_quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) {
    if (c == '\'') {
      result += "'\\''";
    } else {
      result += c == '\n' ? ' ' : c;
    }
  }
  return result + "'";
}

std::string replaced(std::string text, std::string_view from, std::string_view to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
  return text;
}

/// A name that a shell takes for a function.
std::string function_name(const std::string& program) {
  return "_" + replaced(program, "-", "_") + "_completion";
}

/// Patterns "status|param|param get" of every verb, from which a script finds the verb at the
/// cursor.
std::string verb_patterns(const Command& command) {
  std::string patterns;
  for_each_command(command, [&patterns](const Command& c) {
    if (c.path.empty()) return;
    patterns += (patterns.empty() ? "" : "|") + single_quoted(c.words());
  });
  return patterns;
}

std::string words_of(const Command& command) {
  std::string words;
  for (const Command& below : command.commands) words += below.path.back() + " ";
  return words;
}

/// Known words of a verb's arguments, with spaces.
std::string known_words(const Command& command) {
  std::string words;
  for (const std::string& word : command.offers.known) words += word + " ";
  return words;
}

/// For a shell's arithmetic: behind how many arguments its words are still offered.
std::string word_limit(const Command& command) {
  if (command.offers.empty()) return "0";
  return command.offers.repeated ? "999" : "1";
}

/// The options that may stand behind a command: its own, then the program's.
std::vector<Argument> options_at(const Command& command, const Command& program) {
  std::vector<Argument> options;
  const auto add = [&options](const Argument& argument) {
    const auto is_it = [&](const Argument& a) { return a.names.back() == argument.names.back(); };
    if (!argument.positional && std::ranges::none_of(options, is_it)) options.push_back(argument);
  };
  std::ranges::for_each(command.arguments, add);
  std::ranges::for_each(program.arguments, add);
  return options;
}

}  // namespace

std::string bash_completion(const std::string& program, const Command& command) {
  std::string cases;
  for_each_command(command, [&](const Command& c) {
    std::string options;
    for (const Argument& option : options_at(c, command)) options += option.names.back() + " ";
    cases += "    " + single_quoted(c.words()) + ") verbs=" + single_quoted(words_of(c)) +
             "; options=" + single_quoted(options) + "; words=" + single_quoted(known_words(c)) +
             "; ask=" + single_quoted(c.offers.command) + "; most=" + word_limit(c) + " ;;\n";
  });
  const std::string patterns = verb_patterns(command);
  const std::string walk =
      patterns.empty() ? "" : R"sh(  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    case "${at:+$at }$word" in
      )sh" + patterns + R"sh() at="${at:+$at }$word"; given=0 ;;
      *) [[ $word == -* ]] || given=$((given + 1)) ;;
    esac
  done
)sh";
  return "# bash completion for " + program + "\n" + function_name(program) +
         R"sh(() {
  local cur=${COMP_WORDS[COMP_CWORD]} at='' word verbs options words ask most=0 given=0
)sh" + walk +
         R"sh(  case $at in
)sh" + cases +
         R"sh(  esac
  if [[ $cur == -* ]]; then
    COMPREPLY=($(compgen -W "$options" -- "$cur"))
  elif [[ -n $verbs ]]; then
    COMPREPLY=($(compgen -W "$verbs" -- "$cur"))
  elif (( given < most )); then
    [[ -z $ask ]] || words+=" $($ask 2>/dev/null)"
    COMPREPLY=($(compgen -W "$words" -- "$cur"))
  else
    COMPREPLY=($(compgen -f -- "$cur"))
    compopt -o filenames 2>/dev/null
  fi
}
complete -F )sh" +
         function_name(program) + " " + program + "\n";
}

std::string zsh_completion(const std::string& program, const Command& command) {
  const auto described = [](const std::string& name, const std::string& description) {
    return single_quoted(replaced(name, ":", "\\:") + ":" + description) + " ";
  };
  std::string cases;
  for_each_command(command, [&](const Command& c) {
    std::string verbs;
    for (const Command& below : c.commands)
      verbs += described(below.path.back(), below.description);
    std::string options;
    for (const Argument& option : options_at(c, command)) {
      options += described(option.names.back(), option.description);
    }
    cases += "    " + single_quoted(c.words()) + ")\n      verbs=(" + verbs + ")\n      options=(" +
             options + ")\n      given_words=(" + known_words(c) + ")\n      ask=(" +
             c.offers.command + ")\n      most=" + word_limit(c) + " ;;\n";
  });
  const std::string patterns = verb_patterns(command);
  const std::string walk = patterns.empty() ? "" : R"sh(  for word in "${(@)words[2,CURRENT-1]}"; do
    case "${at:+$at }$word" in
      ()sh" + patterns + R"sh() at="${at:+$at }$word"; given=0 ;;
      (*) [[ $word == -* ]] || (( given += 1 )) ;;
    esac
  done
)sh";
  return "#compdef " + program + "\n" + function_name(program) + R"sh(() {
  local at='' word most=0 given=0
  local -a verbs options given_words ask
)sh" + walk +
         R"sh(  case $at in
)sh" + cases +
         R"sh(  esac
  if [[ $PREFIX == -* ]]; then
    _describe -o option options
  elif (( $#verbs )); then
    _describe command verbs
  elif (( given < most )); then
    (( $#ask )) && given_words+=($($ask 2>/dev/null))
    compadd -a given_words
  else
    _files
  fi
}
)sh" + function_name(program) +
         " \"$@\"\n";
}

std::string fish_completion(const std::string& program, const Command& command) {
  const std::string where = "__" + replaced(program, "-", "_") + "_at";
  const std::string patterns = replaced(verb_patterns(command), "|", " ");
  std::string text = "# fish completion for " + program + "\nfunction " + where + R"sh(
  set -l at
  for word in (commandline -opc)[2..-1]
    set -l longer (string join ' ' $at $word)
    if contains -- $longer )sh" +
                     (patterns.empty() ? "''" : patterns) + R"sh(
      set at (string split ' ' $longer)
    end
  end
  test "$at" = "$argv"
end
)sh";
  for_each_command(command, [&](const Command& c) {
    const std::string condition =
        c.path.empty() ? "" : " -n " + single_quoted(where + " " + c.words());
    const std::string here = " -n " + single_quoted(where + " " + c.words());
    for (const Command& below : c.commands) {
      text += "complete -c " + program + here + " -f -a " + below.path.back() + " -d " +
              single_quoted(below.description) + "\n";
    }
    if (!c.offers.empty()) {
      const std::string asked =
          c.offers.command.empty() ? "" : "(" + c.offers.command + " 2>/dev/null)";
      text += "complete -c " + program + here + " -f -a " + single_quoted(known_words(c) + asked) +
              "\n";
    }
    for (const Argument& argument : c.arguments) {
      if (argument.positional) continue;
      text += "complete -c " + program + condition;
      for (const std::string& name : argument.names) {
        const bool is_long = name.starts_with("--");
        text += (is_long ? " -l " : " -s ") + name.substr(is_long ? 2 : 1);
      }
      if (!argument.value.empty()) text += " -r";
      text += " -d " + single_quoted(argument.description) + "\n";
    }
  });
  return text;
}

}  // namespace cas::base::cli
