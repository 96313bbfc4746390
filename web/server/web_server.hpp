// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "web/server/page_client.hpp"
#include "web/server/page_files.hpp"

namespace cas::web {

class PageHub;

/// HTTP on one port: the page's files, meshes, and the upgrade of /rpc to a WebSocket.
class WebServer {
 public:
  /// All outlive it.
  WebServer(boost::asio::io_context& io, PageHub& hub, const PageFiles& files, PageAccess access);
  ~WebServer();
  WebServer(const WebServer&) = delete;
  WebServer& operator=(const WebServer&) = delete;

  /// @param names  further names in `Host`, see AccessRules @param port  0 takes a free one
  /// @return the bound port @throws base::ConfigError
  std::uint16_t listen(const std::string& address, std::uint16_t port,
                       const std::vector<std::string>& names);
  void close();

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace cas::web
