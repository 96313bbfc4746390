// SPDX-License-Identifier: BSD-3-Clause
#include "casd/counters/link_counters.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <iterator>

#include "base/error.hpp"
#include "casd/tlog/tlog_writer.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "tests/casd/packets.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::casd::test {
namespace {

using std::chrono::seconds;

TEST(MessageCounters, CountByMessageAndSender) {
  MessageCounters counters;
  for (int i = 0; i < 5; ++i) counters.add(107, {1, 200}, at(milliseconds(i)));
  counters.add(107, {2, 200}, at({}));
  counters.add(16'777'215, {255, 255}, at({}));
  std::map<std::pair<std::uint32_t, mav::Source>, std::uint64_t> found;
  counters.for_each([&](const auto& entry) {
    found[{entry.message_id, entry.source}] = entry.count;
    if (entry.count == 5) {
      EXPECT_EQ(entry.last, at(milliseconds(4)));
    }
  });
  EXPECT_EQ((found[{107, {1, 200}}]), 5U);
  EXPECT_EQ((found[{107, {2, 200}}]), 1U);
  EXPECT_EQ((found[{16'777'215, {255, 255}}]), 1U);
}

TEST(MessageCounters, SayWhenThereAreTooManyKinds) {
  MessageCounters counters;
  for (std::uint32_t id = 0; id < 5000; ++id) counters.add(id, {1, 1}, at({}));
  std::uint64_t counted = 0;
  counters.for_each([&](const auto&) { ++counted; });
  EXPECT_EQ(counted + counters.uncounted(), 5000U);
  EXPECT_GT(counted, 1900U);
}

/// A flood of invented senders, a moment after the vehicle.
void invent_senders(MessageCounters& counters, base::RunTime now) {
  for (int i = 0; i < 5000; ++i) {
    const auto system = static_cast<std::uint8_t>(2 + i / 200);
    counters.add(0, {system, static_cast<std::uint8_t>(1 + i % 200)}, now);
  }
}

TEST(MessageCounters, ShrinkAgainAfterInventedSenders) {
  MessageCounters counters;
  counters.add(0, {1, 1}, at({}));
  invent_senders(counters, at(seconds(1)));
  EXPECT_GT(counters.kinds(at(seconds(2))).size(), 1900U);
  counters.add(0, {1, 1}, at(seconds(40)));
  const auto kinds = counters.kinds(at(seconds(40)));
  EXPECT_EQ(kinds.size(), MessageCounters::kRestingKinds);
  EXPECT_TRUE(std::ranges::any_of(kinds, [](const MessageCounters::Entry& entry) {
    return entry.source == mav::Source{1, 1} && entry.count == 2 && entry.since == at({});
  }));
}

TEST(MessageCounters, AFewKindsAreKeptHoweverLongTheyAreSilent) {
  MessageCounters counters;
  for (std::uint32_t id = 0; id < MessageCounters::kRestingKinds; ++id) {
    counters.add(id, {1, 1}, at({}));
  }
  EXPECT_EQ(counters.kinds(at(seconds(86'400))).size(), MessageCounters::kRestingKinds);
}

TEST(MessageCounters, ANewSenderGetsThePlaceOfOneThatFellSilent) {
  MessageCounters counters;
  invent_senders(counters, at({}));
  const std::uint64_t before = counters.uncounted();
  for (std::uint32_t id = 0; id < 50; ++id) counters.add(id, {1, 1}, at(seconds(1)));
  EXPECT_GT(counters.uncounted(), before) << "the senders of a second ago are kept";
  const std::uint64_t full = counters.uncounted();
  for (std::uint32_t id = 0; id < 50; ++id) {
    for (int i = 0; i < 3; ++i) counters.add(id, {1, 1}, at(seconds(60)));
  }
  EXPECT_EQ(counters.uncounted(), full);
  const auto kinds = counters.kinds(at(seconds(60)));
  EXPECT_EQ(std::ranges::count_if(kinds,
                                  [](const MessageCounters::Entry& entry) {
                                    return entry.source == mav::Source{1, 1} && entry.count >= 3;
                                  }),
            50);
}

TEST(LinkFigures, PagesBeginWithWhoWasHeardFirst) {
  LinkFigures figures;
  const auto gcs = figures.add_link(2, "gcs", LinkType::kUdp);
  const auto fcu = figures.add_link(3, "fcu", LinkType::kSerial);
  fcu->rx.messages.add(30, {1, 1}, at({}));
  invent_senders(gcs->rx.messages, at(seconds(1)));
  fcu->rx.messages.add(30, {1, 1}, at(seconds(2)));
  const auto all = figures.messages(at(seconds(2)));
  const auto first = figures.messages(at(seconds(2)), {}, {.limit = 10});
  const auto second = figures.messages(at(seconds(2)), {}, {.offset = 10, .limit = 10});
  ASSERT_EQ(first.size(), 10U);
  EXPECT_EQ(first[0].name, "ATTITUDE");
  ASSERT_EQ(second.size(), 10U);
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(first[i].source, all[i].source);
    EXPECT_EQ(second[i].source, all[i + 10].source);
  }
  EXPECT_TRUE(figures.messages(at(seconds(2)), {}, {.offset = all.size()}).empty());
  EXPECT_EQ(figures.messages(at(seconds(2)), "fcu").size(), 1U);
}

TEST(LinkFigures, APageOfDropsHasNothingElse) {
  LinkFigures figures;
  const auto link = figures.add_link(3, "fcu", LinkType::kSerial);
  PacketInfo info;
  link->rx.messages.add(0, {1, 1}, at({}));
  link->count_dropped(info, DropCause::kClosed, at({}));
  const auto drops = figures.messages(at({}), {}, {.drops_only = true});
  ASSERT_EQ(drops.size(), 1U);
  EXPECT_EQ(drops[0].way.cause, DropCause::kClosed);
  EXPECT_EQ(figures.dropped(), 1U);
}

TEST(LinkFigures, ASenderThatWasForgottenBeginsAtRateZero) {
  LinkFigures figures;
  const auto link = figures.add_link(3, "fcu", LinkType::kSerial);
  for (int i = 0; i < 100; ++i) link->rx.messages.add(30, {1, 1}, at({}));
  figures.sample(at({}));
  invent_senders(link->rx.messages, at(seconds(40)));
  figures.sample(at(seconds(41)));
  link->rx.messages.add(30, {1, 1}, at(seconds(42)));
  figures.sample(at(seconds(42)));
  for (const MessageStatus& message : figures.messages(at(seconds(42)))) {
    EXPECT_LT(message.hz, 1000) << message.source.system;
  }
}

TEST(LinkCounters, KeepsWhatDeniesSendingUntilAPacketGoesOut) {
  LinkCounters counters("net", LinkType::kUdp);
  counters.note_send(ECONNREFUSED);
  EXPECT_EQ(counters.send_denied, 0);
  counters.note_send(EPERM);
  counters.note_send(EHOSTUNREACH);
  EXPECT_EQ(counters.send_denied, EPERM);
  counters.note_send(0);
  EXPECT_EQ(counters.send_denied, 0);
}

TEST(LinkFigures, FormsRatesFromTwoLooks) {
  LinkFigures figures;
  const auto link = figures.add_link(3, "fcu", LinkType::kSerial);
  figures.sample(at({}));
  for (int second = 1; second <= 5; ++second) {
    for (int i = 0; i < 400; ++i) link->rx.messages.add(91, {1, 1}, at(seconds(second)));
    figures.sample(at(seconds(second)));
  }
  const auto messages = figures.messages(at(seconds(5) + milliseconds(500)));
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(messages[0].link, "fcu");
  EXPECT_EQ(to_string(messages[0].way), "rx");
  EXPECT_EQ(messages[0].name, "HIL_CONTROLS");
  EXPECT_EQ(messages[0].count, 2000U);
  EXPECT_NEAR(messages[0].hz, 400, 1);
  EXPECT_NEAR(messages[0].age_s, 0.5, 1e-9);
}

TEST(LinkFigures, NamesWhoSendsToALinkUnlessSeveralDo) {
  LinkFigures figures;
  const auto sim = figures.add_link(1, "sim", LinkType::kUdp);
  const auto gcs = figures.add_link(2, "gcs", LinkType::kUdp);
  const auto fcu = figures.add_link(3, "fcu", LinkType::kSerial);
  EXPECT_FALSE(figures.sender_of(107, 3));
  sim->rx.messages.add(107, {1, 200}, at(seconds(1)));
  gcs->rx.not_accepted_messages.add(107, {1, 200}, at(seconds(1)));  // the same ids
  fcu->tx.messages.add(107, {1, 200}, at(seconds(1)));
  EXPECT_EQ(figures.sender_of(107, 3), (std::pair{mav::Source{1, 200}, LinkId{1}}));
  gcs->rx.messages.add(107, {2, 200}, at(seconds(2)));
  fcu->tx.messages.add(107, {2, 200}, at(seconds(2)));
  EXPECT_FALSE(figures.sender_of(107, 3));
  sim->rx.messages.add(107, {1, 200}, at(seconds(8)));
  fcu->tx.messages.add(107, {1, 200}, at(seconds(8)));
  EXPECT_TRUE(figures.sender_of(107, 3)) << "the other one has ended";
}

TEST(LinkFigures, ShowsLinksWithTheirStateAndForgetsThem) {
  LinkFigures figures;
  const auto link = figures.add_link(3, "fcu", LinkType::kSerial);
  link->state = LinkState::kUp;
  link->set_endpoint("/dev/ttyACM0");
  link->tx.dropped[0].add(7);
  const auto links = figures.links();
  ASSERT_EQ(links.size(), 1U);
  EXPECT_EQ(links[0].id, 3);
  EXPECT_EQ(links[0].endpoint, "/dev/ttyACM0");
  EXPECT_EQ(links[0].tx.dropped[0], 7U);
  figures.remove_link(3);
  EXPECT_TRUE(figures.links().empty());
}

TEST(LinkFigures, ForgetsTheTimesOfPacketsFromALinkThatIsGone) {
  LinkFigures figures;
  const auto fcu = figures.add_link(3, "fcu", LinkType::kSerial);
  figures.add_link(4, "gcs", LinkType::kUdp);
  PacketInfo info;
  for (const LinkId from : {LinkId{4}, kLocalLink}) {
    info.from = from;
    const PacketRef packet{&info, {}};
    fcu->count_sent({&packet, 1}, at({}), at(milliseconds(1)));
  }
  EXPECT_EQ(figures.links()[0].tx.routes.size(), 2U);
  figures.remove_link(4);
  figures.add_link(4, "lan", LinkType::kUdp);  // it gets the same id
  const auto routes = figures.links()[0].tx.routes;
  ASSERT_EQ(routes.size(), 1U);
  EXPECT_EQ(routes[0].from, kLocalLink);
}

TEST(LinkFigures, SaysWhatItsTablesHadNoRoomFor) {
  LinkFigures figures;
  const auto link = figures.add_link(3, "fcu", LinkType::kSerial);
  PacketInfo info;
  info.received = at({});
  for (; info.message_id < 5000; ++info.message_id) {
    link->rx.messages.add(info.message_id, {1, 1}, at({}));
    link->count_dropped(info, DropCause::kClosed, at({}));
  }
  EXPECT_EQ(figures.messages(at({})).size() + figures.links()[0].uncounted, 10'000U);
  EXPECT_GT(figures.links()[0].uncounted, 0U);
}

TEST(TlogWriter, WritesTimeAndPacketAsGroundStationsReadThem) {
  cas::test::TemporaryFolder folder;
  TlogWriter tlog;
  tlog.record(packet(mavlink::common::Heartbeat{}, {1, 1}).view(), base::steady_now());  // not open
  TlogRecording::Options options;
  options.files.folder = folder.path();
  options.files.name = "flight";
  tlog.start(options);
  const auto heartbeat = packet(mavlink::common::Heartbeat{}, {1, 1});
  const auto before = std::chrono::system_clock::now();
  tlog.record(heartbeat.view(), base::steady_now());
  tlog.stop();
  std::ifstream file(folder / "flight.tlog", std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
  ASSERT_EQ(bytes.size(), 8 + heartbeat.size);
  std::uint64_t stamp = 0;
  for (int i = 0; i < 8; ++i) {
    stamp = stamp << 8U | static_cast<std::uint8_t>(bytes[static_cast<std::size_t>(i)]);
  }
  const auto expected =
      std::chrono::duration_cast<std::chrono::microseconds>(before.time_since_epoch());
  EXPECT_NEAR(static_cast<double>(stamp), static_cast<double>(expected.count()), 2e6);
  EXPECT_EQ(static_cast<std::uint8_t>(bytes[8]), mav::kStartV2);
}

TEST(TlogWriter, FileThatCannotBeMadeIsAnError) {
  TlogWriter tlog;
  TlogRecording::Options options;
  options.files.folder = "/nonexistent/folder";
  options.files.name = "flight";
  EXPECT_THROW(tlog.start(options), base::ConfigError);
  EXPECT_FALSE(tlog.active());
}

}  // namespace
}  // namespace cas::casd::test
