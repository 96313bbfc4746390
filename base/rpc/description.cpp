// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/description.hpp"

#include <cctype>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/error.hpp"

namespace cas::base::rpc {
namespace {

using OrderedJson = nlohmann::ordered_json;

constexpr const char* kOpenRpc = "1.2.6";

/// Methods that every server answers itself.
constexpr const char* kSessionMethods = R"json({
  "methods": {"summary": "Names everything that can be called.", "params": {}, "result": ["string"]},
  "rpc.discover": {"summary": "Describes every method: this document.", "params": {}, "result": "any"},
  "subscribe": {"summary": "From now on this client is sent the notifications of a topic.",
                "params": {"topic": "string"}, "result": "boolean"},
  "unsubscribe": {"summary": "Ends a subscription.", "params": {"topic": "string"}, "result": "boolean"},
  "introduce": {"summary": "Gives this client a name, which stands behind its address in audits and journals from now on.",
                "params": {"name": "string: 1 to 32 letters, digits, dots, hyphens and underscores"},
                "result": "string: address and name, the client of its calls"},
  "authorise": {"summary": "Lets a client in that knows the token: by the token, or by a nonce and then a proof.",
                "params": {"token?": "string", "nonce?": "string", "proof?": "string"},
                "result": "any: true, or the server's nonce and proof"}
})json";

/// "string: of the topology" into the word and the sentence, which may be empty.
std::pair<std::string, std::string> word_and_sentence(const std::string& text) {
  const auto colon = text.find(": ");
  if (colon == std::string::npos) return {text, ""};
  return {text.substr(0, colon), text.substr(colon + 2)};
}

Json word_schema(const std::string& word) {
  CAS_CHECK(!word.empty());
  if (word == "any") return Json::object();
  if (std::isupper(static_cast<unsigned char>(word.front())) != 0) {
    return {{"$ref", "#/components/schemas/" + word}};
  }
  return {{"type", word}};
}

Json text_schema(const std::string& text) {
  const auto [words, sentence] = word_and_sentence(text);
  std::vector<Json> choices;
  std::size_t begin = 0;
  for (auto bar = words.find('|'); bar != std::string::npos; bar = words.find('|', begin)) {
    choices.push_back(word_schema(words.substr(begin, bar - begin)));
    begin = bar + 1;
  }
  choices.push_back(word_schema(words.substr(begin)));
  Json schema = choices.size() == 1 ? choices.front() : Json{{"anyOf", choices}};
  if (!sentence.empty()) schema["description"] = sentence;
  return schema;
}

/// "baud?" into the key and whether it must be there.
std::pair<std::string, bool> key_and_need(const std::string& key) {
  if (!key.empty() && key.back() == '?') return {key.substr(0, key.size() - 1), false};
  return {key, true};
}

Json object_schema(const Json& shape) {
  Json schema{{"type", "object"}, {"additionalProperties", false}};
  for (const auto& [text, value] : shape.items()) {
    if (text == "*") {
      schema["additionalProperties"] = schema_of(value);
      continue;
    }
    const auto [key, needed] = key_and_need(text);
    schema["properties"][key] = schema_of(value);
    if (needed) schema["required"].push_back(key);
  }
  return schema;
}

Json method_entry(const std::string& name, const OrderedJson& text) {
  Json params = Json::array();
  for (const auto& [written, shape] : text.at("params").items()) {
    const auto [key, needed] = key_and_need(written);
    Json schema = schema_of(Json(shape));
    Json param{{"name", key}, {"required", needed}};
    if (const auto sentence = schema.find("description"); sentence != schema.end()) {
      param["summary"] = *sentence;
      schema.erase(sentence);
    }
    param["schema"] = std::move(schema);
    params.push_back(std::move(param));
  }
  return {{"name", name},
          {"summary", text.at("summary").get<std::string>()},
          {"paramStructure", "by-name"},
          {"params", std::move(params)},
          {"result", {{"name", "result"}, {"schema", schema_of(Json(text.at("result")))}}}};
}

}  // namespace

Json schema_of(const Json& shape) {
  if (shape.is_string()) return text_schema(shape.get<std::string>());
  if (shape.is_object()) return object_schema(shape);
  CAS_CHECK(shape.is_array() && shape.size() == 1);
  return {{"type", "array"}, {"items", schema_of(shape.front())}};
}

Description::Description(std::string_view text, std::string version)
    : text_(std::make_shared<const OrderedJson>(OrderedJson::parse(text))),
      version_(std::move(version)) {
  CAS_CHECK(text_->is_object() && text_->contains("methods"));
}

Json Description::document(const std::vector<std::string>& methods) const {
  const OrderedJson text = text_ ? *text_ : OrderedJson{{"methods", OrderedJson::object()}};
  const OrderedJson& own = text.at("methods");
  const OrderedJson session = OrderedJson::parse(kSessionMethods);
  Json document{{"openrpc", kOpenRpc},
                {"info", {{"title", text.value("title", std::string())}, {"version", version_}}},
                {"methods", Json::array()},
                {"x-topics", Json::object()}};
  for (const std::string& name : methods) {
    const OrderedJson& from = own.contains(name) ? own : session;
    document["methods"].push_back(
        from.contains(name)
            ? method_entry(name, from.at(name))
            : Json{{"name", name}, {"params", Json::array()}, {"x-undescribed", true}});
  }
  const OrderedJson shapes = text.value("shapes", OrderedJson::object());
  for (const auto& [name, shape] : shapes.items()) {
    document["components"]["schemas"][name] = schema_of(Json(shape));
  }
  const OrderedJson topics = text.value("topics", OrderedJson::object());
  for (const auto& [name, topic] : topics.items()) {
    document["x-topics"][name] = {{"summary", topic.at("summary").get<std::string>()},
                                  {"params", schema_of(Json(topic.at("params")))}};
  }
  return document;
}

}  // namespace cas::base::rpc
