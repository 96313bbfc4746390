// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "tests/loopback/web_page.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {

/// casweb as a program, beside sockets of casd and hilsim that may come later.
class CaswebFixture {
 public:
  static constexpr const char* kToken = "a token of the tests";

  /// @param folder  where casd.sock and hilsim.sock are
  /// @param more  further flags @param page  folder of the page; empty: one of a single line
  explicit CaswebFixture(const std::filesystem::path& folder,
                         const std::vector<std::string>& more = {}, const std::string& page = {}) {
    folder_.write("page/index.html", "<!doctype html><title>the page</title>");
    const std::filesystem::path token = folder_.write("token", kToken);
    std::filesystem::permissions(token, std::filesystem::perms::owner_read);
    std::vector<std::string> command{cas::test::binary_dir() + "/bin/casweb",
                                     "--listen",
                                     "127.0.0.1:0",
                                     "--casd",
                                     (folder / "casd.sock").string(),
                                     "--hilsim",
                                     (folder / "hilsim.sock").string(),
                                     "--page",
                                     page.empty() ? (folder_ / "page").string() : page,
                                     "--token-file",
                                     token.string(),
                                     "--address-file",
                                     address_file().string()};
    command.insert(command.end(), more.begin(), more.end());
    casweb_ = std::make_unique<ChildProcess>(command);
    const auto url = casweb_->wait_ready();
    EXPECT_TRUE(url) << casweb_->output();
    if (url) port_ = static_cast<std::uint16_t>(std::stoi(url->substr(url->rfind(':') + 1)));
  }

  std::uint16_t port() const { return port_; }
  std::string host() const { return "127.0.0.1:" + std::to_string(port_); }
  std::filesystem::path address_file() const { return folder_ / "address"; }
  ChildProcess& program() { return *casweb_; }
  /// A page that has said hello.
  std::unique_ptr<WebPage> open_page() {
    auto page = std::make_unique<WebPage>(port_);
    EXPECT_EQ(page->refusal(), 0);
    EXPECT_TRUE(page->hello(kToken).contains("result"));
    return page;
  }

 private:
  TemporaryFolder folder_;
  std::unique_ptr<ChildProcess> casweb_;
  std::uint16_t port_ = 0;
};

}  // namespace cas::test
