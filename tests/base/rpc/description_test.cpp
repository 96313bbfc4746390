// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/description.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/rpc/dispatcher.hpp"

namespace cas::base::rpc {
namespace {

constexpr const char* kText = R"({
  "title": "kettle",
  "shapes": {"Water": {"temperature_degc": "number", "boils?": "boolean"}},
  "methods": {"kettle.heat": {"summary": "Heats.",
                              "params": {"to_degc": "number: at most 100", "by_s?": "integer|null"},
                              "result": ["Water"]}},
  "topics": {"boiling": {"summary": "It boils.", "params": {"*": "integer"}}}
})";

TEST(Shape, BecomesAJsonSchema) {
  struct ShapeCase {
    const char* shape;
    const char* schema;
  };
  const ShapeCase rows[] = {
      {R"("number")", R"({"type":"number"})"},
      {R"("number: in m")", R"({"type":"number","description":"in m"})"},
      {R"("number|null")", R"({"anyOf":[{"type":"number"},{"type":"null"}]})"},
      {R"("any")", R"({})"},
      {R"("Water")", R"({"$ref":"#/components/schemas/Water"})"},
      {R"(["string"])", R"({"type":"array","items":{"type":"string"}})"},
      {R"({"*":"integer"})", R"({"type":"object","additionalProperties":{"type":"integer"}})"},
      {R"({"a":"string","b?":"string"})",
       R"({"type":"object","additionalProperties":false,"required":["a"],
                      "properties":{"a":{"type":"string"},"b":{"type":"string"}}})"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.shape);
    EXPECT_EQ(schema_of(Json::parse(row.shape)), Json::parse(row.schema));
  }
}

class SilentPeer final : public Peer {
 public:
  void deliver(std::string line) override { answer = Json::parse(line); }
  Json answer;
};

TEST(Discover, DescribesEachMethodThatCanBeCalled) {
  Dispatcher dispatcher;
  dispatcher.add_method("kettle.heat", [](const Json&, Reply) {});
  dispatcher.add_method("kettle.whistle", [](const Json&, Reply) {});
  dispatcher.describe({kText, "1.5"});
  const auto peer = std::make_shared<SilentPeer>();
  dispatcher.handle(R"({"jsonrpc":"2.0","id":1,"method":"rpc.discover"})", peer);

  const Json document = peer->answer.at("result");
  EXPECT_EQ(document.at("info"), (Json{{"title", "kettle"}, {"version", "1.5"}}));
  std::map<std::string, Json> methods;
  for (const Json& method : document.at("methods")) methods[method.at("name")] = method;
  for (const char* own :
       {"authorise", "introduce", "methods", "rpc.discover", "subscribe", "unsubscribe"}) {
    EXPECT_TRUE(methods.contains(own)) << own;
    EXPECT_FALSE(methods[own].contains("x-undescribed")) << own;
  }
  EXPECT_TRUE(methods.at("kettle.whistle").contains("x-undescribed"));
  const Json& params = methods.at("kettle.heat").at("params");
  EXPECT_EQ(params.at(0).at("name"), "to_degc");  // in the order of the text
  EXPECT_EQ(params.at(0).at("summary"), "at most 100");
  EXPECT_EQ(params.at(0).at("required"), true);
  EXPECT_EQ(params.at(1).at("required"), false);
  EXPECT_EQ(methods.at("kettle.heat").at("result").at("schema").at("items").at("$ref"),
            "#/components/schemas/Water");
  EXPECT_TRUE(document.at("components").at("schemas").contains("Water"));
  EXPECT_EQ(document.at("x-topics").at("boiling").at("summary"), "It boils.");
}

TEST(Discover, APortWithoutDescriptionNamesItsMethods) {
  const Json document = Description().document({"a.b"});
  EXPECT_EQ(document.at("methods").at(0).at("name"), "a.b");
}

}  // namespace
}  // namespace cas::base::rpc
