// SPDX-License-Identifier: BSD-3-Clause
#include "casd/station/param_exchange.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>

namespace cas::casd {
namespace {

using mavlink::common::MavParamType;

struct RoundTripCase {
  const char* name;
  ParamEncoding encoding;
  MavParamType type;
  double value;
};

class ParamRoundTrip : public testing::TestWithParam<RoundTripCase> {};

TEST_P(ParamRoundTrip, GivesTheNumberBack) {
  const RoundTripCase& test = GetParam();
  const auto wire = to_wire(test.encoding, test.type, test.value);
  ASSERT_TRUE(wire.has_value());
  EXPECT_EQ(from_wire(test.encoding, test.type, *wire), test.value);
}

INSTANTIATE_TEST_SUITE_P(
    Types, ParamRoundTrip,
    testing::Values(
        RoundTripCase{"Px4Int32", ParamEncoding::kBytewise, MavParamType::kInt32, -2147483648.0},
        RoundTripCase{"Px4Uint32", ParamEncoding::kBytewise, MavParamType::kUint32, 4294967295.0},
        RoundTripCase{"Px4Int8", ParamEncoding::kBytewise, MavParamType::kInt8, -1},
        RoundTripCase{"Px4Real", ParamEncoding::kBytewise, MavParamType::kReal32, 0.5},
        RoundTripCase{"ArduPilotInt16", ParamEncoding::kCast, MavParamType::kInt16, -32768},
        RoundTripCase{"ArduPilotInt32", ParamEncoding::kCast, MavParamType::kInt32, 65536}),
    [](const auto& test) { return test.param.name; });

TEST(ParamValue, IntegersTravelAsTheirBytes) {
  EXPECT_EQ(std::bit_cast<std::uint32_t>(
                *to_wire(ParamEncoding::kBytewise, MavParamType::kInt32, 12345678)),
            12345678U);
}

TEST(ParamValue, RefusesWhatATypeCannotHold) {
  EXPECT_FALSE(to_wire(ParamEncoding::kBytewise, MavParamType::kInt8, 128));
  EXPECT_FALSE(to_wire(ParamEncoding::kCast, MavParamType::kUint16, -1));
  EXPECT_FALSE(to_wire(ParamEncoding::kCast, MavParamType::kInt32, 1.5));
  EXPECT_FALSE(to_wire(ParamEncoding::kCast, MavParamType::kReal32, std::nan("")));
  EXPECT_FALSE(to_wire(ParamEncoding::kCast, MavParamType::kReal32, 1e39));
}

TEST(ParamValue, PrintsTheShortestTextThatAFloatReadsBackFrom) {
  EXPECT_EQ(number_text(static_cast<double>(0.15F)), "0.15");
  EXPECT_EQ(number_text(3), "3");
  EXPECT_EQ(number_text(-2147483648.0), "-2147483648");
}

TEST(ParamValue, ComparesRealsAsFloats) {
  EXPECT_TRUE(same_value(MavParamType::kReal32, 0.15, static_cast<double>(0.15F)));
  EXPECT_FALSE(same_value(MavParamType::kReal32, 0.15, 0.1500001));
  EXPECT_FALSE(same_value(MavParamType::kInt32, 16777217, 16777216));
}

}  // namespace
}  // namespace cas::casd
