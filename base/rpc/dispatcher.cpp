// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/dispatcher.hpp"

#include <algorithm>
#include <cctype>
#include <exception>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/os/lack_of_memory.hpp"
#include "base/rpc/call_params.hpp"
#include "base/rpc/token.hpp"

namespace cas::base::rpc {
namespace {

constexpr int kMaxDepth = 64;                   // a deep text would overflow the stack when printed
constexpr std::size_t kMaxBatch = 256;          // requests in one line
constexpr std::size_t kMaxCalls = 256;          // under way for one client
constexpr std::size_t kMaxId = 1024;            // bytes, kept while the call is under way
constexpr std::size_t kErrorRoom = 128 * 1024;  // bytes kept free for the errors of a batch
constexpr std::size_t kJoints = 2;  // bytes of brackets and comma around an answer in a batch

/// Texts from the wire may hold any bytes; they must not make an answer fail.
std::string to_line(const Json& json) {
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

Json error_response(const Json& id, int code, const std::string& message, const Json& data) {
  Json error{{"code", code}, {"message", message}};
  if (!data.is_null()) error["data"] = data;
  return Json{{"jsonrpc", "2.0"}, {"id", id}, {"error", std::move(error)}};
}

bool too_deep(std::string_view text) {
  int depth = 0;
  bool in_string = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      if (++depth > kMaxDepth) return true;
    } else if (c == ']' || c == '}') {
      --depth;
    }
  }
  return false;
}

bool is_usable_id(const Json& id) {
  if (id.is_string()) return id.get_ref<const std::string&>().size() <= kMaxId;
  return !id.is_structured() && !id.is_boolean();
}

/// Why a request object is invalid; nullopt if it is valid.
std::optional<std::string> request_fault(const Json& request) {
  if (!request.is_object()) return "a request must be an object";
  const auto version = request.find("jsonrpc");
  if (version == request.end() || *version != "2.0") return "\"jsonrpc\" must be \"2.0\"";
  const auto method = request.find("method");
  if (method == request.end() || !method->is_string()) return "\"method\" must be a string";
  const auto params = request.find("params");
  if (params != request.end() && !params->is_structured() && !params->is_null()) {
    return "\"params\" must be an object or an array";
  }
  const auto id = request.find("id");
  if (id != request.end() && !is_usable_id(*id)) {
    return "\"id\" must be a string of at most 1024 bytes or a number";
  }
  return std::nullopt;
}

/// The id to answer a faulty request with: its own where it has a usable one.
Json id_of(const Json& request) {
  if (!request.is_object()) return nullptr;
  const auto id = request.find("id");
  return id == request.end() || !is_usable_id(*id) ? Json(nullptr) : *id;
}

std::string too_long(const Json& id, std::size_t room) {
  return to_line(error_response(id, kInternalError,
                                "the answer is larger than the " + std::to_string(room) +
                                    " bytes that may wait for this client: ask for less, or read",
                                nullptr));
}

bool is_program_name(std::string_view name) {
  constexpr std::size_t kLongest = 32;
  const auto fits = [](unsigned char c) {
    return c < 0x80 && (std::isalnum(c) != 0 || c == '.' || c == '-' || c == '_');
  };
  return !name.empty() && name.size() <= kLongest && std::ranges::all_of(name, fits);
}

/// Answers a line that is not JSON-RPC; no further line of the peer is read.
void refuse_line(Peer& peer, int code, const std::string& message) {
  peer.refusal = Refusal::kNotJsonRpc;
  peer.deliver(Dispatcher::error_line(code, message));
}

}  // namespace

// Whatever a client sends ends in an answer, never in an exception that ends the server.
std::optional<std::string> run_answered(const Reply& reply, const std::function<void()>& body) {
  const auto answer = [&reply](int code, const std::string& message, const Json& data = {}) {
    reply.error(code, message, data);
    return message;
  };
  try {
    body();
    return std::nullopt;
  } catch (const CallError& error) {
    return answer(error.code(), error.what(), Json::parse(error.data_json(), nullptr, false));
  } catch (const ConfigError& error) {
    return answer(kRefused, error.what());
  } catch (const Json::exception&) {  // params.at("x").get<T>() of a wrong type
    return answer(kInvalidParams, "a parameter is missing, or is of another type");
  } catch (const std::exception& error) {
    return answer(kInternalError, error.what());
  }
}

/// The answers of one batch, in the order of its requests; delivered when the last is in. Its
/// client owns it.
struct AnswerBatch {
  std::weak_ptr<Peer> peer;
  std::vector<std::string> answers;  ///< empty: to a notification, or not there yet
  std::size_t bytes = 0;
  std::size_t open = 0;

  void put(std::size_t slot, std::string answer, const Json& id) {
    const std::shared_ptr<Peer> target = peer.lock();
    if (!target) return;
    if (answer.size() + kErrorRoom > target->room()) answer = too_long(id, target->room());
    if (answer.size() + kJoints > target->room()) return target->deliver(std::move(answer));
    bytes += answer.size() + kJoints;
    target->held_bytes += answer.size() + kJoints;
    answers[slot] = std::move(answer);
    close_one();
  }

  void close_one() {
    if (--open > 0) return;
    const std::shared_ptr<Peer> target = peer.lock();
    if (!target) return;
    std::string line;
    for (const std::string& answer : answers) {
      if (!answer.empty()) line.append(line.empty() ? "[" : ",").append(answer);
    }
    target->held_bytes -= bytes;
    std::erase_if(target->batches, [this](const auto& each) { return each.get() == this; });
    if (!line.empty()) target->deliver(line + "]");
  }
};

/// One request in progress. Copies of its Reply keep it alive; when the last one goes unanswered,
/// the client gets an error.
class Dispatcher::Call {
 public:
  Call(const std::shared_ptr<Peer>& peer, const Json& request,
       const std::shared_ptr<AnswerBatch>& batch)
      : peer_(peer),
        batch_(batch),
        in_batch_(batch != nullptr),
        notification_(!request.contains("id")) {
    if (!notification_) id_ = request["id"];
    ++peer->calls;
    if (!batch) return;
    slot_ = batch->answers.size();
    batch->answers.emplace_back();
    ++batch->open;
  }
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;
  ~Call() {
    outlive_lack_of_memory(
        "call", [this] { fail(kInternalError, "the method ended without an answer", nullptr); });
  }

  void succeed(const Json& result) {
    if (!answered_) answer(notification_ ? "" : result_line(to_line(result)));
  }
  void succeed_with(const std::string& text) {
    if (!answered_) answer(notification_ ? "" : result_line(text));
  }
  void fail(int code, const std::string& message, const Json& data) {
    if (!answered_) answer(to_line(error_response(id_, code, message, data)));
  }

 private:
  std::string result_line(const std::string& text) const {
    return R"({"id":)" + to_line(id_) + R"(,"jsonrpc":"2.0","result":)" + text + "}";
  }

  /// Sends the answer. Callers check `answered_`, so that only the first one is sent.
  void answer(std::string line) {
    answered_ = true;
    const std::shared_ptr<Peer> peer = peer_.lock();
    if (!peer) return;
    --peer->calls;
    const auto hand_over = [&] {
      if (in_batch_) {
        if (const auto batch = batch_.lock()) answer_in(*batch, std::move(line));
      } else if (!notification_) {
        peer->deliver(line.size() < peer->room() ? std::move(line) : too_long(id_, peer->room()));
      }
    };
    // A client whose answer is lost must not wait for it.
    if (!outlive_lack_of_memory(peer->name, hand_over)) peer->on_refused();
    peer->on_call_ended();
  }

  void answer_in(AnswerBatch& batch, std::string line) {
    notification_ ? batch.close_one() : batch.put(slot_, std::move(line), id_);
  }

  std::weak_ptr<Peer> peer_;
  std::weak_ptr<AnswerBatch> batch_;
  bool in_batch_;
  std::size_t slot_ = 0;
  Json id_;
  bool notification_;
  bool answered_ = false;
};

Dispatcher::Dispatcher()
    : session_methods_{
          {"subscribe", &Dispatcher::subscribe}, {"unsubscribe", &Dispatcher::unsubscribe},
          {"introduce", &Dispatcher::introduce}, {"authorise", &Dispatcher::authorise},
          {"methods", &Dispatcher::methods},     {"rpc.discover", &Dispatcher::discover}} {}

void Dispatcher::add_method(const std::string& name, Method method, double weight) {
  CAS_CHECK(!session_methods_.contains(name));
  Weighed weighed{std::make_shared<const Method>(std::move(method)), weight};
  CAS_CHECK(methods_.emplace(name, std::move(weighed)).second);
  document_.clear();
}

void Dispatcher::describe(Description description) {
  description_ = std::move(description);
  document_.clear();
}

void Dispatcher::add_topic(const std::string& topic) { topics_.insert(topic); }

bool Dispatcher::handle(std::string_view line, const std::shared_ptr<Peer>& peer) {
  if (line.find_first_not_of(" \t\r\n") == std::string_view::npos) return false;
  const auto serve = [&] {
    if (before_calls_) before_calls_();
    handle_text(line, peer);
  };
  if (!outlive_lack_of_memory(peer->name, serve)) {
    // A request that has become a call has its own answer.
    refuse_line(*peer, kInternalError, "no memory for this line");
  }
  if (peer->refusal == Refusal::kNone) return true;
  peer->on_refused();
  return false;
}

void Dispatcher::handle_text(std::string_view line, const std::shared_ptr<Peer>& peer) {
  if (too_deep(line)) return refuse_line(*peer, kParseError, "nested over 64 levels deep");
  const Json json = Json::parse(line, nullptr, false);
  if (json.is_discarded()) return refuse_line(*peer, kParseError, "the line is no JSON");
  if (json.is_array()) return handle_batch(json, peer);
  handle_request(json, peer, nullptr);
}

void Dispatcher::handle_batch(const Json& requests, const std::shared_ptr<Peer>& peer) {
  if (requests.empty()) return refuse_line(*peer, kInvalidRequest, "the batch is empty");
  if (requests.size() > kMaxBatch) {
    return refuse_line(*peer, kInvalidRequest, "a batch holds at most 256 requests");
  }
  const auto batch = std::make_shared<AnswerBatch>();
  batch->peer = peer;
  peer->batches.push_back(batch);
  batch->open = 1;  // ours, so that the batch is not complete before its last request is in
  for (const Json& request : requests) handle_request(request, peer, batch);
  batch->close_one();
}

void Dispatcher::handle_request(const Json& request, const std::shared_ptr<Peer>& peer,
                                const std::shared_ptr<AnswerBatch>& batch) {
  if (const auto fault = request_fault(request)) {
    // A wrong token of the same batch stays the reason, so that no second one is tried.
    if (peer->refusal == Refusal::kNone) peer->refusal = Refusal::kNotJsonRpc;
    const Json stand_in{{"id", id_of(request)}};  // a faulty request is answered, id or not
    Call(peer, stand_in, batch).fail(kInvalidRequest, *fault, nullptr);
    return;
  }
  const auto call = std::make_shared<Call>(peer, request, batch);
  if (peer->calls > kMaxCalls) {
    return call->fail(kInternalError, "over 256 calls of this client are under way", nullptr);
  }
  const TextReply reply{{[call](const Json& result) { call->succeed(result); },
                         [call](int code, const std::string& text, const Json& data) {
                           call->fail(code, text, data);
                         },
                         peer->name},
                        [call](const std::string& json) { call->succeed_with(json); }};
  const auto params = request.find("params");
  invoke(request["method"].get<std::string>(), params == request.end() ? Json() : *params, peer,
         reply);
}

void Dispatcher::invoke(const std::string& method, const Json& params,
                        const std::shared_ptr<Peer>& peer, const TextReply& reply) {
  if (!peer->authorised && method != "authorise") {
    return reply.error(kNotAuthorised, "call authorise {\"token\": ...} first", nullptr);
  }
  run_answered(reply, [&] { call(method, params, *peer, reply); });
}

void Dispatcher::call(const std::string& method, const Json& params, Peer& peer,
                      const TextReply& reply) {
  if (const auto own = session_methods_.find(method); own != session_methods_.end()) {
    peer.weight = std::max(peer.weight, 1.0);
    return (this->*own->second)(params, peer, reply);
  }
  const auto found = methods_.find(method);
  if (found == methods_.end()) {
    peer.weight = std::max(peer.weight, 1.0);
    return reply.error(kMethodNotFound, "there is no method '" + method + "'", nullptr);
  }
  peer.weight = std::max(peer.weight, found->second.weight);
  const std::shared_ptr<const Method> function = found->second.method;
  (*function)(params, reply);
}

void Dispatcher::call(const std::string& method, const Json& params, const Reply& reply) const {
  const auto found = methods_.find(method);
  if (found == methods_.end()) {
    return reply.error(kMethodNotFound, "there is no method '" + method + "'", nullptr);
  }
  const std::shared_ptr<const Method> function = found->second.method;
  run_answered(reply, [&] { (*function)(params, reply); });
}

void Dispatcher::subscribe(const Json& params, Peer& peer, const TextReply& reply) {
  CallParams reader(params);
  const std::optional<std::string> topic = reader.optional_text("topic");
  reader.finish();
  if (!topic || !topics_.contains(*topic)) {
    return reply.error(kInvalidParams, "\"topic\" must name one of the topics in data",
                       Json(topics_));
  }
  peer.topics.insert(*topic);
  reply.result(true);
}

void Dispatcher::unsubscribe(const Json& params, Peer& peer, const TextReply& reply) {
  CallParams reader(params);
  const std::string topic = reader.text("topic");
  reader.finish();
  reply.result(peer.topics.erase(topic) > 0);
}

/// Answers with the whole name, by which an audit or a journal tells this client's calls.
void Dispatcher::introduce(const Json& params, Peer& peer, const TextReply& reply) {
  CallParams reader(params);
  const std::string program = reader.text("name");
  reader.finish();
  if (!is_program_name(program)) {
    return reply.error(kInvalidParams,
                       "\"name\" has 1 to 32 letters, digits, dots, hyphens and underscores",
                       nullptr);
  }
  if (!peer.program.empty() && peer.program != program) {
    return reply.error(kInvalidParams, "this client has the name " + peer.program + " already",
                       nullptr);
  }
  if (peer.program.empty()) peer.name += " (" + program + ")";
  peer.program = program;
  reply.result(peer.name);
}

std::vector<std::string> Dispatcher::method_names() const {
  std::vector<std::string> names;
  for (const auto& [name, method] : methods_) names.push_back(name);
  for (const auto& [name, method] : session_methods_) names.push_back(name);
  std::sort(names.begin(), names.end());
  return names;
}

/// Names of all methods.
void Dispatcher::methods(const Json& params, Peer&, const TextReply& reply) {
  CallParams(params).finish();
  reply.result(method_names());
}

/// All methods, with parameters and results: a long text, made once.
void Dispatcher::discover(const Json& params, Peer&, const TextReply& reply) {
  CallParams(params).finish();
  if (document_.empty()) document_ = to_line(description_.document(method_names()));
  reply.text(document_);
}

void Dispatcher::authorise(const Json& params, Peer& peer, const TextReply& reply) {
  CallParams reader(params);
  const std::optional<std::string> token = reader.optional_text("token");
  const std::optional<std::string> nonce = reader.optional_text("nonce");
  const std::optional<std::string> proof = reader.optional_text("proof");
  reader.finish();
  if (!token && !nonce && !proof) {
    return reply.error(kInvalidParams, "\"token\" must be a string, or \"nonce\", or \"proof\"",
                       nullptr);
  }
  // One token a connection: a batch must not try many.
  if (peer.refusal == Refusal::kWrongToken) {
    return reply.error(kNotAuthorised, "an earlier token was wrong", nullptr);
  }
  if (token_ && nonce) return exchange_nonces(*nonce, peer, reply);
  if (!token_ || (token ? same_token(*token_, *token) : proves_token(*proof, peer))) {
    peer.authorised = true;
    return reply.result(true);
  }
  peer.refusal = Refusal::kWrongToken;
  reply.error(kNotAuthorised,
              token ? "the token is wrong" : "the proof is wrong; a nonce comes first", nullptr);
}

/// The server proves itself first: a client tells a stranger nothing.
void Dispatcher::exchange_nonces(const std::string& nonce, Peer& peer, const TextReply& reply) {
  constexpr std::size_t kShortest = 16;
  constexpr std::size_t kLongest = 256;
  if (nonce.size() < kShortest || nonce.size() > kLongest) {
    return reply.error(kInvalidParams, "\"nonce\" must have 16 to 256 characters", nullptr);
  }
  peer.proof.client_nonce = nonce;
  peer.proof.server_nonce = make_nonce();
  reply.result({{"nonce", peer.proof.server_nonce},
                {"proof", token_proof(*token_, Prover::kServer, peer.proof)}});
}

bool Dispatcher::proves_token(const std::string& proof, const Peer& peer) const {
  if (peer.proof.server_nonce.empty()) return false;
  return same_token(token_proof(*token_, Prover::kClient, peer.proof), proof);
}

std::string Dispatcher::notification(const std::string& topic, const Json& params) {
  return to_line(Json{{"jsonrpc", "2.0"}, {"method", topic}, {"params", params}});
}

std::string Dispatcher::error_line(int code, const std::string& message) {
  return to_line(error_response(nullptr, code, message, nullptr));
}

}  // namespace cas::base::rpc
