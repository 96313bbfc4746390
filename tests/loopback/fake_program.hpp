// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>

#include <atomic>
#include <cstring>
#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <utility>

#include "base/os/descriptor.hpp"

namespace cas::test {

/// Stand-in for casd, hilsim or hils on a Unix socket: a thread serves one client after the other,
/// and answers each call with the result of `answer`.
class FakeProgram {
 public:
  /// Value of "result".
  using Answer =
      std::function<nlohmann::json(const std::string& method, const nlohmann::json& params)>;

  FakeProgram(const std::filesystem::path& path, Answer answer)
      : listener_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)), answer_(std::move(answer)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
    EXPECT_EQ(::bind(listener_.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    EXPECT_EQ(::listen(listener_.get(), 4), 0);
    thread_ = std::thread([this] { serve(); });
  }
  ~FakeProgram() {
    ends_ = true;
    ::shutdown(listener_.get(), SHUT_RDWR);  // ends accept()
    if (const int client = client_; client >= 0) ::shutdown(client, SHUT_RDWR);
    thread_.join();
  }
  /// Sends a notification to the client that is there.
  void notify(const std::string& topic, const nlohmann::json& params) const {
    const std::string line =
        nlohmann::json{{"jsonrpc", "2.0"}, {"method", topic}, {"params", params}}.dump() + "\n";
    EXPECT_EQ(::send(client_, line.data(), line.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(line.size()));
  }
  FakeProgram(const FakeProgram&) = delete;
  FakeProgram& operator=(const FakeProgram&) = delete;

 private:
  void serve() {
    while (!ends_) {
      const base::Descriptor client(::accept(listener_.get(), nullptr, nullptr));
      if (!client) return;
      client_ = client.get();
      std::string line;
      char c = 0;
      while (!ends_ && ::recv(client.get(), &c, 1, 0) == 1) {
        if (c != '\n') {
          line += c;
        } else {
          answer_line(client.get(), std::exchange(line, {}));
        }
      }
      client_ = -1;
    }
  }

  void answer_line(int client, const std::string& line) {
    const auto call = nlohmann::json::parse(line);
    const std::string text =
        nlohmann::json{
            {"jsonrpc", "2.0"},
            {"id", call.at("id")},
            {"result", answer_(call.at("method"), call.value("params", nlohmann::json()))}}
            .dump() +
        "\n";
    for (std::size_t sent = 0; sent < text.size();) {
      const ssize_t size = ::send(client, text.data() + sent, text.size() - sent, MSG_NOSIGNAL);
      if (size <= 0) return;
      sent += static_cast<std::size_t>(size);
    }
  }

  base::Descriptor listener_;
  Answer answer_;
  std::atomic<int> client_{-1};
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace cas::test
