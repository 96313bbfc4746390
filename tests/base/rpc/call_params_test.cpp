// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/call_params.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <ostream>
#include <string>

#include "tests/support/refusal.hpp"

namespace cas::base::rpc {
namespace {

TEST(CallParams, ReadsParametersByName) {
  CallParams params(Json{{"n", 3}, {"x", 0.5}, {"word", "a"}, {"on", true}, {"map", {{"k", 1}}}});
  EXPECT_EQ(params.integer("n", 1, 3), 3);
  EXPECT_EQ(params.number("x", 0, 1), 0.5);
  EXPECT_EQ(params.text("word"), "a");
  EXPECT_TRUE(params.flag("on"));
  EXPECT_EQ(params.object("map"), Json({{"k", 1}}));
  EXPECT_NO_THROW(params.finish());
}

TEST(CallParams, NullIsAbsent) {
  CallParams params(Json{{"n", nullptr}});
  EXPECT_FALSE(params.optional_integer("n", 0, 1));
  EXPECT_FALSE(params.flag("on"));
  EXPECT_TRUE(params.value("map").is_null());
  EXPECT_NO_THROW(params.finish());
  EXPECT_NO_THROW(CallParams(Json()).finish());
}

struct Misuse {
  Json params;
  std::function<void(CallParams&)> read;
  std::string sentence;
};

void PrintTo(const Misuse& misuse, std::ostream* out) { *out << misuse.params; }

class CallParamsRefuse : public testing::TestWithParam<Misuse> {};

TEST_P(CallParamsRefuse, SayingWhy) {
  EXPECT_EQ(cas::test::refusal<BadParams>([] {
              CallParams params(GetParam().params);
              GetParam().read(params);
              params.finish();
            }),
            GetParam().sentence);
}

INSTANTIATE_TEST_SUITE_P(
    Parameters, CallParamsRefuse,
    testing::Values(
        Misuse{Json::array({1}), [](CallParams&) {}, "parameters are given by name, in an object"},
        Misuse{{{"t", 1.5}},
               [](CallParams& p) { p.number("t", 0, 1); },
               "\"t\" must be a number from 0 to 1"},
        Misuse{{{"t", "1"}}, [](CallParams& p) { p.number("t", 0, 1); }, "\"t\" must be a number"},
        Misuse{Json::object(), [](CallParams& p) { p.number("t", 0, 1); },
               "\"t\" is missing: a number"},
        Misuse{{{"n", 1.5}},
               [](CallParams& p) { p.integer("n", 1, 9); },
               "\"n\" must be an integer from 1 to 9"},
        Misuse{{{"n", 0}},
               [](CallParams& p) { p.integer("n", 1, 9); },
               "\"n\" must be an integer from 1 to 9"},
        Misuse{{{"fault", 1}}, [](CallParams& p) { p.object("fault"); }, "\"fault\" is no object"},
        Misuse{Json::object(), [](CallParams& p) { p.object("fault"); },
               "\"fault\" is missing: an object"},
        Misuse{{{"on", 1}}, [](CallParams& p) { p.flag("on"); }, "\"on\" must be true or false"},
        Misuse{{{"name", 1}}, [](CallParams& p) { p.text("name"); }, "\"name\" must be a string"},
        Misuse{{{"altitud_m", 1}, {"vehicle", 2}},
               [](CallParams& p) {
                 p.optional_integer("vehicle", 1, 255);
                 p.number("altitude_m");
               },
               "\"altitude_m\" is missing: a number; \"altitud_m\" is no parameter of this method"},
        Misuse{{{"vehicl", 1}},
               [](CallParams& p) { p.optional_text("vehicle"); },
               "\"vehicl\" is no parameter of this method"}));

}  // namespace
}  // namespace cas::base::rpc
