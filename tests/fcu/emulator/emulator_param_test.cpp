// SPDX-License-Identifier: BSD-3-Clause
// The parameter protocol of fcu_emulator, over its pseudo-terminal.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

#include "mavlink/common/param_request_list.hpp"
#include "mavlink/common/param_request_read.hpp"
#include "mavlink/common/param_set.hpp"
#include "mavlink/common/param_value.hpp"
#include "mavlink/common/statustext.hpp"
#include "mavlink/common/system_time.hpp"
#include "mavlink_gen/runtime/message.hpp"
#include "tests/fcu/support/emulator_fixture.hpp"

namespace cas::fcu {
namespace {

using namespace mavlink::common;  // NOLINT
using test::EmulatorFixture;

float bytes_of(std::int32_t value) { return std::bit_cast<float>(value); }
std::int32_t integer_of(float field) { return std::bit_cast<std::int32_t>(field); }

class Parameters : public testing::Test {
 protected:
  explicit Parameters(const std::string& config = "") : emulator_(config) {}
  void request_list() {
    ParamRequestList m;
    m.target_system = 1;
    m.target_component = 1;
    emulator_.send(m);
  }
  std::optional<ParamValue> read(const std::string& name, std::int16_t index = -1) {
    ParamRequestRead m;
    m.target_system = 1;
    m.target_component = 1;
    m.param_index = index;
    mav::set_text(m.param_id, name);
    emulator_.send(m);
    return value();
  }
  std::optional<ParamValue> set(const std::string& name, float field,
                                MavParamType type = MavParamType::kReal32) {
    ParamSet m;
    m.target_system = 1;
    m.target_component = 1;
    mav::set_text(m.param_id, name);
    m.param_value = field;
    m.param_type = type;
    emulator_.send(m);
    return value();
  }
  std::optional<ParamValue> value() { return emulator_.next<ParamValue>(); }
  static std::string name(const ParamValue& m) { return std::string(mav::text(m.param_id)); }
  EmulatorFixture emulator_;
};

TEST_F(Parameters, ListIsWholeSortedAndBeginsWithTheHash) {
  request_list();
  const auto hash = value();
  ASSERT_TRUE(hash);
  EXPECT_EQ(name(*hash), "_HASH_CHECK");
  EXPECT_EQ(hash->param_index, 0xFFFF);
  EXPECT_EQ(hash->param_type, MavParamType::kUint32);
  std::map<std::uint16_t, std::string> names;
  for (int i = 0; i < hash->param_count; ++i) {
    const auto m = value();
    ASSERT_TRUE(m);
    EXPECT_EQ(m->param_count, hash->param_count);
    EXPECT_TRUE(m->param_type == MavParamType::kInt32 || m->param_type == MavParamType::kReal32);
    names[m->param_index] = name(*m);
  }
  EXPECT_EQ(names.size(), hash->param_count);
  EXPECT_EQ(names.rbegin()->first, hash->param_count - 1);
  for (const char* known : {"MC_ROLL_P", "MPC_XY_P", "CAL_GYRO0_ID", "SYS_HITL", "NAV_DLL_ACT"}) {
    EXPECT_TRUE(std::any_of(names.begin(), names.end(), [&](const auto& entry) {
      return entry.second == known;
    })) << known;
  }
}

/// On a slow line a list takes seconds: there is time to end it.
class ParametersOnASlowLine : public Parameters {
 protected:
  ParametersOnASlowLine() : Parameters("line: {preset: baud_115200}\n") {}
};

TEST_F(ParametersOnASlowLine, AStationWhoseCacheIsRightEndsTheList) {
  request_list();
  const auto hash = value();
  ASSERT_TRUE(hash);
  ParamSet known;
  known.target_system = 1;
  known.target_component = 1;
  mav::set_text(known.param_id, "_HASH_CHECK");
  known.param_value = hash->param_value;
  known.param_type = MavParamType::kUint32;
  emulator_.send(known);
  EXPECT_LT(emulator_.until_ping<ParamValue>().size(), hash->param_count);
  // For the time of several values, none comes.
  const auto system_time = static_cast<float>(SystemTime::kId);
  emulator_.send(emulator_.command(MavCmd::kSetMessageInterval, {system_time, 300'000}));
  EXPECT_TRUE(emulator_.next<SystemTime>());
  int values = 0;
  EXPECT_TRUE(emulator_.next<SystemTime>({}, [&](const mav::PacketView& packet) {
    values += packet.message_id == ParamValue::kId ? 1 : 0;
  }));
  EXPECT_EQ(values, 0);
}

TEST_F(Parameters, HashIsTheCrcOverNamesAndValues) {
  const auto hash_of = [&] {
    return std::bit_cast<std::uint32_t>(read("_HASH_CHECK")->param_value);
  };
  const std::uint32_t before = hash_of();
  request_list();
  const auto count = value()->param_count;
  std::uint32_t crc = 0;
  const auto add = [&crc](std::uint8_t byte) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? crc >> 1U ^ 0xEDB88320U : crc >> 1U;
  };
  for (int i = 0; i < count; ++i) {
    const auto m = value();
    for (const char c : name(*m)) add(static_cast<std::uint8_t>(c));
    const auto bits = std::bit_cast<std::uint32_t>(m->param_value);
    for (unsigned shift = 0; shift < 32; shift += 8) add(static_cast<std::uint8_t>(bits >> shift));
  }
  EXPECT_EQ(before, crc);
  set("MC_YAW_P", 3.25F);
  EXPECT_NE(hash_of(), before);
}

TEST_F(Parameters, AreReadByNameAndByIndex) {
  const auto by_name = read("MPC_XY_P");
  ASSERT_TRUE(by_name);
  EXPECT_EQ(name(*by_name), "MPC_XY_P");
  const auto by_index = read("", static_cast<std::int16_t>(by_name->param_index));
  ASSERT_TRUE(by_index);
  EXPECT_EQ(name(*by_index), "MPC_XY_P");
  EXPECT_EQ(by_index->param_value, by_name->param_value);
}

TEST_F(Parameters, ANameOfSixteenCharactersHasNoNul) {
  const auto m = read("MPC_XY_VEL_P_ACC");
  ASSERT_TRUE(m);
  EXPECT_EQ(name(*m), "MPC_XY_VEL_P_ACC");
  EXPECT_NE(m->param_id.back(), '\0');
}

TEST_F(Parameters, IntegersTravelAsTheirBytes) {
  EXPECT_EQ(integer_of(read("CAL_GYRO0_ID")->param_value), 1310988);
  const auto m = set("NAV_DLL_ACT", bytes_of(3), MavParamType::kInt32);
  ASSERT_TRUE(m);
  EXPECT_EQ(m->param_type, MavParamType::kInt32);
  EXPECT_EQ(integer_of(m->param_value), 3);
}

TEST_F(Parameters, ARefusalAnswersWithTheValueInForceAndSaysWhy) {
  const float before = read("MC_ROLL_P")->param_value;
  const auto expect_refused = [&](float field, MavParamType type, const char* reason) {
    const auto answer = set("MC_ROLL_P", field, type);
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->param_value, before) << reason;
    const auto text = emulator_.next<Statustext>();
    ASSERT_TRUE(text);
    EXPECT_NE(std::string_view(mav::text(text->text)).find(reason), std::string_view::npos)
        << mav::text(text->text);
  };
  expect_refused(1e6F, MavParamType::kReal32, "out of range");
  expect_refused(NAN, MavParamType::kReal32, "out of range");
  expect_refused(5.0F, MavParamType::kInt32, "Wrong type");
}

TEST_F(Parameters, UnknownNamesAndIndicesAreNotAnswered) {
  ParamRequestRead m;
  m.target_system = 1;
  m.target_component = 1;
  m.param_index = -1;
  mav::set_text(m.param_id, "MC_ROLL_I");  // PX4's roll loop is P only
  emulator_.send(m);
  m.param_index = 30'000;
  emulator_.send(m);
  EXPECT_TRUE(emulator_.until_ping<ParamValue>().empty());
  ParamSet set;
  set.target_system = 1;
  set.target_component = 1;
  mav::set_text(set.param_id, "MC_ROLL_I");
  set.param_type = MavParamType::kReal32;
  emulator_.send(set);
  const auto text = emulator_.next<Statustext>();
  ASSERT_TRUE(text);
  EXPECT_EQ(mav::text(text->text), "No parameter MC_ROLL_I");
}

TEST_F(Parameters, AreSavedAndReadBackAtStart) {
  ASSERT_EQ(set("MC_ROLL_P", 6.25F)->param_value, 6.25F);
  ASSERT_EQ(integer_of(set("NAV_DLL_ACT", bytes_of(2), MavParamType::kInt32)->param_value), 2);
  ASSERT_TRUE(
      cas::test::wait_until([&] { return std::filesystem::exists(emulator_.params_file()); }));
  emulator_.restart();
  EXPECT_EQ(read("MC_ROLL_P")->param_value, 6.25F);
  EXPECT_EQ(integer_of(read("NAV_DLL_ACT")->param_value), 2);
}

TEST_F(Parameters, SurviveARebootByCommand) {
  ASSERT_EQ(set("MC_ROLL_P", 6.5F)->param_value, 6.5F);
  ASSERT_EQ(emulator_.result(MavCmd::kPreflightRebootShutdown, {1}), MavResult::kAccepted);
  EXPECT_EQ(read("MC_ROLL_P")->param_value, 6.5F);
}

TEST_F(Parameters, AreResetByPreflightStorage) {
  const float initial = read("MC_ROLL_P")->param_value;
  ASSERT_EQ(set("MC_ROLL_P", 5.5F)->param_value, 5.5F);
  ASSERT_EQ(emulator_.result(MavCmd::kPreflightStorage, {2}), MavResult::kAccepted);
  EXPECT_EQ(read("MC_ROLL_P")->param_value, initial);
}

}  // namespace
}  // namespace cas::fcu
