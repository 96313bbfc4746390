// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/link_factory.hpp"

#include <utility>

#include "base/error.hpp"
#include "casd/transport/serial_link.hpp"
#include "casd/transport/tcp_link.hpp"
#include "casd/transport/tcp_server_link.hpp"
#include "casd/transport/tlog_link.hpp"
#include "casd/transport/udp_link.hpp"
#include "casd/transport/udp_server_link.hpp"

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
