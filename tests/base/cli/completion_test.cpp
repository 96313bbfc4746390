// SPDX-License-Identifier: BSD-3-Clause
// Manual pages and completion scripts from a command line.
#include "base/cli/completion.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <string>

#include "base/cli/man_page.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::base::cli {
namespace {

/// A program with a verb, a verb of two words, options and an argument.
Command sample() {
  CLI::App app("Flies kites.");
  static std::string text;
  app.add_option("--speed,-s", text, "m/s")->envname("KITE_SPEED")->default_str("3");
  app.add_flag("--json")->description("as JSON");
  app.add_option("--secret", text, "for the build")->group("");
  app.add_subcommand("status", "Show the kite's state")->footer("Example: kite status");
  CLI::App* line = app.add_subcommand("line", "Handle the line");
  CLI::App* reel = line->add_subcommand("reel", "Reel it in");
  reel->add_option("METRES", text, "how far")->required();
  reel->add_flag("--slowly")->description("with care");
  app.add_subcommand("colour", "Paint it")->add_option("COLOUR", text);
  app.add_subcommand("towns", "Fly to these")->add_option("TOWN", text);
  return describe(app, {{"colour", {.known = {"red", "green"}}},
                        {"towns", {.command = "echo Bern Basel", .repeated = true}}});
}

/// Bash's completion of these words.
std::string completed(const std::string& words, int position) {
  const test::TemporaryFolder folder;
  const auto script =
      folder.write("complete.bash", bash_completion("kite", sample()) + "COMP_WORDS=(" + words +
                                        ")\nCOMP_CWORD=" + std::to_string(position) +
                                        "\n_kite_completion\necho \"${COMPREPLY[@]}\"\n");
  std::FILE* bash = ::popen(("bash '" + script.string() + "'").c_str(), "r");
  if (bash == nullptr) return "no bash";
  std::array<char, 1000> buffer{};
  const std::size_t size = std::fread(buffer.data(), 1, buffer.size() - 1, bash);
  ::pclose(bash);
  std::string result(buffer.data(), size);
  while (!result.empty() && result.back() == '\n') result.pop_back();
  return result;
}

TEST(Completion, OffersVerbsFirst) {
  EXPECT_EQ(completed("kite ''", 1), "status line colour towns");
}

TEST(Completion, OffersTheWordsOfTheFirstArgument) {
  EXPECT_EQ(completed("kite colour ''", 2), "red green");
  EXPECT_EQ(completed("kite --json colour --speed gr", 4), "green");
  EXPECT_EQ(completed("kite colour red gr", 3), "");
}

TEST(Completion, AsksForWords) {
  EXPECT_EQ(completed("kite towns Be", 2), "Bern");
  EXPECT_EQ(completed("kite towns Bern Ba", 3), "Basel");
}

TEST(Completion, OffersWhatBeginsLikeTheWord) { EXPECT_EQ(completed("kite st", 1), "status"); }

TEST(Completion, OffersVerbsOfVerbs) { EXPECT_EQ(completed("kite line ''", 2), "reel"); }

TEST(Completion, OffersOptionsOfTheVerbAndOfTheProgram) {
  EXPECT_EQ(completed("kite --json line reel --", 4), "--help --slowly --speed --json");
}

TEST(Completion, KeepsHiddenOptionsHidden) {
  EXPECT_EQ(completed("kite --se", 1), "");
  for (const std::string& script :
       {zsh_completion("kite", sample()), fish_completion("kite", sample()),
        man_page("kite", "1", "2026-01-02", sample())}) {
    EXPECT_EQ(script.find("secret"), std::string::npos) << script;
    EXPECT_NE(script.find("slowly"), std::string::npos) << script;
  }
}

TEST(ManPage, HasTheSectionsOfOne) {
  const std::string page = man_page("kite", "1.2", "2026-01-02", sample());
  for (const char* part :
       {".TH KITE 1 \"2026-01-02\" \"CAS 1.2\"", ".SH NAME\nkite \\- flies kites\n", ".SH SYNOPSIS",
        ".SH OPTIONS", "\\fB\\-s\\fR, \\fB\\-\\-speed\\fR \\fITEXT\\fR\nm/s (default: 3).\n",
        ".SS \"line reel\"", "\\fIMETRES\\fR", "Example: kite status", ".SH ENVIRONMENT",
        "KITE_SPEED", ".SH SEE ALSO"}) {
    EXPECT_NE(page.find(part), std::string::npos) << part << " in\n" << page;
  }
}

TEST(ManPage, PrintsWhatLooksLikeARequestAsText) {
  CLI::App app("Reads things.");
  app.footer(".so many\n'things' and a back\\slash");
  const std::string page = man_page("reader", "1", "2026-01-02", describe(app));
  EXPECT_NE(page.find("\n\\&.so many\n\\&'things' and a back\\eslash"), std::string::npos) << page;
}

}  // namespace
}  // namespace cas::base::cli
