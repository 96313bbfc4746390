// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/hand_fault.hpp"

#include <gtest/gtest.h>

#include <array>
#include <nlohmann/json.hpp>

#include "base/rpc/message.hpp"

namespace cas::hils {
namespace {

using nlohmann::json;

constexpr std::array<std::uint8_t, 2> kSystems{1, 7};

std::array<VehicleReport, 2> vehicles() {
  return {VehicleReport{.heard = true, .hil = true}, VehicleReport{.heard = true, .hil = true}};
}

int refusal(const json& params, const std::array<VehicleReport, 2>& vehicles) {
  try {
    vehicle_of_fault(params, kSystems, vehicles);
  } catch (const base::rpc::CallError& why) {
    return why.code();
  }
  return 0;
}

TEST(HandFault, NamesAVehicleByItsWholeSystemId) {
  EXPECT_EQ(vehicle_of_fault(json::object(), kSystems, vehicles()), 0U);
  EXPECT_EQ(vehicle_of_fault({{"vehicle", 7}}, kSystems, vehicles()), 1U);
  EXPECT_EQ(refusal({{"vehicle", 2}}, vehicles()), base::rpc::kNoSuchVehicle);
  for (const json& wrong : {json(257), json(263), json(0), json(-249), json(7.5), json("7")}) {
    EXPECT_EQ(refusal({{"vehicle", wrong}}, vehicles()), base::rpc::kInvalidParams) << wrong;
  }
}

TEST(HandFault, HitsNoneThatIsSilentOrNotInHil) {
  auto silent = vehicles();
  silent[1].heartbeat_age_s = 3.5;
  EXPECT_EQ(refusal({{"vehicle", 7}}, silent), base::rpc::kInterlock);
  EXPECT_EQ(refusal({{"vehicle", 1}}, silent), 0);
  auto flown = vehicles();
  flown[1].hil = false;
  EXPECT_EQ(refusal({{"vehicle", 7}}, flown), base::rpc::kInterlock);
}

}  // namespace
}  // namespace cas::hils
