// SPDX-License-Identifier: BSD-3-Clause
// Errors of wrong files: each sentence names file, line and key path.
#include <gmock/gmock.h>

#include <Eigen/Core>
#include <sstream>

#include "base/config/config.hpp"
#include "base/config/config_origin.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::base {
namespace {

using Read = void (*)(const ConfigNode& node);
using testing::HasSubstr;

const Read kJustParse = [](const ConfigNode&) {};
template <class T>
constexpr Read kReadX = [](const ConfigNode& node) { node.require<T>("x"); };

TEST(ConfigErrors, NameThePlace) {
  struct ErrorCase {
    const char* name;
    const char* text;
    Read read;
    const char* message;
  };
  const ErrorCase rows[] = {
      {"DuplicateKey", "a: 1\nb: 2\na: 3\n", kJustParse, "t.yaml:3: a: repeats the key of line 1"},
      {"DuplicateKeyWithOtherQuotes", "a: 1\n\"a\": 3\n", kJustParse,
       "t.yaml:2: a: repeats the key of line 1"},
      {"DuplicateKeyInAList", "l:\n  - x: 1\n    x: 2\n", kJustParse,
       "t.yaml:3: l[0].x: repeats the key of line 2"},
      {"DuplicateKeyInAFlowMap", "a:\n  b: {c: 1, d: 2, c: 3}\n", kJustParse,
       "t.yaml:2: a.b.c: repeats the key of line 2"},
      {"KeyThatIsNoWord", "? [1, 2]\n: 3\n", kJustParse, "t.yaml:1: a key must be a word"},
      {"TwoDocuments", "a: 1\n---\nb: 2\n", kJustParse, "t.yaml:2: holds more than one document"},
      {"CommaAlone", ",", kJustParse,
       "t.yaml:1: is not YAML: it begins with a mark that belongs to no value"},
      {"CommaAfterADocument", "[a]\n,\n", kJustParse, "t.yaml:2: holds more than one document"},
      {"OpenList", "a: [1, 2\n", kJustParse,
       "t.yaml:2: is not YAML: end of sequence flow not found"},
      {"Tab", "a:\n\tb: 1\n", kJustParse,
       "t.yaml:2: is not YAML: a tab is in the indentation; YAML takes spaces alone"},
      {"OtherIndentation", "a:\n  b: 1\n c: 2\n", kJustParse,
       "t.yaml:3: is not YAML: end of map not found; perhaps indented "
       "differently from the line above"},
      {"ColonInAText", "a: one: two\n", kJustParse,
       "t.yaml:1: is not YAML: illegal map value; a text with ': ' in it needs quotes"},
      {"MissingKey", "a: {y: 1}\n",
       [](const ConfigNode& node) { node.at("a").require<double>("rate_hz"); },
       "t.yaml:1: a: key 'rate_hz' is missing"},
      {"MistypedMandatoryKey", "name: q\nrat_hz: 1\n",
       [](const ConfigNode& node) { node.require<double>("rate_hz"); },
       "t.yaml:1: key 'rate_hz' is missing; did you mean it by 'rat_hz' on line 2?"},
      {"MandatoryKeyWithoutItsUnit", "lat: 47\nlon_deg: 8\n",
       [](const ConfigNode& node) { node.require<double>("lat_deg"); },
       "t.yaml:1: key 'lat_deg' is missing; did you mean it by 'lat' on line 1?"},
      {"NumberWithTail", "x: 12abc", kReadX<double>,
       "t.yaml:1: x: '12abc' is not a number, or out of range (a number alone, without a unit)"},
      {"NumberWithUnit", "x: 5 m", kReadX<double>,
       "t.yaml:1: x: '5 m' is not a number, or out of range (a number alone, without a unit)"},
      {"NumberOfARange", "x: .nan", [](const ConfigNode& node) { node.require_in("x", 0, 20); },
       "t.yaml:1: x: '.nan' is not a number in [0, 20]"},
      {"DecimalCommaInAFlowMap", "a: {x: 6,07}",
       [](const ConfigNode& node) {
         node.at("a").require<double>("x");
         node.reject_unused();
       },
       "t.yaml:1: a.07: unknown key (decimals follow a point, not a comma)"},
      {"NumberTooLarge", "x: 1e400", kReadX<double>,
       "t.yaml:1: x: '1e400' is not a number, or out of range"},
      {"NotANumber", "x: nan", kReadX<double>,
       "t.yaml:1: x: 'nan' is not a number, or out of range"},
      {"Infinity", "x: -inf", kReadX<double>,
       "t.yaml:1: x: '-inf' is not a number, or out of range"},
      {"DecimalComma", "x: 0,5", kReadX<double>,
       "t.yaml:1: x: '0,5' is not a number, or out of range (decimals follow a point, "
       "not a comma)"},
      {"NumberInQuotes", "x: \"5\"", kReadX<double>,
       "t.yaml:1: x: is a text in quotes; expected a number"},
      {"MapForNumber", "x: {a: 1}", kReadX<double>, "t.yaml:1: x: expected a number"},
      {"NothingForNumber", "x:", kReadX<double>, "t.yaml:1: x: has no value; expected a number"},
      {"FractionForInteger", "x: 3.5", kReadX<int>, "t.yaml:1: x: '3.5' must be a whole number"},
      {"IntegerTooLarge", "x: 2147483648", kReadX<int>,
       "t.yaml:1: x: '2147483648' is not a whole number in range"},
      {"NegativeForUnsigned", "x: -1", kReadX<unsigned>,
       "t.yaml:1: x: '-1' is not a whole number, not negative in range"},
      {"WordForBool", "x: yes", kReadX<bool>, "t.yaml:1: x: 'yes' is neither true nor false"},
      {"ListForText", "x: [a]", kReadX<std::string>, "t.yaml:1: x: expected a text"},
      {"NothingForText", "x: ~", kReadX<std::string>, "t.yaml:1: x: has no value; expected a text"},
      {"NumberForList", "x: 1", kReadX<std::vector<double>>, "t.yaml:1: x: expected a list"},
      {"BadElement", "x:\n  - 1\n  - b\n", kReadX<std::vector<double>>,
       "t.yaml:3: x[1]: 'b' is not a number, or out of range"},
      {"ShortVector", "x: [1, 2]", kReadX<Eigen::Vector3d>,
       "t.yaml:1: x: has 2 numbers; expected 3"},
      {"NumberForVector", "x: 1", kReadX<Eigen::Vector4d>,
       "t.yaml:1: x: expected a list of 4 numbers"},
      {"KeyOfAScalar", "x: 1", [](const ConfigNode& node) { node.at("x").find("y"); },
       "t.yaml:1: x: expected a map with the key 'y'"},
      {"OutOfRange", "x: 1.5", [](const ConfigNode& node) { node.require_in("x", 0, 1); },
       "t.yaml:1: x: 1.5 must lie in [0, 1]"},
      {"NearestKeyIsSuggested", "rate_hz: 1\nnoize: 2\n",
       [](const ConfigNode& node) {
         node.require<double>("rate_hz");
         node.find("noise");
         node.reject_unused();
       },
       "t.yaml:2: noize: unknown key; did you mean 'noise'?"},
      {"SwappedLetters", "rtae_hz: 1\n",
       [](const ConfigNode& node) {
         node.find("rate_hz");
         node.reject_unused();
       },
       "t.yaml:1: rtae_hz: unknown key; did you mean 'rate_hz'?"},
      {"FarFromAll", "colour: red\n",
       [](const ConfigNode& node) {
         node.find("rate_hz");
         node.reject_unused();
       },
       "t.yaml:1: colour: unknown key"},
      {"DeepInAList", "links:\n  - name: a\n    devise: b\n",
       [](const ConfigNode& node) {
         for (const ConfigNode& link : node.at("links").items()) {
           link.require<std::string>("name");
           link.find("device");
         }
         node.reject_unused();
       },
       "t.yaml:3: links[0].devise: unknown key; did you mean 'device'?"}};
  for (const auto& c : rows) {
    SCOPED_TRACE(c.name);
    EXPECT_EQ(test::refusal([&c] { c.read(ConfigNode::parse(c.text, "t.yaml")); }), c.message);
  }
}

TEST(ConfigLimits, NestingEndsAt64Levels) {
  const std::string deep = std::string(80, '[') + std::string(80, ']');
  EXPECT_THAT(test::refusal([&] { ConfigNode::parse(deep, "t.yaml"); }), HasSubstr("64 levels"));
}

TEST(ConfigLimits, AnAnchorThatHoldsItselfIsRefused) {
  EXPECT_THAT(test::refusal([] { ConfigNode::parse("a: &x [*x]", "t.yaml"); }),
              HasSubstr("t.yaml:1:"));
}

TEST(ConfigLimits, AnchorsThatMultiplyAreRefused) {
  std::ostringstream text;
  text << "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 9; ++i) {
    text << "a" << i << ": &a" << i << " [";
    for (int j = 0; j < 10; ++j) text << (j == 0 ? "*a" : ", *a") << i - 1;
    text << "]\n";
  }
  EXPECT_THAT(test::refusal([&] { ConfigNode::parse(text.str()); }), HasSubstr("50000"));
}

std::string many_keys(int count) {
  std::string text;
  for (int i = 0; i < count; ++i) text += "k" + std::to_string(i) + ": 1\n";
  return text;
}

TEST(ConfigLimits, AFileOfManyKeysIsRefusedBeforeItIsKept) {
  EXPECT_THAT(test::refusal([] { ConfigNode::parse(many_keys(100'000), "t.yaml"); }),
              HasSubstr("over 50000 values"));
  EXPECT_EQ(ConfigNode::parse(many_keys(40'000)).entries().size(), 40'000U);
}

TEST(ConfigLimits, AFileAboveItsSizeIsRefused) {
  EXPECT_EQ(test::refusal([] { ConfigNode::parse(std::string(5U << 20U, ' '), "t.yaml"); }),
            "t.yaml: is larger than 4 MiB");
}

TEST(ConfigFiles, AMissingFileIsNamed) {
  EXPECT_EQ(test::refusal([] { ConfigNode::load("/nowhere/x.yaml"); }),
            "/nowhere/x.yaml: YAML file cannot be read");
}

TEST(ConfigFiles, AFolderIsNamed) {
  const test::TemporaryFolder folder;
  EXPECT_EQ(test::refusal([&] { ConfigNode::load(folder.path()); }),
            folder.path().string() + ": YAML file is a folder, not a file");
}

TEST(ConfigOrigin, AnErrorOfACopyNamesThePlaceItWasCopiedFrom) {
  const auto own = ConfigNode::parse("a: 1\nlist:\n  - {x: 1, y: 2}\n", "own.yaml");
  const auto copy = ConfigNode::parse(
      "schema: 1\nmine:\n  - {x: 1, y: 2, z: 3}\n" + origin_notes("mine", own.at("list")),
      "generated.yaml");
  const ConfigNode item = copy.at("mine").items()[0];
  EXPECT_EQ(test::refusal([&] { item.at("y").fail("is odd"); }), "own.yaml:3: list[0].y: is odd");
  EXPECT_EQ(test::refusal([&] { item.at("z").fail("is odd"); }), "own.yaml:3: list[0].z: is odd")
      << "a key that the copy alone has is named by what stands above it";
  EXPECT_EQ(test::refusal([&] { item.at("yy"); }), "own.yaml:3: list[0]: key 'yy' is missing");
  EXPECT_EQ(test::refusal([&] { copy.at("schema").fail("is odd"); }),
            "generated.yaml:1: schema: is odd");
}

TEST(ConfigOrigin, ACommentThatIsNoNoteSaysNothing) {
  for (const char* comment : {"#: a <- nowhere", "#: a <- f.yaml:x: b", "#: a", "#: <- f:1: b",
                              "#:", "#: a <- :1: b", "#: a <- : "}) {
    const auto node = ConfigNode::parse(std::string("a: 1\n") + comment + "\n", "t.yaml");
    EXPECT_EQ(test::refusal([&] { node.at("a").fail("is odd"); }), "t.yaml:1: a: is odd")
        << comment;
  }
}

}  // namespace
}  // namespace cas::base
