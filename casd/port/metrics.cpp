// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/metrics.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/rate_policy.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/message.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <chrono>
#include <cstdio>
#include <optional>
#include <set>
#include <string_view>
#include <utility>

#include "base/error.hpp"
#include "base/rpc/listener.hpp"
#include "casd/queue/tx_queue.hpp"
#include "casd/routing/router.hpp"

namespace cas::casd {
namespace {

/// A label's value: names may hold anything.
std::string label_value(std::string_view value) {
  std::string text = "\"";
  for (const char c : value) {
    if (c == '\n') {
      text += "\\n";
      continue;
    }
    if (c == '"' || c == '\\') text += '\\';
    text += c;
  }
  return text + '"';
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

/// Collects the samples of one metric below its header.
class Metric {
 public:
  Metric(std::string& out, std::string name, std::string_view type, std::string_view help)
      : out_(out), name_(std::move(name)) {
    out_ += "# HELP " + name_ + " " + std::string(help) + "\n";
    out_ += "# TYPE " + name_ + " " + std::string(type) + "\n";
  }
  void add(const std::string& labels, std::uint64_t value) { add(labels, std::to_string(value)); }
  void add(const std::string& labels, double value) { add(labels, number(value)); }

 private:
  void add(const std::string& labels, const std::string& value) {
    out_ += name_ + (labels.empty() ? "" : "{" + labels + "}") + " " + value + "\n";
  }
  std::string& out_;
  const std::string name_;
};

std::string link_label(const LinkStatus& link) { return "link=" + label_value(link.name); }

using Count = std::uint64_t (*)(const LinkStatus&);

struct LinkCounter {
  const char* name;
  const char* help;
  Count count;
};

constexpr LinkCounter kCounters[] = {
    {"casd_link_reconnects_total", "How often the link came back.",
     [](const LinkStatus& link) { return link.reconnects; }},
    {"casd_link_uncounted_total", "Packets that casd_messages_total had no room for.",
     [](const LinkStatus& link) { return link.uncounted; }},
    {"casd_link_rx_packets_total", "Packets received.",
     [](const LinkStatus& link) { return link.rx.packets; }},
    {"casd_link_rx_bytes_total", "Bytes received.",
     [](const LinkStatus& link) { return link.rx.bytes; }},
    {"casd_link_rx_crc_errors_total", "Packets with a wrong checksum.",
     [](const LinkStatus& link) { return link.rx.crc_errors; }},
    {"casd_link_rx_lost_total", "Gaps in the sequence numbers of senders.",
     [](const LinkStatus& link) { return link.rx.lost; }},
    {"casd_link_rx_not_accepted_total", "Packets that the link's accept leaves out.",
     [](const LinkStatus& link) { return link.rx.not_accepted; }},
    {"casd_link_tx_packets_total", "Packets sent.",
     [](const LinkStatus& link) { return link.tx.packets; }},
    {"casd_link_tx_bytes_total", "Bytes sent.",
     [](const LinkStatus& link) { return link.tx.bytes; }},
};

void add_states(std::string& out, const MetricsSource& source) {
  Metric up(out, "casd_link_up", "gauge", "1 while the link is up.");
  for (const LinkStatus& link : source.links) {
    up.add(link_label(link) + ",type=" + label_value(to_string(link.type)),
           std::uint64_t{link.state == LinkState::kUp ? 1U : 0U});
  }
  Metric queued(out, "casd_link_tx_queued", "gauge", "Packets that wait for the link.");
  for (const LinkStatus& link : source.links) queued.add(link_label(link), link.tx.queued);
  Metric high(out, "casd_link_tx_queue_high_water", "gauge", "Most packets that ever waited.");
  for (const LinkStatus& link : source.links) high.add(link_label(link), link.tx.queue_high_water);
}

void add_drops(std::string& out, const MetricsSource& source) {
  Metric received(out, "casd_link_rx_verdicts_total", "counter", "Where received packets ended.");
  for (const LinkStatus& link : source.links) {
    for (std::size_t i = 0; i < link.rx.decisions.size(); ++i) {
      const std::string_view decision = to_string(static_cast<Route::Decision>(i));
      received.add(link_label(link) + ",verdict=" + label_value(decision), link.rx.decisions[i]);
    }
  }
  Metric dropped(out, "casd_link_tx_dropped_total", "counter", "Packets dropped before sending.");
  for (const LinkStatus& link : source.links) {
    for (std::size_t i = 0; i < link.tx.dropped.size(); ++i) {
      const std::string_view cause = to_string(static_cast<DropCause>(i));
      dropped.add(link_label(link) + ",cause=" + label_value(cause), link.tx.dropped[i]);
    }
  }
}

void add_forwarding(std::string& out, const MetricsSource& source) {
  Metric time(out, "casd_link_forwarding_seconds", "gauge",
              "From read on another link to written on this one, since the start.");
  for (const LinkStatus& link : source.links) {
    const std::string label = link_label(link) + ",quantile=";
    time.add(label + "\"0.5\"", base::to_seconds(link.tx.forwarding_p50));
    time.add(label + "\"0.99\"", base::to_seconds(link.tx.forwarding_p99));
    time.add(label + "\"1\"", base::to_seconds(link.tx.forwarding_max));
  }
}

void add_messages(std::string& out, const MetricsSource& source) {
  Metric messages(out, "casd_messages_total", "counter", "Packets by link, message and sender.");
  for (const MessageStatus& message : source.messages) {
    messages.add("link=" + label_value(message.link) +
                     ",direction=" + label_value(message.direction) + ",message=" +
                     label_value(message.name.empty() ? std::to_string(message.id) : message.name) +
                     ",system=\"" + std::to_string(message.source.system) + "\",component=\"" +
                     std::to_string(message.source.component) + "\"",
                 message.count);
  }
}

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using base::rpc::Listener;
using Stream = beast::basic_stream<asio::generic::stream_protocol, asio::any_io_executor,
                                   beast::unlimited_rate_policy>;

constexpr std::size_t kMaxClients = 16;
constexpr std::size_t kMaxHeaderBytes = 8 * 1024;
constexpr auto kPatience = std::chrono::seconds(10);

/// One request, one answer, then the connection ends.
class HttpSession final : public std::enable_shared_from_this<HttpSession> {
 public:
  HttpSession(Listener::StreamSocket socket, const MetricsPort::Text& text,
              std::function<void(HttpSession*)> on_end)
      : stream_(std::move(socket)), text_(text), on_end_(std::move(on_end)) {
    parser_.header_limit(kMaxHeaderBytes);
    parser_.body_limit(0);
  }
  ~HttpSession() { on_end_(this); }

  void start() {
    stream_.expires_after(kPatience);
    http::async_read(stream_, buffer_, parser_,
                     [self = shared_from_this()](beast::error_code error, std::size_t) {
                       if (!error) self->answer();
                     });
  }
  void close() { stream_.cancel(); }

 private:
  void answer() {
    const auto& request = parser_.get();
    response_.version(request.version());
    response_.keep_alive(false);
    response_.set(http::field::content_type, "text/plain; version=0.0.4; charset=utf-8");
    if (request.method() != http::verb::get && request.method() != http::verb::head) {
      response_.result(http::status::method_not_allowed);
      response_.set(http::field::allow, "GET, HEAD");
    } else if (request.target() != "/metrics") {
      response_.result(http::status::not_found);
      response_.body() = "see /metrics\n";
    } else {
      response_.body() = text_();
    }
    response_.prepare_payload();
    if (request.method() == http::verb::head) response_.body().clear();
    http::async_write(stream_, response_,
                      [self = shared_from_this()](beast::error_code, std::size_t) {
                        beast::error_code ignored;
                        self->stream_.socket().shutdown(asio::socket_base::shutdown_send, ignored);
                      });
  }

  Stream stream_;
  const MetricsPort::Text& text_;
  std::function<void(HttpSession*)> on_end_;
  beast::flat_buffer buffer_{kMaxHeaderBytes};
  http::request_parser<http::empty_body> parser_;
  http::response<http::string_body> response_;
};

}  // namespace

std::string metrics_text(const MetricsSource& source) {
  std::string out;
  Metric(out, "casd_uptime_seconds", "gauge", "Since the start.").add("", source.uptime_s);
  Metric(out, "casd_command_clients", "gauge", "Clients of the command port.")
      .add("", std::uint64_t{source.clients});
  Metric refused(out, "casd_command_refused_total", "counter",
                 "Clients that the command port refused.");
  for (const auto& [reason, count] : source.refused) {
    refused.add("reason=" + label_value(reason), count);
  }
  add_states(out, source);
  for (const LinkCounter& counter : kCounters) {
    Metric metric(out, counter.name, "counter", counter.help);
    for (const LinkStatus& link : source.links) metric.add(link_label(link), counter.count(link));
  }
  add_drops(out, source);
  add_forwarding(out, source);
  add_messages(out, source);
  return out;
}

struct MetricsPort::Impl : std::enable_shared_from_this<MetricsPort::Impl> {
  Impl(asio::io_context& context, Text body) : io(context), text(std::move(body)) {}

  void on_client(Listener::StreamSocket socket) {
    if (sessions.size() >= kMaxClients) return;  // closes it
    const auto end = [weak = weak_from_this()](HttpSession* session) {
      if (const auto self = weak.lock()) self->sessions.erase(session);
    };
    const auto session = std::make_shared<HttpSession>(std::move(socket), text, end);
    sessions.insert(session.get());
    session->start();
  }

  asio::io_context& io;
  Text text;
  std::shared_ptr<Listener> listener;
  std::set<HttpSession*> sessions;
};

MetricsPort::MetricsPort(asio::io_context& io, Text text)
    : impl_(std::make_shared<Impl>(io, std::move(text))) {}

MetricsPort::~MetricsPort() { close(); }

std::uint16_t MetricsPort::listen(const std::string& address, std::uint16_t port) {
  base::rpc::ListeningSocket socket = base::rpc::open_tcp(address, port);
  const std::uint16_t bound = socket.port;
  impl_->listener = std::make_shared<Listener>(
      impl_->io, std::move(socket),
      [this](Listener::StreamSocket client) { impl_->on_client(std::move(client)); });
  impl_->listener->start();
  return bound;
}

void MetricsPort::close() {
  if (impl_->listener) impl_->listener->close();
  for (HttpSession* session : impl_->sessions) session->close();
}

}  // namespace cas::casd
