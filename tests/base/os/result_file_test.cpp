// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/result_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::base {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A folder of results beside a folder with a file that no result may touch.
class ResultFile : public testing::Test {
 protected:
  ResultFile() {
    fs::create_directory(out_);
    fs::create_directory(elsewhere_);
    std::ofstream(precious_) << "keep me";
  }

  void expect_untouched() const {
    EXPECT_EQ(text_of(precious_), "keep me");
    EXPECT_EQ(std::distance(fs::directory_iterator(elsewhere_), {}), 1);
  }

  const test::TemporaryFolder folder_;
  const fs::path out_ = folder_.path() / "out";
  const fs::path elsewhere_ = folder_.path() / "elsewhere";
  const fs::path precious_ = elsewhere_ / "precious";
};

struct Writer {
  const char* name;
  std::function<void(const ResultPlace&)> write;
};

const std::vector<Writer>& writers() {
  static const std::vector<Writer> all{
      {"Write", [](const ResultPlace& place) { write_result(place, "new"); }},
      {"Make",
       [](const ResultPlace& place) { ASSERT_EQ(::write(make_result(place).get(), "new", 3), 3); }},
      {"Open", [](const ResultPlace& place) { std::fputs("new", open_result(place).get()); }},
      {"Append",
       [](const ResultPlace& place) {
         ASSERT_EQ(::write(append_result(place).get(), "new", 3), 3);
       }},
  };
  return all;
}

TEST_F(ResultFile, IsMadeWithTheFoldersOnTheWay) {
  for (const Writer& writer : writers()) {
    const fs::path file = fs::path(writer.name) / "a" / "file";
    writer.write({out_, file});
    EXPECT_EQ(text_of(out_ / file), "new") << writer.name;
  }
}

TEST_F(ResultFile, MayBeGivenByItsWholePath) {
  write_result({out_, out_ / "run" / "file"}, "new");
  EXPECT_EQ(text_of(out_ / "run" / "file"), "new");
}

TEST_F(ResultFile, TakesThePlaceOfASymlink) {
  for (const Writer& writer : writers()) {
    if (std::string_view(writer.name) == "Append") continue;
    const fs::path file = out_ / writer.name;
    fs::create_symlink(precious_, file);
    writer.write({out_, file});
    EXPECT_FALSE(fs::is_symlink(file)) << writer.name;
    EXPECT_EQ(text_of(file), "new") << writer.name;
  }
  expect_untouched();
}

TEST_F(ResultFile, TakesThePlaceOfAHardLink) {
  for (const Writer& writer : writers()) {
    if (std::string_view(writer.name) == "Append") continue;
    fs::create_hard_link(precious_, out_ / writer.name);
    writer.write({out_, writer.name});
  }
  expect_untouched();
}

TEST_F(ResultFile, IsNotAppendedToAFileElsewhere) {
  fs::create_symlink(precious_, out_ / "soft");
  fs::create_hard_link(precious_, out_ / "hard");
  EXPECT_THROW(append_result({out_, "soft"}), ConfigError);
  EXPECT_THROW(append_result({out_, "hard"}), ConfigError);
  expect_untouched();
}

TEST_F(ResultFile, IsNotWrittenThroughAFolderThatIsASymlink) {
  fs::create_directory_symlink(elsewhere_, out_ / "run");
  for (const Writer& writer : writers()) {
    for (const char* file : {"run/file", "run/precious", "run/a/file"}) {
      EXPECT_THROW(writer.write({out_, file}), ConfigError) << writer.name << " " << file;
    }
  }
  EXPECT_THROW(make_result_folder({out_, "run"}), ConfigError);
  EXPECT_THROW(make_result_folder({out_, "run/a"}), ConfigError);
  EXPECT_THROW(remove_result({out_, "run/precious"}), ConfigError);
  expect_untouched();
}

TEST_F(ResultFile, StaysBelowItsFolder) {
  for (const Writer& writer : writers()) {
    for (const fs::path& file :
         {precious_, fs::path("../elsewhere/precious"), fs::path("a/../../elsewhere/precious"),
          out_ / "../elsewhere/precious", fs::path()}) {
      EXPECT_THROW(writer.write({out_, file}), ConfigError) << writer.name << " " << file;
    }
  }
  expect_untouched();
}

TEST_F(ResultFile, IsRemoved) {
  write_result({out_, "run/file"}, "old");
  remove_result({out_, "run/file"});
  EXPECT_FALSE(fs::exists(out_ / "run/file"));
  remove_result({out_, "run/file"});
  remove_result({out_, "none/file"});
}

TEST_F(ResultFile, PathsOfAConfigurationAreRelativeAndGoDownOnly) {
  EXPECT_EQ(fault_of_result_path("a/b.csv"), "");
  EXPECT_EQ(fault_of_result_path("..a/b..csv"), "");
  EXPECT_NE(fault_of_result_path("/a"), "");
  EXPECT_NE(fault_of_result_path("../a"), "");
  EXPECT_NE(fault_of_result_path("a/../b"), "");
  EXPECT_NE(fault_of_result_path(""), "");
}

TEST(ResultFolder, IsRemovedWithWhatItHoldsAndNothingBehindASymlink) {
  const test::TemporaryFolder folder;
  const fs::path out = folder / "out";
  folder.write("out/run/a/b", "");
  folder.write("theirs/row_1/file", "");
  remove_result_folder({out, "run"});
  EXPECT_FALSE(fs::exists(out / "run"));
  remove_result_folder({out, "none/row_1"});
  fs::create_directory_symlink(folder / "theirs", out / "run");
  EXPECT_THROW(remove_result_folder({out, "run/row_1"}), ConfigError);
  remove_result_folder({out, "run"});
  EXPECT_FALSE(fs::exists(fs::symlink_status(out / "run")));
  EXPECT_TRUE(fs::exists(folder / "theirs/row_1/file"));
}

TEST(ResultFolder, IsNotReachedByASymlinkOfAnotherUser) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can lay files for another user";
  const test::TemporaryFolder folder;
  fs::create_directories(folder / "behind/out");
  const fs::path link = folder / "link";
  fs::create_directory_symlink("behind", link);
  write_result({link / "out", "a.txt"}, "one");
  EXPECT_TRUE(fs::exists(folder / "behind/out/a.txt"));
  ASSERT_EQ(::lchown(link.c_str(), 1234, 1234), 0);
  EXPECT_THROW(write_result({link / "out", "b.txt"}, "two"), ConfigError);
  EXPECT_THROW(make_out_folder(link / "made"), ConfigError);
  EXPECT_FALSE(fs::exists(folder / "behind/out/b.txt"));
  EXPECT_FALSE(fs::exists(folder / "behind/made"));
}

TEST(ResultFolder, ThatCannotBeMadeNamesTheReason) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(test::refusal([] { make_out_folder("/proc/none/out"); }),
            "/proc/none/out: cannot be written: No such file or directory");
  make_out_folder(folder / "a/b/");
  EXPECT_TRUE(fs::is_directory(folder / "a/b"));
}

TEST(ResultFolder, OfAnotherUserIsNotEntered) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can lay files for another user";
  const test::TemporaryFolder folder;
  fs::create_directories(folder / "out/work");
  ASSERT_EQ(::chown((folder / "out/work").c_str(), 1234, 1234), 0);
  EXPECT_THROW(make_result_folder({folder / "out", "work/row_1"}), ConfigError);
}

}  // namespace
}  // namespace cas::base
