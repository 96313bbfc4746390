// SPDX-License-Identifier: BSD-3-Clause
// Each program's account of itself.
#include <gtest/gtest.h>

#include <cctype>
#include <cstdlib>
#include <string>
#include <vector>

#include "tests/support/child_process.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::test {
namespace {

class Manual : public testing::TestWithParam<const char*> {
 protected:
  static std::string printed(const std::string& form) {
    ChildProcess program(
        {cas::test::binary_dir() + "/bin/" + std::string(GetParam()), "--manual", form});
    EXPECT_EQ(program.wait_exit(), 0) << program.output();
    return program.output();
  }
  /// Output of the shell command on a file with this text; empty if the command is not installed.
  std::string opinion(const std::string& command, const std::string& text) const {
    if (std::system(
            ("command -v " + command.substr(0, command.find(' ')) + " >/dev/null").c_str()) != 0) {
      return {};
    }
    ChildProcess shell(
        {"/bin/sh", "-c", command + " '" + folder_.write("text", text).string() + "'"});
    EXPECT_EQ(shell.wait_exit(), 0) << shell.output();
    return shell.output();
  }

 private:
  TemporaryFolder folder_;
};

TEST_P(Manual, IsAPageThatTroffTakesWithoutWarning) {
  const std::string page = printed("man");
  EXPECT_NE(page.find(".SH NAME\n"), std::string::npos) << page;
  EXPECT_EQ(opinion("groff -man -Tutf8 -ww -z", page), "");
}

TEST_P(Manual, CompletionIsCorrectShell) {
  EXPECT_EQ(opinion("bash -n", printed("bash")), "");
  EXPECT_EQ(opinion("zsh -n", printed("zsh")), "");
  EXPECT_EQ(opinion("fish --no-execute", printed("fish")), "");
}

INSTANTIATE_TEST_SUITE_P(Programs, Manual,
                         testing::Values("casd", "casctl", "casweb", "hilsim", "fcu_emulator",
                                         "hils", "mavlink_gen"),
                         [](const auto& test) { return std::string(test.param); });

struct KeysOf {
  std::string program;
  std::string verb{};
  std::string flag = "--keys";
  std::string page = "reference/config.md";
};

class Keys : public testing::TestWithParam<KeysOf> {};

TEST_P(Keys, AreTheTablesOfTheDocumentation) {
  const auto& [name, verb, flag, file] = GetParam();
  std::vector<std::string> words{cas::test::binary_dir() + "/bin/" + name};
  if (!verb.empty()) words.push_back(verb);
  words.push_back(flag);
  ChildProcess program(words);
  EXPECT_EQ(program.wait_exit(), 0) << program.output();

  const std::string command = name + (verb.empty() ? "" : " " + verb) + " " + flag;
  const std::string page = TemporaryFolder::read(cas::test::source_dir() + "/docs/" + file);
  const std::string begin = "<!-- " + command + " -->\n\n";
  const std::size_t from = page.find(begin);
  ASSERT_NE(from, page.npos);
  const std::size_t first = from + begin.size();
  EXPECT_EQ(page.substr(first, page.find("\n<!-- end -->", first) - first), program.output())
      << "print it with " << command;
}

INSTANTIATE_TEST_SUITE_P(Programs, Keys,
                         testing::Values(KeysOf{"casd"}, KeysOf{"fcu_emulator"}, KeysOf{"hilsim"},
                                         KeysOf{"hilsim", "", "--sensor-keys", "use/plugins.md"},
                                         KeysOf{"hils", "run"}, KeysOf{"hils", "run", "--figures"}),
                         [](const auto& test) {
                           std::string name = test.param.program;
                           for (const char c : test.param.flag) {
                             if (std::isalpha(static_cast<unsigned char>(c)) != 0) name += c;
                           }
                           return name;
                         });

}  // namespace
}  // namespace cas::test
