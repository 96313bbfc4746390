// SPDX-License-Identifier: BSD-3-Clause
#include <utility>  // Boost 1.74 counts on it under GCC 12

#include "web/server/web_server.hpp"

#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/serializer.hpp>
#include <boost/beast/http/span_body.hpp>
#include <boost/beast/http/write.hpp>
#include <boost/beast/websocket/rfc6455.hpp>
#include <chrono>
#include <optional>
#include <string_view>

#include "base/rpc/listener.hpp"
#include "web/server/access_rules.hpp"
#include "web/server/page_hub.hpp"
#include "web/server/page_socket.hpp"
#include "web/server/stranger_places.hpp"

namespace cas::web {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = boost::beast::http;
using base::rpc::Listener;
using http::field;
using http::status;

constexpr std::size_t kMaxStrangers = 64;
// And as many at once: who waits behind a full backlog (4096) is let in after half a second, before
// its patience ends; a place lasts 8 ms all the same, time for a request that follows its SYN.
constexpr double kMaxConnections_s = 8000;
constexpr std::size_t kMaxHeaderBytes = 8 * 1024;
constexpr auto kPatience = std::chrono::seconds(10);  // for a request, and each part of its answer
constexpr std::string_view kMesh = "/mesh/";
constexpr std::size_t kHashDigits = 64;

/// The page may load its own files and speak to us; nothing else, and no site may frame it.
constexpr const char* kContentPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; "
    "font-src 'none'; connect-src 'self'; worker-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'";

std::string_view view(beast::string_view text) { return {text.data(), text.size()}; }

using Bytes = PageHub::Bytes;
using Body = http::span_body<const char>;

/// An answer on its way.
struct Answer {
  Answer(http::response<Body> head, Bytes bytes)
      : response(std::move(head)), body(std::move(bytes)) {}

  http::response<Body> response;
  Bytes body;
  http::response_serializer<Body> serializer{response};
};

}  // namespace

struct WebServer::Impl {
  PageHub& hub;
  const PageFiles& files;
  PageAccess access;
  asio::io_context& io;
  std::optional<AccessRules> rules{};
  std::shared_ptr<Listener> listener{};
  StrangerPlaces places{kMaxStrangers};
};

namespace {

/// One connection: requests one after the other, until it becomes a WebSocket or is silent.
template <class Shared>
class HttpSession final : public std::enable_shared_from_this<HttpSession<Shared>> {
 public:
  HttpSession(Listener::StreamSocket socket, Shared& server)
      : stream_(std::move(socket)), server_(server) {}

  void start() {
    place_ = server_.places.take([weak = this->weak_from_this()] {
      if (const auto self = weak.lock()) self->stream_.close();
    });
    read_request();
  }

 private:
  void read_request() {
    place_->spoke = false;
    parser_.emplace();
    parser_->header_limit(kMaxHeaderBytes);
    parser_->body_limit(0);
    stream_.expires_after(kPatience);
    http::async_read(
        stream_, buffer_, *parser_,
        [self = this->shared_from_this()](beast::error_code error, std::size_t) {
          if (error == http::error::header_limit) {
            return self->refuse(status::request_header_fields_too_large, "the header is too long");
          }
          if (error == http::error::body_limit) {
            return self->refuse(status::payload_too_large, "a request has no body");
          }
          if (error == http::error::end_of_stream) return self->end();
          if (error.category() == http::make_error_code(http::error::bad_method).category()) {
            return self->refuse(status::bad_request, "this is no HTTP request");
          }
          if (!error) self->answer();
        });
  }

  const Request& request() const { return parser_->get(); }

  void answer() {
    place_->spoke = true;
    if (request().count(field::host) != 1 ||
        !server_.rules->allows_host(view(request()[field::host]))) {
      return refuse(
          status::misdirected_request,
          "this Host is not served: open the address that casweb printed, or give --host");
    }
    const std::string_view target = view(request().target());
    if (target == "/rpc") return upgrade();
    if (request().method() != http::verb::get && request().method() != http::verb::head) {
      return refuse(status::method_not_allowed, "GET and HEAD only");
    }
    if (target.starts_with(kMesh)) return send_mesh(std::string(target.substr(kMesh.size())));
    if (const PageFile* file = server_.files.find(target)) return send_file(*file);
    refuse(status::not_found, "there is no such file");
  }

  void upgrade() {
    if (!beast::websocket::is_upgrade(request())) {
      return refuse(status::upgrade_required, "/rpc is a WebSocket");
    }
    if (!server_.rules->allows_origin(view(request()[field::origin]),
                                      view(request()[field::host]))) {
      return refuse(status::forbidden, "this Origin is not the page of casweb");
    }
    if (!server_.hub.has_place()) {
      return refuse(status::service_unavailable, "16 pages are open: close one");
    }
    serve_page(std::move(stream_), request(), server_.hub, server_.access, std::move(place_));
  }

  void send_file(const PageFile& file) {
    const bool zipped =
        !file.gzip.empty() &&
        view(request()[field::accept_encoding]).find("gzip") != std::string_view::npos;
    http::response<Body> response{status::ok, request().version()};
    response.set(field::content_type, file.type);
    if (!file.gzip.empty()) response.set(field::vary, "Accept-Encoding");
    if (zipped) response.set(field::content_encoding, "gzip");
    const std::string& body = zipped ? file.gzip : file.body;
    send(std::move(response), Bytes(Bytes(), &body), file.immutable);  // the file outlives us
  }

  void send_mesh(const std::string& hash) {
    const bool is_hash = hash.size() == kHashDigits &&
                         hash.find_first_not_of("0123456789abcdef") == std::string::npos;
    if (!is_hash) return refuse(status::bad_request, "/mesh/ and 64 hexadecimal digits");
    stream_.expires_never();  // hilsim answers or is gone
    server_.hub.fetch_mesh(hash, [self = this->shared_from_this()](const Bytes& bytes) {
      if (!bytes) {
        return self->refuse(status::not_found, "hilsim has no such mesh of 64 MiB at most");
      }
      http::response<Body> response{status::ok, self->request().version()};
      response.set(field::content_type, "application/octet-stream");
      self->send(std::move(response), bytes, true);
    });
  }

  void refuse(status why, const std::string& sentence) {
    http::response<Body> response{why, request().version()};
    response.set(field::content_type, "text/plain; charset=utf-8");
    if (why == status::method_not_allowed) response.set(field::allow, "GET, HEAD");
    is_last_ = is_last_ || why != status::not_found;
    send(std::move(response), std::make_shared<const std::string>(sentence + "\n"), false);
  }

  void send(http::response<Body> response, Bytes body, bool immutable) {
    is_last_ = is_last_ || !request().keep_alive();
    response.keep_alive(!is_last_);
    response.set(field::cache_control,
                 immutable ? "public, max-age=31536000, immutable" : "no-store");
    response.set("Content-Security-Policy", kContentPolicy);
    response.set("X-Content-Type-Options", "nosniff");
    response.set("Referrer-Policy", "no-referrer");
    response.set("Cross-Origin-Opener-Policy", "same-origin");
    response.set("Cross-Origin-Resource-Policy", "same-origin");
    response.body() = {body->data(), body->size()};
    response.prepare_payload();
    if (request().method() == http::verb::head) response.body() = {};
    write_part(std::make_shared<Answer>(std::move(response), std::move(body)));
  }

  /// A slow line may take long, as long as it takes something.
  void write_part(const std::shared_ptr<Answer>& answer) {
    stream_.expires_after(kPatience);
    http::async_write_some(
        stream_, answer->serializer,
        [self = this->shared_from_this(), answer](beast::error_code error, std::size_t) {
          if (error) return self->end();
          if (!answer->serializer.is_done()) return self->write_part(answer);
          if (self->is_last_) return self->end();
          self->read_request();
        });
  }

  void end() {
    beast::error_code ignored;
    stream_.socket().shutdown(asio::socket_base::shutdown_send, ignored);
  }

  Stream stream_;
  Shared& server_;
  std::shared_ptr<StrangerPlaces::Place> place_;
  beast::flat_buffer buffer_{2 * kMaxHeaderBytes};
  std::optional<http::request_parser<http::empty_body>> parser_;
  bool is_last_ = false;
};

}  // namespace

WebServer::WebServer(asio::io_context& io, PageHub& hub, const PageFiles& files, PageAccess access)
    : impl_(new Impl{hub, files, std::move(access), io}) {}

WebServer::~WebServer() = default;

std::uint16_t WebServer::listen(const std::string& address, std::uint16_t port,
                                const std::vector<std::string>& names) {
  base::rpc::ListeningSocket socket = base::rpc::open_tcp(address, port);
  const std::uint16_t bound = socket.port;
  impl_->rules.emplace(bound, names);
  impl_->listener = std::make_shared<Listener>(
      impl_->io, std::move(socket),
      [impl = impl_.get()](Listener::StreamSocket client) {
        std::make_shared<HttpSession<Impl>>(std::move(client), *impl)->start();
      },
      kMaxConnections_s);
  impl_->listener->start();
  return bound;
}

void WebServer::close() {
  if (impl_->listener) impl_->listener->close();
}

}  // namespace cas::web
