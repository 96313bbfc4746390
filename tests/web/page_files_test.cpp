// SPDX-License-Identifier: BSD-3-Clause
#include "web/server/page_files.hpp"

#include <gtest/gtest.h>

#include "base/error.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::web {
namespace {

TEST(PageFiles, AreFoundByTheirNamesAlone) {
  const test::TemporaryFolder folder;
  folder.write("secret", "not of the page");
  folder.write("page/index.html", "<p>");
  folder.write("page/assets/main-4f1c.js", "1");
  folder.write("page/assets/main-4f1c.js.gz", "zipped");
  const PageFiles files(folder / "page");
  ASSERT_NE(files.find("/"), nullptr);
  EXPECT_EQ(files.find("/")->body, "<p>");
  EXPECT_FALSE(files.find("/")->immutable);
  const PageFile* script = files.find("/assets/main-4f1c.js?v=1");
  ASSERT_NE(script, nullptr);
  EXPECT_STREQ(script->type, "text/javascript; charset=utf-8");
  EXPECT_EQ(script->gzip, "zipped");
  EXPECT_TRUE(script->immutable);
  for (const char* target : {"", "//", "/../secret", "/assets/../../secret", "/assets",
                             "/assets/main-4f1c.js.gz", "index.html", "/%2e%2e/secret"}) {
    EXPECT_EQ(files.find(target), nullptr) << target;
  }
}

TEST(PageFiles, OfAFolderThatIsNoPageAreRefused) {
  const test::TemporaryFolder folder;
  EXPECT_THROW(PageFiles{folder.path()}, base::ConfigError);
}

TEST(PageFiles, SayWhereNoPageWasBuilt) {
  const PageFiles files(std::nullopt);
  ASSERT_NE(files.find("/"), nullptr);
  EXPECT_NE(files.find("/")->body.find("the page is not built"), std::string::npos);
}

}  // namespace
}  // namespace cas::web
