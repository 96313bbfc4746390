// SPDX-License-Identifier: BSD-3-Clause
#include <utility>  // Boost 1.74 counts on it under GCC 12

#include "tests/loopback/web_page.hpp"

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/empty_body.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <stdexcept>

#include "base/rpc/token_proof.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
namespace websocket = boost::beast::websocket;
using nlohmann::json;
using tcp = asio::ip::tcp;

tcp::endpoint loopback(std::uint16_t port) { return {asio::ip::address_v4::loopback(), port}; }

/// Starts an operation with a handler and runs it to its end, or to the deadline.
template <class Start>
beast::error_code finish(asio::io_context& io, Start&& start) {
  const auto outcome = std::make_shared<beast::error_code>(asio::error::timed_out);
  start([outcome](beast::error_code error, auto...) { *outcome = error; });
  io.restart();
  io.run_for(kPatience);
  return *outcome;
}

}  // namespace

HttpAnswer http_request(std::uint16_t port, const std::string& method, const std::string& target,
                        const std::string& host) {
  asio::io_context io;
  tcp::socket socket(io);
  socket.connect(loopback(port));
  http::request<http::empty_body> request;
  request.version(11);
  request.method_string(method);
  request.target(target);
  if (!host.empty()) request.set(http::field::host, host);
  http::write(socket, request);
  beast::flat_buffer buffer;
  http::response<http::string_body> response;
  if (finish(io, [&](auto handler) { http::async_read(socket, buffer, response, handler); })) {
    return {};
  }
  HttpAnswer answer{.status = static_cast<int>(response.result_int()), .body = response.body()};
  for (const auto& field : response) {
    answer.headers[std::string(field.name_string())] = std::string(field.value());
  }
  return answer;
}

struct WebPage::Impl {
  asio::io_context io;
  websocket::stream<tcp::socket> socket{io};
  beast::flat_buffer buffer;
};

WebPage::WebPage(std::uint16_t port, const std::string& host, const std::string& origin)
    : impl_(std::make_unique<Impl>()), host_(host) {
  impl_->socket.next_layer().connect(loopback(port));
  impl_->socket.set_option(websocket::stream_base::decorator([&](websocket::request_type& request) {
    if (!origin.empty()) request.set(http::field::origin, origin);
  }));
  websocket::response_type response;
  const beast::error_code error = finish(impl_->io, [&](auto handler) {
    impl_->socket.async_handshake(response, host, "/rpc", handler);
  });
  if (error) refusal_ = static_cast<int>(response.result_int());
}

WebPage::WebPage(std::uint16_t port)
    : WebPage(port, "127.0.0.1:" + std::to_string(port),
              "http://127.0.0.1:" + std::to_string(port)) {}

WebPage::~WebPage() = default;

void WebPage::send(const std::string& text) {
  impl_->socket.text(true);
  beast::error_code ignored;  // a read tells
  impl_->socket.write(asio::buffer(text), ignored);
}

std::optional<json> WebPage::read() {
  beast::flat_buffer& buffer = impl_->buffer;
  buffer.clear();
  if (finish(impl_->io, [&](auto handler) { impl_->socket.async_read(buffer, handler); })) {
    return std::nullopt;
  }
  return json::parse(beast::buffers_to_string(buffer.data()));
}

std::optional<json> WebPage::wait_for(const std::function<bool(const json&)>& wanted) {
  for (auto frame = kept_.begin(); frame != kept_.end(); ++frame) {
    if (!wanted(*frame)) continue;
    json found = std::move(*frame);
    kept_.erase(frame);
    return found;
  }
  const base::RunTime deadline = base::steady_now() + kPatience;
  while (base::steady_now() < deadline) {
    std::optional<json> frame = read();
    if (!frame) return std::nullopt;
    if (wanted(*frame)) return frame;
    kept_.push_back(std::move(*frame));
  }
  return std::nullopt;
}

std::optional<json> WebPage::next(const std::string& method) {
  const auto frame = wait_for([&](const json& each) { return each.value("method", "") == method; });
  if (!frame) return std::nullopt;
  return frame->at("params");
}

json WebPage::call(const std::string& method, const json& params) {
  const int id = ++last_id_;
  send(json{{"jsonrpc", "2.0"}, {"id", id}, {"method", method}, {"params", params}}.dump());
  auto answer = wait_for([id](const json& each) { return each.value("id", json()) == id; });
  if (!answer) throw std::runtime_error("no answer to " + method);
  return std::move(*answer);
}

json WebPage::hello(const std::string& token) {
  const json answer = exchange_nonces();
  if (!answer.contains("result")) return answer;
  return call("hello", {{"protocol", 2}, {"proof", proof(token)}});
}

json WebPage::exchange_nonces() {
  own_nonce_ = base::rpc::make_nonce();
  json answer = call("hello", {{"protocol", 2}, {"nonce", own_nonce_}});
  if (answer.contains("result")) nonce_ = answer["result"].at("nonce").get<std::string>();
  return answer;
}

std::string WebPage::proof(const std::string& token, const std::string& place) const {
  return base::rpc::token_proof(token, base::rpc::Prover::kClient,
                                {place.empty() ? host_ : place, own_nonce_, nonce_});
}

void WebPage::ack(const std::string& topic, const json& params) {
  send(json{{"jsonrpc", "2.0"},
            {"method", "ack"},
            {"params", {{"topic", topic}, {"seq", params.at("seq")}}}}
           .dump());
}

std::optional<int> WebPage::wait_closed() {
  const base::RunTime deadline = base::steady_now() + kPatience;
  while (base::steady_now() < deadline && impl_->socket.is_open()) read();
  if (impl_->socket.is_open()) return std::nullopt;
  return impl_->socket.reason().code;
}

}  // namespace cas::test
