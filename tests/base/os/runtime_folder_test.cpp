// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/runtime_folder.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include "base/error.hpp"
#include "tests/base/config/scoped_environment.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::base {
namespace {

namespace fs = std::filesystem;

class RuntimeFolder : public testing::Test {
 protected:
  cas::test::TemporaryFolder folder_;
  ScopedEnvironment named_{"CAS_RUNTIME_DIR", nullptr};
  ScopedEnvironment user_{"XDG_RUNTIME_DIR", nullptr};
  ScopedEnvironment temporary_{"TMPDIR", folder_.path().c_str()};
  const fs::path none_ = folder_ / "none";
  const fs::path private_ = folder_ / ("cas-" + std::to_string(::getuid()));
};

TEST_F(RuntimeFolder, IsTheFirstThatThereIs) {
  EXPECT_EQ(runtime_folder(none_), private_);
  const fs::path service = folder_ / "service";
  fs::create_directory(service);
  EXPECT_EQ(runtime_folder(service), service);
  const ScopedEnvironment user("XDG_RUNTIME_DIR", folder_.path().c_str());
  EXPECT_EQ(runtime_folder(service), folder_ / "cas");
  const ScopedEnvironment named("CAS_RUNTIME_DIR", "/run/bench");
  EXPECT_EQ(runtime_folder(service), "/run/bench");
}

TEST_F(RuntimeFolder, AUsersFolderThatIsNotThereIsPassedBy) {
  const ScopedEnvironment user("XDG_RUNTIME_DIR", none_.c_str());
  EXPECT_EQ(runtime_folder(none_), private_);
}

TEST_F(RuntimeFolder, BelowTmpItIsOursAlone) {
  ASSERT_EQ(runtime_folder(none_), private_);
  EXPECT_EQ(fs::status(private_).permissions(), fs::perms::owner_all);
  fs::permissions(private_, fs::perms::owner_all | fs::perms::others_exec);
  EXPECT_THROW(runtime_folder(none_), ConfigError);
  fs::remove(private_);
  fs::create_symlink(folder_.path(), private_);
  EXPECT_THROW(runtime_folder(none_), ConfigError);
}

TEST_F(RuntimeFolder, VariablesAreReplacedByTheirValues) {
  const ScopedEnvironment one("CAS_TEST_ONE", "1");
  const ScopedEnvironment two("CAS_TEST_TWO", "${CAS_TEST_ONE}");
  const ScopedEnvironment named("CAS_RUNTIME_DIR", "/run/bench");
  EXPECT_EQ(expand_variables("/dev/ttyACM0"), "/dev/ttyACM0");
  EXPECT_EQ(expand_variables("${CAS_RUNTIME_DIR}/fcu${CAS_TEST_ONE}"), "/run/bench/fcu1");
  EXPECT_EQ(expand_variables("a${CAS_TEST_TWO}$b"), "a${CAS_TEST_ONE}$b") << "once";
}

TEST_F(RuntimeFolder, OnlyItsOwnVariableHasADefault) {
  EXPECT_EQ(expand_variables("${CAS_RUNTIME_DIR}"), runtime_folder().string());
  const ScopedEnvironment empty("CAS_TEST_ONE", "");
  for (const char* text : {"${CAS_TEST_NONE}/x", "${CAS_TEST_ONE}/x", "${}", "${CAS_TEST_NONE"}) {
    EXPECT_THROW(expand_variables(text), ConfigError) << text;
  }
}

}  // namespace
}  // namespace cas::base
