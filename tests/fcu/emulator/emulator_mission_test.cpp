// SPDX-License-Identifier: BSD-3-Clause
// The mission protocol of fcu_emulator, over its pseudo-terminal.
#include <gtest/gtest.h>

#include "mavlink/common/mission_ack.hpp"
#include "mavlink/common/mission_clear_all.hpp"
#include "mavlink/common/mission_count.hpp"
#include "mavlink/common/mission_current.hpp"
#include "mavlink/common/mission_item_int.hpp"
#include "mavlink/common/mission_request.hpp"
#include "mavlink/common/mission_request_int.hpp"
#include "mavlink/common/mission_request_list.hpp"
#include "mavlink/common/mission_set_current.hpp"
#include "mavlink/common/statustext.hpp"
#include "mavlink_gen/runtime/message.hpp"
#include "tests/fcu/support/emulator_fixture.hpp"

namespace cas::fcu {
namespace {

using namespace mavlink::common;  // NOLINT
using test::EmulatorFixture;

class Mission : public testing::Test {
 protected:
  static MissionItemInt item(std::uint16_t seq, MavCmd command = MavCmd::kNavWaypoint) {
    MissionItemInt m;
    m.target_system = 1;
    m.target_component = 1;
    m.seq = seq;
    m.command = command;
    m.frame = MavFrame::kGlobalRelativeAltInt;
    m.autocontinue = 1;
    m.x = 473'977'420 + 100 * seq;
    m.y = 85'455'940;
    m.z = 3.5F;
    return m;
  }
  void count(std::uint16_t n, MavMissionType type = MavMissionType::kMission) {
    MissionCount m;
    m.target_system = 1;
    m.target_component = 1;
    m.count = n;
    m.mission_type = type;
    emulator_.send(m);
  }
  std::optional<std::uint16_t> requested() {
    const auto m = emulator_.next<MissionRequestInt>();
    return m ? std::optional(m->seq) : std::nullopt;
  }
  std::optional<MavMissionResult> ack() {
    const auto m = emulator_.next<MissionAck>();
    return m ? std::optional(m->type) : std::nullopt;
  }
  void upload(std::uint16_t n) {
    count(n);
    for (std::uint16_t seq = 0; seq < n; ++seq) {
      ASSERT_EQ(requested(), seq);
      emulator_.send(item(seq));
    }
    ASSERT_EQ(ack(), MavMissionResult::kAccepted);
  }
  std::optional<MissionCount> download_count(MavMissionType type = MavMissionType::kMission) {
    MissionRequestList m;
    m.target_system = 1;
    m.target_component = 1;
    m.mission_type = type;
    emulator_.send(m);
    return emulator_.next<MissionCount>();
  }
  template <class Request>
  std::optional<MissionItemInt> download(std::uint16_t seq) {
    Request m;
    m.target_system = 1;
    m.target_component = 1;
    m.seq = seq;
    emulator_.send(m);
    return emulator_.next<MissionItemInt>();
  }
  EmulatorFixture emulator_;
};

TEST_F(Mission, ComesBackAsItWasUploaded) {
  upload(5);
  const auto n = download_count();
  ASSERT_TRUE(n);
  EXPECT_EQ(n->count, 5);
  EXPECT_EQ(n->target_system, 255);
  for (std::uint16_t seq = 0; seq < 5; ++seq) {
    const auto m = seq % 2 == 0 ? download<MissionRequestInt>(seq) : download<MissionRequest>(seq);
    ASSERT_TRUE(m);
    EXPECT_EQ(m->seq, seq);
    EXPECT_EQ(m->x, item(seq).x);
    EXPECT_EQ(m->y, item(seq).y);
    EXPECT_EQ(m->z, 3.5F);
    EXPECT_EQ(m->command, MavCmd::kNavWaypoint);
    EXPECT_EQ(m->current, seq == 0 ? 1 : 0);
  }
}

TEST_F(Mission, ALostItemIsAskedForAgain) {
  count(2);
  ASSERT_EQ(requested(), 0);
  EXPECT_EQ(requested(), 0);  // nothing came: once more
  emulator_.send(item(0));
  ASSERT_EQ(requested(), 1);
  emulator_.send(item(0));  // an old answer
  emulator_.send(item(1));
  EXPECT_EQ(ack(), MavMissionResult::kAccepted);
}

TEST_F(Mission, AnItemOutOfOrderIsAskedForAgain) {
  count(3);
  ASSERT_EQ(requested(), 0);
  emulator_.send(item(2));
  ASSERT_EQ(requested(), 0);
  for (std::uint16_t seq = 0; seq < 3; ++seq) emulator_.send(item(seq));
  EXPECT_EQ(ack(), MavMissionResult::kAccepted);
}

TEST_F(Mission, ABadItemEndsTheUploadAndKeepsTheOldMission) {
  upload(2);
  count(1);
  ASSERT_EQ(requested(), 0);
  emulator_.send(item(0, MavCmd::kDoSetHome));
  EXPECT_EQ(ack(), MavMissionResult::kUnsupported);
  count(1);
  ASSERT_EQ(requested(), 0);
  MissionItemInt bad = item(0);
  bad.frame = MavFrame::kBodyNed;
  emulator_.send(bad);
  EXPECT_EQ(ack(), MavMissionResult::kUnsupportedFrame);
  EXPECT_EQ(download_count()->count, 2);
}

TEST_F(Mission, TooManyItemsFindNoSpace) {
  count(5000);
  EXPECT_EQ(ack(), MavMissionResult::kNoSpace);
}

TEST_F(Mission, AStrangersItemIsNotTaken) {
  count(1);
  ASSERT_EQ(requested(), 0);
  emulator_.send(item(0), 2, {77, 1});
  ASSERT_EQ(requested(), 0);
  emulator_.send(item(0));
  EXPECT_EQ(ack(), MavMissionResult::kAccepted);
}

TEST_F(Mission, AnotherStationIsDeniedUntilAnUploadHasEnded) {
  count(1);
  ASSERT_EQ(requested(), 0);
  MissionCount other;
  other.target_system = 1;
  other.target_component = 1;
  other.count = 3;
  emulator_.send(other, 2, {77, 1});
  const auto denial = emulator_.next<MissionAck>();
  ASSERT_TRUE(denial);
  EXPECT_EQ(denial->type, MavMissionResult::kDenied);
  EXPECT_EQ(denial->target_system, 77);
  emulator_.send(item(0));
  EXPECT_EQ(ack(), MavMissionResult::kAccepted);
  EXPECT_EQ(download_count()->count, 1);
  emulator_.send(other, 2, {77, 1});
  EXPECT_EQ(requested(), 0);
}

TEST_F(Mission, AStationThatVanishesKeepsOthersOutForSecondsOnly) {
  count(1);
  ASSERT_EQ(ack(), MavMissionResult::kOperationCancelled);  // ten requests later
  upload(2);
}

TEST_F(Mission, AStationMayCancelItsUpload) {
  count(2);
  ASSERT_EQ(requested(), 0);
  MissionAck cancel;
  cancel.target_system = 1;
  cancel.target_component = 1;
  cancel.type = MavMissionResult::kOperationCancelled;
  emulator_.send(cancel, 2, {77, 1});  // another's is not heeded
  emulator_.send(item(0));
  ASSERT_EQ(requested(), 1);
  emulator_.send(cancel);
  emulator_.send(item(1));
  EXPECT_EQ(download_count()->count, 0);
}

TEST_F(Mission, ADownloadIsOfTheMissionThatWasAskedFor) {
  upload(3);
  ASSERT_EQ(download_count()->count, 3);
  MissionCount other;
  other.target_system = 1;
  other.target_component = 1;
  other.count = 1;
  emulator_.send(other, 2, {77, 1});
  ASSERT_EQ(requested(), 0);
  MissionItemInt replacement = item(0);
  replacement.x = 1;
  emulator_.send(replacement, 2, {77, 1});
  ASSERT_EQ(ack(), MavMissionResult::kAccepted);
  for (std::uint16_t seq = 0; seq < 3; ++seq) {
    const auto m = download<MissionRequestInt>(seq);
    ASSERT_TRUE(m);
    EXPECT_EQ(m->x, item(seq).x);
  }
  MissionAck whole;  // ends the download
  whole.target_system = 1;
  whole.target_component = 1;
  emulator_.send(whole);
  EXPECT_EQ(download<MissionRequestInt>(0)->x, 1);
}

TEST_F(Mission, AnItemThatIsNotThereIsAnInvalidSequence) {
  upload(1);
  MissionRequestInt m;
  m.target_system = 1;
  m.target_component = 1;
  m.seq = 7;
  emulator_.send(m);
  EXPECT_EQ(ack(), MavMissionResult::kInvalidSequence);
}

TEST_F(Mission, IsCleared) {
  upload(3);
  MissionClearAll m;
  m.target_system = 1;
  m.target_component = 1;
  emulator_.send(m);
  EXPECT_EQ(ack(), MavMissionResult::kAccepted);
  EXPECT_EQ(download_count()->count, 0);
}

TEST_F(Mission, AnEmptyUploadClears) {
  upload(3);
  count(0);
  EXPECT_EQ(ack(), MavMissionResult::kAccepted);
  EXPECT_EQ(download_count()->count, 0);
}

TEST_F(Mission, CurrentItemIsSetAndTold) {
  upload(3);
  MissionSetCurrent m;
  m.target_system = 1;
  m.target_component = 1;
  m.seq = 2;
  emulator_.send(m);
  const auto current = emulator_.next<MissionCurrent>([](const auto& c) { return c.seq == 2; });
  ASSERT_TRUE(current);
  EXPECT_EQ(current->total, 3);
  m.seq = 9;
  emulator_.send(m);
  const auto text = emulator_.next<Statustext>();
  ASSERT_TRUE(text);
  EXPECT_EQ(mav::text(text->text), "No mission item 9");
}

/// No fence and no rally points: none to fetch, none taken, and that is said at once.
class MissionType : public Mission, public testing::WithParamInterface<MavMissionType> {};

TEST_P(MissionType, OtherThanAMissionIsEmptyAndRefused) {
  const auto none = download_count(GetParam());
  ASSERT_TRUE(none);
  EXPECT_EQ(none->count, 0);
  EXPECT_EQ(none->mission_type, GetParam());
  count(2, GetParam());
  const auto refusal = emulator_.next<MissionAck>();
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->type, MavMissionResult::kUnsupported);
  EXPECT_EQ(refusal->mission_type, GetParam());
  count(0, GetParam());
  EXPECT_EQ(ack(), MavMissionResult::kAccepted);
}

INSTANTIATE_TEST_SUITE_P(FenceAndRally, MissionType,
                         testing::Values(MavMissionType::kFence, MavMissionType::kRally),
                         [](const auto& test) {
                           return test.param == MavMissionType::kFence ? "Fence" : "Rally";
                         });

}  // namespace
}  // namespace cas::fcu
