// SPDX-License-Identifier: BSD-3-Clause
#include "base/cli/man_page.hpp"

#include <algorithm>
#include <array>
#include <cctype>

#include "base/text.hpp"

namespace cas::base::cli {

namespace {

constexpr std::array kPrograms{"casctl", "casd", "fcu_emulator", "hils", "hilsim", "mavlink_gen"};

/// Text as troff takes it literally.
std::string escaped(const std::string& text) {
  std::string result;
  bool line_begins = true;
  for (const char c : text) {
    if (line_begins && (c == '.' || c == '\'')) result += "\\&";
    line_begins = c == '\n';
    if (c == '\\') {
      result += "\\e";
    } else if (c == '-') {
      result += "\\-";
    } else {
      result += c;
    }
  }
  return result;
}

/// With one full stop at its end.
std::string sentence(std::string text) {
  while (!text.empty() && text.back() == '.') text.pop_back();
  return escaped(text) + ".\n";
}

/// "Fly one scenario." -> "fly one scenario", as in the list that apropos prints.
std::string what_it_does(std::string text) {
  while (!text.empty() && (text.back() == '.' || text.back() == '\n')) text.pop_back();
  if (text.size() > 1 && std::islower(static_cast<unsigned char>(text[1])) != 0) {
    text[0] = static_cast<char>(std::tolower(static_cast<unsigned char>(text[0])));
  }
  return text;
}

std::string synopsis(const Command& command) {
  std::string text;
  const bool has_options =
      std::ranges::any_of(command.arguments, [](const Argument& a) { return !a.positional; });
  if (has_options) text += " [\\fIoptions\\fR]";
  for (const Argument& argument : command.arguments) {
    if (!argument.positional) continue;
    const std::string name = "\\fI" + escaped(argument.names[0]) + "\\fR";
    text += argument.required ? " " + name : " [" + name + "]";
  }
  if (!command.commands.empty()) text += " \\fIcommand\\fR";
  return text;
}

std::string tagged(const Argument& argument) {
  std::string text = ".TP\n";
  const char* separator = "";
  for (const std::string& name : argument.names) {
    const char* face = argument.positional ? "\\fI" : "\\fB";
    text += separator + std::string(face) + escaped(name) + "\\fR";
    separator = ", ";
  }
  if (!argument.value.empty()) text += " \\fI" + escaped(argument.value) + "\\fR";
  std::string description = argument.description;
  if (!argument.fallback.empty()) description += " (default: " + argument.fallback + ")";
  return text + "\n" + sentence(description);
}

void add_arguments(std::string& text, const Command& command) {
  for (const bool positional : {true, false}) {
    for (const Argument& argument : command.arguments) {
      const bool is_help = argument.names.back() == "--help" && !command.path.empty();
      if (argument.positional == positional && !is_help) text += tagged(argument);
    }
  }
}

void add_footer(std::string& text, const Command& command) {
  if (!command.footer.empty()) text += ".PP\n" + escaped(command.footer) + "\n";
}

void add_environment(std::string& text, const Command& command) {
  std::string entries;
  for_each_command(command, [&entries](const Command& c) {
    for (const Argument& argument : c.arguments) {
      if (argument.environment.empty()) continue;
      entries += ".TP\n\\fB" + escaped(argument.environment) + "\\fR\nStands in for \\fB" +
                 escaped(argument.names.back()) + "\\fR.\n";
    }
  });
  if (!entries.empty()) text += ".SH ENVIRONMENT\n" + entries;
}

void add_see_also(std::string& text, const std::string& program) {
  text += ".SH SEE ALSO\n";
  const char* separator = "";
  for (const char* other : kPrograms) {
    if (other == program) continue;
    text += separator + std::string("\\fB") + escaped(other) + "\\fR(1)";
    separator = ",\n";
  }
  text +=
      "\n.PP\nWhat the configuration files may say stands in "
      "/usr/share/doc/cas-common/docs/reference/config.md.\n";
}

}  // namespace

std::string man_page(const std::string& program, const std::string& version,
                     const std::string& date, const Command& command) {
  std::string text =
      ".TH " + upper(program) + " 1 \"" + date + "\" \"CAS " + version + "\" \"CAS\"\n";
  text += ".SH NAME\n" + escaped(program) + " \\- " + escaped(what_it_does(command.description)) +
          "\n.SH SYNOPSIS\n\\fB" + escaped(program) + "\\fR" + synopsis(command) + "\n";
  text += ".SH OPTIONS\n";
  add_arguments(text, command);
  add_footer(text, command);
  if (!command.commands.empty()) text += ".SH COMMANDS\n";
  for_each_command(command, [&text](const Command& c) {
    if (c.path.empty()) return;
    text += ".SS \"" + escaped(c.words()) + "\"" + "\n";
    text +=
        sentence(c.description) + ".PP\n\\fB" + escaped(c.words()) + "\\fR" + synopsis(c) + "\n";
    add_arguments(text, c);
    add_footer(text, c);
  });
  add_environment(text, command);
  add_see_also(text, program);
  return text;
}

}  // namespace cas::base::cli
