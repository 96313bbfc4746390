// SPDX-License-Identifier: BSD-3-Clause
// flight.mcap of a whole flight, read back and held to the run's other records.
#include "hils/mcap/run_mcap.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>

#include "base/error.hpp"
#include "hils/mcap/read_mcap.hpp"
#include "hils/replay/replay_record.hpp"
#include "tests/closed_loop/flight_fixture.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

using OrderedJson = nlohmann::ordered_json;

class FlightMcap : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new cas::test::TemporaryFolder;
    request_ = new RunRequest;
    request_->scenario = test::hover();
    request_->seed = 2;
    request_->out = folder_->path();
    run_ = new RunResult(evaluate(*request_, run_on_virtual_clock(*request_)));
    truth_ = new std::string(test::content(*folder_ / "truth.csv"));
    tlog_ = new std::string(test::content(*folder_ / "flight.tlog"));
    write_mcap(*request_, *run_);
  }
  static void TearDownTestSuite() {
    delete tlog_;
    delete truth_;
    delete run_;
    delete request_;
    delete folder_;
  }
  static std::filesystem::path file() { return *folder_ / "flight.mcap"; }

  static inline const cas::test::TemporaryFolder* folder_ = nullptr;
  static inline RunRequest* request_ = nullptr;
  static inline const RunResult* run_ = nullptr;
  static inline const std::string* truth_ = nullptr;
  static inline const std::string* tlog_ = nullptr;
};

TEST_F(FlightMcap, IsTheSameEachTimeAndLeavesTheOtherRecordsAlone) {
  const std::string bytes = test::content(file());
  write_mcap(*request_, *run_);
  EXPECT_TRUE(test::content(file()) == bytes);
  EXPECT_TRUE(test::content(*folder_ / "truth.csv") == *truth_);
  EXPECT_TRUE(test::content(*folder_ / "flight.tlog") == *tlog_);
}

TEST_F(FlightMcap, GivesTheReplayOfTheRun) {
  const OrderedJson of_run = OrderedJson::parse(replay_record(*request_, *run_));
  const OrderedJson of_mcap = OrderedJson::parse(mcap_record(file()));
  for (const char* key : {"format", "cas", "name", "description", "seed", "architecture"}) {
    EXPECT_EQ(of_mcap.at(key), of_run.at(key)) << key;
  }
  EXPECT_NEAR(of_mcap.at("duration_s").get<double>(), of_run.at("duration_s").get<double>(), 0.1);
  const OrderedJson& flown = of_run.at("vehicles").at(0);
  const OrderedJson& read = of_mcap.at("vehicles").at(0);
  for (const char* key : {"name", "system", "truth", "reference"}) {
    EXPECT_TRUE(read.at(key) == flown.at(key)) << key;
  }
  EXPECT_EQ(read.at("scene").at("rotors").size(), flown.at("scene").at("rotors").size());
  EXPECT_EQ(read.at("log").at("states"), flown.at("log").at("states"));
  EXPECT_EQ(read.at("log").at("texts"), flown.at("log").at("texts"));
  std::map<std::string, OrderedJson> messages;
  for (const OrderedJson& message : read.at("log").at("messages")) {
    messages[message.at("name").get<std::string>()] = message;
  }
  ASSERT_GT(flown.at("log").at("messages").size(), 5U);
  for (const OrderedJson& message : flown.at("log").at("messages")) {
    const std::string name = message.at("name").get<std::string>();
    EXPECT_TRUE(messages[name] == message) << name;
  }
}

TEST_F(FlightMcap, OfAFileThatIsCutIsReadUpToTheCut) {
  const std::string bytes = test::content(file());
  const auto cut = folder_->write("cut.mcap", std::string_view(bytes).substr(0, bytes.size() / 2));
  testing::internal::CaptureStderr();
  const OrderedJson record = OrderedJson::parse(mcap_record(cut));
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_TRUE(said.starts_with(cut.string() + ": the recording is not whole: it ends within the "
                                              "record at byte "))
      << said;
  EXPECT_GT(record.at("duration_s").get<double>(), 20);
  EXPECT_LT(record.at("duration_s").get<double>(), 40);
}

TEST_F(FlightMcap, OfAFileWithAFlippedByteIsRefusedWithItsPlace) {
  std::string bytes = test::content(file());
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 0x10);
  const auto broken = folder_->write("broken.mcap", bytes);
  const std::string sentence = cas::test::refusal([&] { mcap_record(broken); });
  EXPECT_TRUE(sentence.starts_with(broken.string() + ": byte ")) << sentence;
  EXPECT_NE(sentence.find("the chunk"), std::string::npos) << sentence;
}

TEST_F(FlightMcap, HasTheTopicsAndFieldsOfItsPage) {
  const std::string page = test::content(cas::test::source_dir() + "/docs/use/mcap.md");
  struct Rows final : McapListener {
    explicit Rows(const std::string& text) : page(text) {}
    void on_message(const McapChannel& channel, std::uint64_t, std::string_view data) override {
      if (channel.topic.starts_with("/mavlink/") || !topics.insert(channel.topic).second) return;
      const std::size_t row = page.find("| `" + channel.topic + "` | `" + channel.schema + "`");
      ASSERT_NE(row, std::string::npos) << channel.topic;
      if (!channel.schema.starts_with("cas.")) return;
      const std::string line = page.substr(row, page.find('\n', row) - row);
      const OrderedJson fields = OrderedJson::parse(data);
      for (const auto& [field, value] : fields.items()) {
        if (field == "timestamp" || field == "vehicle") continue;
        EXPECT_NE(line.find("`" + field + "`"), std::string::npos) << channel.topic << field;
      }
    }
    const std::string& page;
    std::set<std::string> topics;
  } rows(page);
  EXPECT_FALSE(read_mcap(test::content(file()), rows));
  EXPECT_EQ(rows.topics.size(), 9U);
}

}  // namespace
}  // namespace cas::hils
