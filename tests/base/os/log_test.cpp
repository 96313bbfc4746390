// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/log.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cstdio>
#include <thread>
#include <vector>

#include "base/error.hpp"
#include "tests/base/config/scoped_environment.hpp"

namespace cas::base {
namespace {

/// Sends standard error to a file for the life of the object.
class CapturedStderr {
 public:
  CapturedStderr() : file_(std::tmpfile()), saved_(::dup(2)) { ::dup2(::fileno(file_), 2); }
  ~CapturedStderr() {
    ::dup2(saved_, 2);
    ::close(saved_);
    std::fclose(file_);
    log::init("base_test");
  }
  CapturedStderr(const CapturedStderr&) = delete;
  CapturedStderr& operator=(const CapturedStderr&) = delete;

  /// JOURNAL_STREAM as systemd would set it.
  std::string journal_stream() const {
    struct stat status {};
    ::fstat(2, &status);
    return std::to_string(status.st_dev) + ":" + std::to_string(status.st_ino);
  }
  std::string text() const {
    std::string content(static_cast<std::size_t>(::lseek(::fileno(file_), 0, SEEK_END)), '\0');
    const ssize_t size = ::pread(::fileno(file_), content.data(), content.size(), 0);
    content.resize(static_cast<std::size_t>(size));
    return content;
  }

 private:
  std::FILE* file_;
  int saved_;
};

TEST(Log, ALineNamesProgramAndLevel) {
  const CapturedStderr captured;
  log::init("casd");
  log::warn("link fcu is down");
  EXPECT_TRUE(captured.text().ends_with(" casd warning: link fcu is down\n")) << captured.text();
}

TEST(Log, LinesBelowTheLevelAreLeftOut) {
  const CapturedStderr captured;
  log::init("casd", log::Level::kWarn);
  log::debug("a");
  log::info("b");
  EXPECT_EQ(captured.text(), "");
  log::init("casd", log::Level::kOff);
  log::error("c");
  EXPECT_EQ(captured.text(), "");
}

TEST(Log, UnderJournaldALineBeginsWithItsPriority) {
  const CapturedStderr captured;
  const ScopedEnvironment stream("JOURNAL_STREAM", captured.journal_stream().c_str());
  log::init("casd", log::Level::kDebug);
  log::debug("d");
  log::info("i");
  log::warn("w");
  log::error("e");
  EXPECT_EQ(captured.text(), "<7>d\n<6>i\n<4>w\n<3>e\n");
}

TEST(Log, AJournalStreamOfAnotherDescriptorIsIgnored) {
  const CapturedStderr captured;
  const ScopedEnvironment stream("JOURNAL_STREAM", "1:2");
  log::init("casd");
  log::info("i");
  EXPECT_TRUE(captured.text().ends_with("casd info: i\n"));
}

TEST(Log, TextFromTheWireCannotForgeALine) {
  const CapturedStderr captured;
  const ScopedEnvironment stream("JOURNAL_STREAM", captured.journal_stream().c_str());
  log::init("casd");
  log::info("status \"x\n<3>all is lost\x1b[2J{}%v\"");
  EXPECT_EQ(captured.text(), "<6>status \"x?<3>all is lost?[2J{}%v\"\n");
}

TEST(Log, APercentSignInTheProgramsNameIsItself) {
  const CapturedStderr captured;
  log::init("50%v");
  log::info("x");
  EXPECT_TRUE(captured.text().ends_with(" 50%v info: x\n")) << captured.text();
}

TEST(Log, LinesOfSeveralThreadsStayWhole) {
  const CapturedStderr captured;
  log::init("casd");
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([] {
      for (int line = 0; line < 100; ++line) log::info("0123456789");
    });
  }
  for (std::thread& thread : threads) thread.join();
  const std::string text = captured.text();
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 400);
}

TEST(Log, LevelsAreReadByName) {
  EXPECT_EQ(log::parse_level("debug"), log::Level::kDebug);
  EXPECT_EQ(log::parse_level("off"), log::Level::kOff);
  EXPECT_THROW(log::parse_level("loud"), ConfigError);
}

}  // namespace
}  // namespace cas::base
