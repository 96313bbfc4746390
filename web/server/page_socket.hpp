// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/rate_policy.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <memory>

#include "web/server/page_client.hpp"
#include "web/server/stranger_places.hpp"

namespace cas::web {

using Stream =
    boost::beast::basic_stream<boost::asio::generic::stream_protocol, boost::asio::any_io_executor,
                               boost::beast::unlimited_rate_policy>;
using Request = boost::beast::http::request<boost::beast::http::empty_body>;

/// Answers an upgrade and serves the page over its WebSocket [RFC 6455] until either end closes:
/// frames in, frames out, bounds and deadlines. A page that does not read is closed, and delays no
/// other.
/// @param place  held until the page has proved that it knows the token
void serve_page(Stream stream, const Request& upgrade, PageHub& hub, const PageAccess& access,
                std::shared_ptr<StrangerPlaces::Place> place);

}  // namespace cas::web
