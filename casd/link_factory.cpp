// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link_factory.hpp"

#include <utility>

#include "base/error.hpp"
#include "casd/serial_link.hpp"
#include "casd/tcp_link.hpp"
#include "casd/tcp_server_link.hpp"
#include "casd/tlog_link.hpp"
#include "casd/udp_link.hpp"
#include "casd/udp_server_link.hpp"

namespace cas::casd {

std::unique_ptr<Link> make_link(LinkContext context) {
  switch (context.config.type) {
    case LinkType::kUdp:
      if (context.config.remote.empty()) return std::make_unique<UdpServerLink>(std::move(context));
      return std::make_unique<UdpLink>(std::move(context));
    case LinkType::kUdpServer:
      return std::make_unique<UdpServerLink>(std::move(context));
    case LinkType::kSerial:
      return std::make_unique<SerialLink>(std::move(context));
    case LinkType::kTcp:
      return std::make_unique<TcpLink>(std::move(context));
    case LinkType::kTcpServer:
      return std::make_unique<TcpServerLink>(std::move(context));
    case LinkType::kTlog:
      return std::make_unique<TlogLink>(std::move(context));
  }
  CAS_CHECK(false);
  return nullptr;
}

}  // namespace cas::casd
