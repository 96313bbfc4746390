// SPDX-License-Identifier: BSD-3-Clause
#include "hils/replay/replay_page.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/os/write_file.hpp"
#include "base/rpc/base64.hpp"
#include "hils/measure/column.hpp"
#include "hils/programs/web_view.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

TEST(ReplayColumn, IsTheDifferencesOfWholeSteps) {
  const std::vector<double> values{1.0, 1.26, std::nan(""), -0.5};
  EXPECT_EQ(column_json(values, 0.5).dump(), R"({"k":0.5,"d":[2,1,0,-4]})");
  const std::vector<double> huge{std::numeric_limits<double>::max()};
  EXPECT_EQ(column_json(huge, 1).at("d").at(0).get<double>(), 9e15);
}

TEST(ReplayPage, GzipIsRepeatableAndCheckedToItsEnd) {
  const std::string text(100'000, 'a');
  EXPECT_EQ(gzip(text), gzip(text));
  EXPECT_LT(gzip(text).size(), 1000U);
  const std::string whole = gzip(text);
  EXPECT_NO_THROW(check_gzip(whole));
  EXPECT_THROW(check_gzip("no record"), base::ConfigError);
  EXPECT_THROW(check_gzip(whole.substr(0, whole.size() / 2)), base::ConfigError);
}

/// CAS_WEB_PATH as long as it lives.
class WebPath {
 public:
  explicit WebPath(const std::string& folder) { ::setenv("CAS_WEB_PATH", folder.c_str(), 1); }
  ~WebPath() { ::unsetenv("CAS_WEB_PATH"); }
  WebPath(const WebPath&) = delete;
  WebPath& operator=(const WebPath&) = delete;
};

TEST(ReplayPage, HasTheRecordsInTheirPlace) {
  const cas::test::TemporaryFolder folder;
  base::write_file(folder.path() / "index.html", "-");
  base::write_file(folder.path() / "replay.html", "<body><!--RECORDS--></body>");
  const WebPath path(folder.path().string());
  const std::vector<std::string> records{"foo", "f"};
  EXPECT_EQ(replay_page(records),
            "<body><script type=\"application/octet-stream\" class=\"record\">Zm9v</script>\n"
            "<script type=\"application/octet-stream\" class=\"record\">Zg==</script>\n</body>");
}

TEST(ReplayPage, OfTwoRunsSaysWhereEachIsFromAndWhatItFlewWith) {
  const cas::test::TemporaryFolder folder;
  folder.write("index.html", "-");
  folder.write("replay.html", "<body><!--RECORDS--></body>");
  folder.write("b/run/hilsim.yaml", "plugins: [{plugin: wind, mean_m_s: 9}]\n");
  const WebPath web(folder.path().string());
  const std::vector<std::string> records{"foo", "f"};
  const std::vector<std::filesystem::path> sources{folder / "a<\"b", folder.path() / "b/"};
  const std::string page = replay_page(records, sources);
  std::vector<nlohmann::json> told;
  for (std::size_t at = 0; (at = page.find("data-source=\"", at)) != std::string::npos;) {
    at += 13;
    told.push_back(nlohmann::json::parse(
        base::rpc::from_base64(std::string_view(page).substr(at, page.find('"', at) - at))));
  }
  ASSERT_EQ(told.size(), 2U);
  EXPECT_EQ(told[0],
            (nlohmann::json{{"path", (folder / "a<\"b")}, {"settings", nlohmann::json::object()}}));
  EXPECT_EQ(told[1]["settings"], (nlohmann::json{{"hilsim.plugins[wind].plugin", "wind"},
                                                 {"hilsim.plugins[wind].mean_m_s", "9"}}));
}

TEST(ReplayPage, ThatWasNotBuiltHasTheCauseThatTheBuildLeft) {
  const cas::test::TemporaryFolder folder;
  EXPECT_EQ(built_without_page(folder.path()), "CAS was built without the page (docs/use/web.md)");
  base::write_file(folder.path() / "left_out.txt", "npm cannot install: no network\n");
  EXPECT_EQ(built_without_page(folder.path()),
            "CAS was built without the page: npm cannot install: no network (docs/use/web.md)");
}

TEST(ReplayPage, OfAnotherMakeIsRefused) {
  const cas::test::TemporaryFolder folder;
  base::write_file(folder.path() / "index.html", "-");
  base::write_file(folder.path() / "replay.html", "<body></body>");
  const WebPath path(folder.path().string());
  const std::string record = "foo";
  EXPECT_THROW(replay_page({&record, 1}), base::ConfigError);
}

}  // namespace
}  // namespace cas::hils
